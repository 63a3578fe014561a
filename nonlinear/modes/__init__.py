"""Damped nonlinear modes: the structure excited by itself so that it vibrates freely for good."""
