"""Wear of the contacts over cycles of vibration, and what becomes of the vibration with it."""
