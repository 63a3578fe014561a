"""Steel, all kinds of elements, and a shape that makes no two of them alike."""

import numpy as np

from vanelock.fem import Material
from vanelock.mesh.cells import SOLIDS

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
CELLS = list(SOLIDS)


def bent(p):
    """The unit cube as a block of 0.4 x 0.3 x 0.2 m with curved sides."""
    return p * [0.4, 0.3, 0.2] + 0.03 * np.sin(3 * p[:, [1, 2, 0]])
