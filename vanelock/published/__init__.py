"""The published study on any scene: its figures, its statements, where they hold."""
