"""Aerofoils as solids, and the nodes that are prescribed on their faces."""
