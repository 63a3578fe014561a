"""Trigonometric polynomials, compiled, and how many threads they get."""
