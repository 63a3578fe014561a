"""Every key of a study and of a scene: unit, default, limits, description."""
