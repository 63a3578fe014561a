"""Checks of solved points by other means than those that solved them."""
