"""Modes of a part whose masters are held, and how many of them are kept."""
