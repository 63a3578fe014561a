"""The contact law: springs that stick, slip and lift off, over one period."""
