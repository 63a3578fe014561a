"""Rings whose sectors are not alike."""
