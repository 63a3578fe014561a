"""Figures that tell whether a mesh can be trusted."""
