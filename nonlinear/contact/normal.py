"""The normal direction of the contact law: a spring that lifts off."""

from typing import TypeAlias

import numpy as np

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.nonlinear.fourier import TURN, add_integrals, gram, kernel, value

CLOSED, PARTLY, ALWAYS = 0, 1, 2  # how much of a period a contact is open


Evaluated: TypeAlias = tuple[Floats, Floats, Integers, Booleans, Floats]


@kernel
def stuck(u: Floats) -> Evaluated:
    """W, dw/du, how much contacts are open, whether they slip, and their work, all of them zero."""
    c, _, m = u.shape
    w, jacobian = np.zeros(u.shape), np.zeros((c, 3, m, 3, m))
    return w, jacobian, np.zeros(c, np.int64), np.zeros(c, np.bool_), np.zeros(c)


@kernel
def scale(matrix: Floats) -> None:
    """Integrals over a period to Fourier coefficients: 1/2π of the first row, 1/π of the others."""
    for j in range(matrix.shape[0]):
        for k in range(matrix.shape[1]):
            matrix[j, k] /= TURN if j == 0 else 0.5 * TURN


@kernel
def place(block: Floats, contact: int, row: int, column: int, jacobian: Floats) -> None:
    """Put dw_row/du_column of one contact into the Jacobian of all."""
    for j in range(block.shape[0]):
        for k in range(block.shape[1]):
            jacobian[contact, row, j, column, k] = block[j, k]


@kernel
def add_normal(v: Floats, contact: Floats, count: int, w: Floats, jacobian: Floats) -> int:
    """min(v, 0) and its derivative, v changing sign at `contact`; CLOSED, PARTLY or ALWAYS open."""
    m = v.size
    if count == 0:
        if v[0] > 0.0:  # the mean has the sign; a single value may be a zero that v only touches
            return CLOSED
        for k in range(m):
            w[k] = v[k]
            jacobian[k, k] = 1.0
        return ALWAYS
    moments = np.zeros(m, np.complex128)
    first = 0 if value(v, 0.0) >= 0.0 else 1
    for i in range(first, count, 2):
        last = contact[i + 1] if i + 1 < count else contact[0] + TURN
        add_integrals(contact[i], last, moments)
    gram(moments, jacobian)
    scale(jacobian)
    for j in range(m):
        for k in range(m):
            w[j] += jacobian[j, k] * v[k]
    return PARTLY
