"""Finite elements of linear elasticity, and their stiffness and mass."""
