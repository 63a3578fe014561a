"""A response to an accuracy: one point as it was solved, and the curve through all of them."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vanelock.common.arrays import Floats
from vanelock.nonlinear import Response
from vanelock.nonlinear.adaptive.interpolant import Interpolant

PARTS = 12
"""Pieces of the curve drawn between neighbouring points."""
BEYOND = 0.5
"""How far, of their difference, a curve may leave the range of two points: further is a jump."""


def as_solved(response: Response, point: int) -> Response:
    """A point alone, with the harmonics that it was solved with and no more.

    A response to an accuracy has at every point as many as the most demanding one; what is above a
    point's own is zero there, which the contact law would not say.
    """
    found = response.at([point])
    if found.estimates is None:
        return found
    H = int(found.estimates.harmonics[0])
    kept = slice(H + 1)
    return replace(
        found,
        x={h: x for h, x in found.x.items() if h <= H},
        contact=found.contact[:, kept],
        force=found.force[:, kept],
        output=found.output[:, kept],
        harmonic_diameters=found.harmonic_diameters[kept],
    )


def drawn(response: Response, amplitude: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Frequencies, amplitudes and whether they converged, of the curve to draw."""
    plain = response.frequency, amplitude, response.converged
    order = np.argsort(response.frequency, kind="stable")
    f = response.frequency[order]
    if response.estimates is None or not response.converged.all() or len(f) < 3:
        return plain
    if np.any(np.diff(f) <= 0):
        return plain
    a = amplitude[order]
    share = np.arange(PARTS) / PARTS
    fine = (f[:-1, None] + np.diff(f)[:, None] * share).reshape(-1)
    cubic = Interpolant(f, a, response.estimates.slope[order]).at(fine).reshape(-1, PARTS)
    line = a[:-1, None] + np.diff(a)[:, None] * share
    room = BEYOND * np.abs(np.diff(a)) + 0.02 * np.maximum(a[:-1], a[1:])
    low, high = np.minimum(a[:-1], a[1:]) - room, np.maximum(a[:-1], a[1:]) + room
    smooth = np.all((cubic >= low[:, None]) & (cubic <= high[:, None]), axis=1)
    curve = np.where(smooth[:, None], cubic, line).reshape(-1)
    return np.append(fine, f[-1]), np.append(curve, a[-1]), np.ones(len(fine) + 1, bool)
