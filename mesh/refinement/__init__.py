"""How many unknowns a mesh has, and how fine it must be for an error."""
