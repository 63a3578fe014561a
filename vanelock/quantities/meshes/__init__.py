"""Figures that show whether a mesh can be trusted."""
