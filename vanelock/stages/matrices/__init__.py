"""Components from matrices, and what joins them to a system."""
