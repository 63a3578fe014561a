"""A run's folder read back: what it holds, and the object that shows it."""
