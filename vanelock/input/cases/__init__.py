"""Cases: swept, listed and scattered values, each checked as the key itself is."""
