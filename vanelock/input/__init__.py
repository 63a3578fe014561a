"""What files may say, and how they are read: studies, scenes, measured curves."""
