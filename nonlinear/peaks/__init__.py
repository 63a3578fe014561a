"""Peaks of a resonance, their gradients, and how they follow force, friction or interference."""
