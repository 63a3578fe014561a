"""Tables of the study file on what responses are worth and what follows from them."""
