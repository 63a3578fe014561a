"""Measured curves: what files say of them, in SI."""
