"""The commands: each checks what it was given, computes, and writes."""
