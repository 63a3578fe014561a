"""Time integration of the whole ring, which assumes no period and no wave."""
