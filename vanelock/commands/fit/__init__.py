"""`vanelock fit`: parameters fitted to measured curves, and whether they can be believed."""
