"""Where a slider that follows a disc is at given angles, on the pieces of its located path."""

import numpy as np

from vanelock.nonlinear.contact.isotropic.disc_integrals import BEGIN, END, KIND, STEP, X, Y
from vanelock.nonlinear.contact.isotropic.disc_slider import FREE, HELD
from vanelock.nonlinear.contact.isotropic.disc_slip import NODES, STAGES
from vanelock.nonlinear.contact.isotropic.located_law import slider_pieces
from vanelock.nonlinear.fourier.trigonometric import TURN, Floats, basis, grid

_POWERS = np.arange(1, STAGES + 1)
_THROUGH = np.linalg.inv(NODES[:, None] ** _POWERS)  # values at the nodes to coefficients


def slider_places(u: Floats, alpha: float, angles: Floats) -> Floats:
    """Places (s, 2) of a slider, m, on its periodic path.

    While it slips, z of its step (`disc_slip`) is the polynomial that was collocated.
    """
    harmonics = u.shape[1] // 2
    pieces = slider_pieces(np.ascontiguousarray(u), alpha, grid(harmonics))
    first = pieces[0, BEGIN]
    wrapped = first + (angles - first) % TURN
    piece = pieces[np.searchsorted(pieces[:, BEGIN], wrapped, side="right") - 1]
    phi = basis(harmonics, angles)
    p, r = phi @ u[1:].T, alpha * (phi @ u[0])
    share = (wrapped - piece[:, BEGIN]) / (piece[:, END] - piece[:, BEGIN])
    z = np.einsum("sp,pi,si->s", share[:, None] ** _POWERS, _THROUGH, piece[:, STEP:])
    e0 = piece[:, X : Y + 1]
    turned = (1 - z**2)[:, None] * e0 + (2 * z)[:, None] * np.stack([-e0[:, 1], e0[:, 0]], axis=1)
    slipping = p - (r / (1 + z**2))[:, None] * turned
    kind = piece[:, [KIND]]
    places: Floats = np.where(kind == HELD, e0, np.where(kind == FREE, p, slipping))
    return places
