"""Drawings of vane and casing with their dimensions."""
