"""Steps from matrices and contacts by node lists to a response."""
