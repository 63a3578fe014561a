"""Routes of reduction: Craig-Bampton, cyclic symmetry and Tran."""
