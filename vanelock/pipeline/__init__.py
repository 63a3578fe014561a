"""Steps with keys, and the cache and journal that keep what they computed."""
