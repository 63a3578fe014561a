"""Bounds of a peak over the static friction that equilibrium leaves open."""
