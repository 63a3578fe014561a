"""Sparse factorisation by CHOLMOD, PARDISO or SuperLU, and what is made of it."""
