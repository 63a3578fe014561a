"""What a scene's run prints, draws and writes."""
