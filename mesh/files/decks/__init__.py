"""Decks of Abaqus and Nastran: their keywords and cards, and the meshes that they list."""
