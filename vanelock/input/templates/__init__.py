"""The commented files that `vanelock init` writes."""
