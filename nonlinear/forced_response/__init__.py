"""The response over frequency: the balance solved at each, linear limits, the state at rest."""
