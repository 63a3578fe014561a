"""Readers of matrices, one format each."""
