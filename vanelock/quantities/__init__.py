"""What an engineer reads off a run: margins, wear, energy, scatter, warnings."""
