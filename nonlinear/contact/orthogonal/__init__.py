"""Friction bounded in each tangential direction by itself."""
