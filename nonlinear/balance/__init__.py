"""The balance of all harmonics, condensed to the contacts, and the linear structure around it."""
