"""Cyclic symmetry of a reduced sector: the right face follows the left one.

In cylindrical components x_r = x_l e^{-iφ}, φ = 2π ND/N; in Cartesian ones the vectors of the right
face are also turned by 2π/N about the engine axis.
"""

import scipy.sparse as sp

from vanelock.common.cyclic import phase_factor, turn


def cyclic_constraint(faces: int, others: int, nodal_diameter: int, sectors: int) -> sp.csr_array:
    """W_cs in (x_l, x_r, others) = W_cs (x_l, others)."""
    follow = phase_factor(nodal_diameter, sectors) * turn(sectors)
    left = sp.vstack([sp.eye_array(3 * faces), sp.kron(sp.eye_array(faces), follow)])
    return sp.csr_array(sp.block_diag([left, sp.eye_array(others)]))
