"""Dimensions, outlines and named places, before anything is meshed."""
