"""Tables of what responses are worth and of what follows from them."""
