"""Linear elasticity: stiffness and mass, sparse factorisation, linear modes."""
