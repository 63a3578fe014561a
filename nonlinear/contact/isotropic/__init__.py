"""Friction bounded in the tangential plane."""
