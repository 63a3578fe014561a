"""What the harmonic balance of one sector is of: reduced matrices, contacts, forces."""
