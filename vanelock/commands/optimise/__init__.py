"""`vanelock optimise`: joints whose largest peak is the smallest."""
