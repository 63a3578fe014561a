"""Supernodal factors of CHOLMOD, read out and solved with panel by panel."""
