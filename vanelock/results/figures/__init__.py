"""Figures of a run, each with its caption and the numbers that it shows."""
