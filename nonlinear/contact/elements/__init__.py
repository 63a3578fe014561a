"""Elements that follow laws of their own, by alternating frequency and time."""
