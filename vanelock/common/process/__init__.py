"""Memory, signals and streams of the process."""
