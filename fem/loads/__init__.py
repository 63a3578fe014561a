"""Loads at rest: pressure on faces, heat, rotation."""
