"""Peaks over planes of two parameters, and where each statement holds."""
