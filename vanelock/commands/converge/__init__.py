"""`vanelock converge`: error against cost, each setting raised alone."""
