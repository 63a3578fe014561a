"""Figures that decide whether a mesh can be trusted."""
