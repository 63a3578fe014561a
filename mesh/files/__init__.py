"""Meshes read from the files of other programs, and written for them."""
