"""Quantities of contacts: where they are, the energy they take, their wear."""
