"""Steps with keys, the cache that keeps what they computed, and who computes them."""
