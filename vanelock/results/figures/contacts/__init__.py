"""Figures of contacts: at rest, their loops, their states around a resonance, their wear."""
