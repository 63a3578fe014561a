"""Plots of contacts: hysteresis loops, and the state at rest."""
