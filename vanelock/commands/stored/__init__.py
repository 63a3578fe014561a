"""What a run left in its folder, read back: as one object, for a comparison, for its page."""
