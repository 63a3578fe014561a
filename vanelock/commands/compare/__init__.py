"""`vanelock compare`: two runs side by side."""
