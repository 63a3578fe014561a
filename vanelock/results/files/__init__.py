"""The folder of a run: its results file, and files drawn again when they have to."""
