"""Linear modes, cyclic symmetry, and the free motions of parts that nothing holds."""
