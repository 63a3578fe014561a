"""Cyclic symmetry of a reduced sector: the right face follows the left one.

In cylindrical components x_r = x_l e^{-iφ}, φ = 2π ND/N; in Cartesian ones the vectors of the right
face are also turned by 2π/N about the engine axis.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray


def turn(sectors: int) -> NDArray[np.float64]:
    """(3, 3) rotation by one sector, 2π/N, about the engine axis z."""
    c, s = np.cos(2 * np.pi / sectors), np.sin(2 * np.pi / sectors)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def phase_factor(nodal_diameter: int, sectors: int) -> complex | float:
    """e^{-iφ}, exactly real at the diameters 0 and N/2."""
    if nodal_diameter % sectors == 0:
        return 1.0
    if 2 * nodal_diameter % sectors == 0:
        return -1.0
    return complex(np.exp(-2j * np.pi * nodal_diameter / sectors))


def cyclic_constraint(faces: int, others: int, nodal_diameter: int, sectors: int) -> sp.csr_array:
    """W_cs in (x_l, x_r, others) = W_cs (x_l, others).

    Parameters
    ----------
    faces : int
        Number of nodes on one face; the left nodes come first, then the right ones.
    others : int
        Number of coordinates that follow them.
    nodal_diameter, sectors : int
        ND and N.
    """
    follow = phase_factor(nodal_diameter, sectors) * turn(sectors)
    left = sp.vstack([sp.eye_array(3 * faces), sp.kron(sp.eye_array(faces), follow)])
    return sp.csr_array(sp.block_diag([left, sp.eye_array(others)]))
