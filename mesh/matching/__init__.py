"""Meshes of two parts, one or both a user's own, matched node to node."""
