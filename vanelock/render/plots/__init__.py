"""Curves and diagrams."""
