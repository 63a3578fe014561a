"""Strain and stress of a displacement field, at nodes, on the surface and at gauges."""
