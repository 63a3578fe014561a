"""`vanelock check`: what is wrong in a file, or what a run of it would take."""
