"""`vanelock run`: every case computed, written and shown."""
