"""Friction contacts, harmonic balance and continuation on a System of arrays."""
