"""Stability of periodic vibrations: Floquet exponents by nodal diameter."""
