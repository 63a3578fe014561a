"""The linearised law: dW/du of the contacts that deviate from sticking."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.law import Deviation

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Slope:
    """J = dW/du, a block for each of some contacts.

    Attributes
    ----------
    contacts : (a,) int
    blocks : (a, 3m, 3, m) float
        m = 2H + 1.
    """

    contacts: Rows
    blocks: Floats

    @property
    def components(self) -> Rows:
        """(3a,) components of these contacts."""
        return np.asarray(3 * self.contacts[:, None] + np.arange(3)).reshape(-1)

    def __call__(self, u: Floats) -> Floats:
        """J u, (3a, m), of displacements (3a, m)."""
        a, width, _, m = self.blocks.shape
        product = self.blocks.reshape(a, width, 3 * m) @ u.reshape(a, 3 * m, 1)
        return product.reshape(3 * a, m)

    def transposed(self, form: Floats) -> Floats:
        """Jᵀ times a linear form (3a, m) of w, as one of u, (3a, m)."""
        a, width, _, m = self.blocks.shape
        product = form.reshape(a, 1, width) @ self.blocks.reshape(a, width, 3 * m)
        return product.reshape(3 * a, m)


def slope_of(deviation: Deviation, contacts: Rows) -> Slope:
    """The linearised law of some contacts."""
    m = deviation.w.shape[2]
    blocks = deviation.jacobian if len(contacts) == len(deviation.w) else None
    if blocks is None:
        blocks = deviation.jacobian[contacts]
    return Slope(contacts, blocks.reshape(len(contacts), 3 * m, 3, m))
