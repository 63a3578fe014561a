"""What of many cases is left to compute, in what order, and how long it takes."""
