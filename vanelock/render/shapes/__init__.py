"""Meshes, modes, responses and stresses on their shapes."""
