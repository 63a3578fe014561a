"""Reduced parts joined by ties and contacts, and the modes of what they make."""
