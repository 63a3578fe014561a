"""`vanelock check`: every mistake of a file, and what a run of it would take."""
