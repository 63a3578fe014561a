"""Three-dimensional scenes without a screen."""
