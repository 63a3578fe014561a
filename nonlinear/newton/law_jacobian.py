"""The linearised law: dW/du of the contacts that deviate from sticking."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.nonlinear.contact.law import Deviation


@dataclass(frozen=True)
class Slope:
    """J = dW/du by contact: `contacts` (a,) and their `blocks` (a, 3m, 3, m), m = 2H + 1."""

    contacts: Integers
    blocks: Floats

    @property
    def m(self) -> int:
        """Number of coefficients 2H + 1."""
        return int(self.blocks.shape[3])

    @property
    def components(self) -> Integers:
        """(3a,) components of these contacts."""
        return np.asarray(3 * self.contacts[:, None] + np.arange(3)).reshape(-1)

    def __call__(self, u: Floats) -> Floats:
        """J u, (3a, m), of displacements (3a, m)."""
        a, width, _, m = self.blocks.shape
        product = self.blocks.reshape(a, width, 3 * m) @ u.reshape(a, 3 * m, 1)
        return product.reshape(3 * a, m)

    def columns(self, shapes: Sequence[Array]) -> Floats:
        """J times shapes of each harmonic (3a, r_h), complex but for h = 0: (a, 3m, Σ).

        The columns of a harmonic h >= 1 are those of its shapes, then of i times its shapes.
        """
        a = len(self.contacts)
        moved = [self.blocks[:, :, :, 0] @ shapes[0].real.reshape(a, 3, shapes[0].shape[1])]
        for h, shape in enumerate(shapes[1:], 1):
            wide = shape.reshape(a, 3, shape.shape[1])
            real, imaginary = wide.real, wide.imag
            parts = np.concatenate(
                [np.concatenate([real, -imaginary], 2), np.concatenate([imaginary, real], 2)], 1
            )
            both = self.blocks[:, :, :, 2 * h - 1 : 2 * h + 1].transpose(0, 1, 3, 2)
            moved.append(both.reshape(a, 3 * self.m, 6) @ parts)
        return np.concatenate(moved, axis=2)

    def transposed(self, form: Floats) -> Floats:
        """Jᵀ times a linear form (3a, m) of w, as one of u, (3a, m)."""
        a, width, _, m = self.blocks.shape
        product = form.reshape(a, 1, width) @ self.blocks.reshape(a, width, 3 * m)
        return product.reshape(3 * a, m)


def slope_of(deviation: Deviation, contacts: Integers) -> Slope:
    """The linearised law of some contacts."""
    m = deviation.w.shape[2]
    blocks = deviation.jacobian if len(contacts) == len(deviation.w) else None
    if blocks is None:
        blocks = deviation.jacobian[contacts]
    return Slope(contacts, blocks.reshape(len(contacts), 3 * m, 3, m))


def response_to(deviation: Deviation, rows: Integers, moved: Floats) -> Floats:
    """(dW/du) times a displacement (c, 3, 2H + 1), on the given components of w."""
    m = deviation.w.shape[2]
    functionals = deviation.jacobian.reshape(-1, 3 * m)[rows]
    rates: Floats = np.einsum("rk,rk->r", functionals, moved.reshape(-1, 3 * m)[rows // (3 * m)])
    return rates
