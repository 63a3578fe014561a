"""What a mass matrix cannot be: negative on its diagonal, or a stiffness."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.labels import named

BALANCED = 1e-3
"""Sum of a row's entries along one direction, over that of their moduli, below which it is none."""


def check_mass(
    source: str, M: sp.csc_array, node: NDArray[np.int64], direction: NDArray[np.int64]
) -> None:
    """Refuse a matrix that is no mass.

    A row's entries along a direction add up to the inertia that it has as all moves that way. Those
    of a stiffness add up to the force that does so: none, but where the part is held.
    """
    own = M.diagonal().real
    if own.size and own.min() < 0:
        k = int(np.argmin(own))
        raise InputError(
            f"{source}: node {node[k]}, direction {named(int(direction[k]))}: the mass on the "
            f"diagonal is {own[k]:.3g}: it must be >= 0"
        )
    rows = balanced = 0
    for axis in range(3):
        along = np.flatnonzero(direction == axis)
        block = M[:, along].tocsr()[along]
        size = abs(block).sum(axis=1)
        rows += int(np.count_nonzero(size))
        balanced += int(np.sum(abs(block.sum(axis=1))[size > 0] < BALANCED * size[size > 0]))
    if rows and balanced > rows / 2:
        raise InputError(
            f"{source}: most of its rows add up to nothing along each direction, as those of a "
            "stiffness do: are stiffness and mass swapped?"
        )
