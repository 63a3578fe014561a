"""The steps from a file to a response, and which of them a case needs."""
