"""Paths of solutions: through folds, and from easy problems to the one that is posed."""
