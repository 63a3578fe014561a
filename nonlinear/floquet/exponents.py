"""Zeros of the characteristic matrix in a window: all of them, and counted another way.

Beyn's contour integrals (Linear Algebra Appl. 436 (2012) 3839-3863) turn them into eigenvalues,

    A_p = 1/2πi ∮ s^p S(s)⁻¹ ds,      B_p = [A_p, A_p+1; A_p+1, A_p+2],      B_0 = V Σ Wᴴ,
    zeros: eigenvalues of Vᴴ B_1 W Σ⁻¹

(blocks of two, as both poles of a mode may lie in the contour), and they are as many as det S turns
round zero along the window's edge.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.floquet.characteristic import Characteristic, Series
from vanelock.nonlinear.floquet.law_transfer import Transfer
from vanelock.nonlinear.floquet.perturbed_structure import PerturbedStructure, Rectangle

Complex = NDArray[np.complex128]
Matrix = Callable[[complex], Complex]

NODES = 64
RANK = 1e-11  # singular values of B_0, to the largest
SPURIOUS = 1e-4  # what is left of S a, to the norms of both
ATTEMPTS = ((3.0, 12), (3.0, 24), (8.0, 32), (20.0, 64))
"""How near poles of modes are told apart, and points of the series, until it converges."""
CONVERGED = 1e-5  # last terms of the series, to the largest
LARGEST = 500  # modes told apart


@dataclass(frozen=True)
class Zeros:
    """Zeros of S in a window.

    Attributes
    ----------
    series : Series
        What S is approximated by.
    each : list of (complex, (m,) complex)
        s, and amplitudes a of unit norm with S(s) a = 0.
    complete : bool
        Whether the winding of det S counts as many; False where the series does not converge.
    """

    series: Series
    each: list[tuple[complex, Complex]]
    complete: bool


def zeros(
    structure: Callable[[float], PerturbedStructure], law: Transfer, window: Rectangle
) -> Zeros:
    """All zeros in a window."""
    centre = (window.left + window.right) / 2
    radius = float(np.hypot(window.right - centre, window.half))  # through the corners
    series: Series | None = None
    for near, points in ATTEMPTS:
        characteristic = Characteristic(structure(near), law)
        if series is not None and characteristic.size > LARGEST:
            break
        series = characteristic.series(centre, radius, points)
        if series.error < CONVERGED:
            break
    assert series is not None
    found = [_improved(series, s, a) for s, a in beyn(series, centre, radius)]
    each = [pair for pair in found if pair is not None]
    known = np.array([s for s, _ in each], complex)
    inside = [pair for pair in each if window.distance(pair[0]) == 0]
    complete = series.error < CONVERGED and missed(series, window, known) == 0
    return Zeros(series, inside, complete)


def beyn(matrix: Matrix, centre: float, radius: float) -> Iterator[tuple[complex, Complex]]:
    """Zeros in a circle and their vectors (m,); some beyond it and spurious ones among them."""
    turn = np.exp(2j * np.pi * (np.arange(NODES) + 0.5) / NODES)
    inverse = np.array([np.linalg.inv(matrix(centre + radius * each)) for each in turn])
    moments = [np.tensordot(turn**p, inverse, 1) / NODES for p in range(1, 5)]
    first, second = (np.block([moments[p : p + 2], moments[p + 1 : p + 3]]) for p in (0, 1))
    left, size, right = np.linalg.svd(first)
    rank = int((size > RANK * size.max(initial=0.0)).sum())
    left, right = left[:, :rank], right[:rank].conj().T
    values, vectors = np.linalg.eig(left.conj().T @ second @ right / size[:rank])
    amplitudes = left[: inverse.shape[1]] @ vectors
    for value, a in zip(values, amplitudes.T, strict=True):
        yield complex(centre + radius * value), a


def _improved(series: Series, s: complex, a: Complex) -> tuple[complex, Complex] | None:
    """A zero and its vector of unit norm by two of Newton's steps for both; None if spurious."""
    matrix = series(s)
    if np.linalg.norm(matrix @ a) > SPURIOUS * np.linalg.norm(matrix) * np.linalg.norm(a):
        return None
    for _ in range(2):
        moved = np.linalg.solve(series(s), series.slope(s) @ a)
        s -= complex(np.vdot(a, a) / np.vdot(a, moved))
        a = np.asarray(moved / np.linalg.norm(moved))
    return s, a


def missed(matrix: Matrix, window: Rectangle, known: Complex) -> int:
    """Zeros in a window beside the known ones: turns of det S / Π(s - known) along its edge.

    Without the known zeros it varies slowly; steps are halved until none turns it by a radian.
    """
    left, right, half = window.left, window.right, 1j * window.half
    corners = np.array([left - half, right - half, right + half, left + half, left - half])

    def direction(t: float) -> complex:
        s = complex(np.interp(t, np.arange(5), corners))
        away = np.where(s == known, 1, s - known)
        turned = (away.conj() / np.abs(away)).prod()
        return complex(np.linalg.slogdet(matrix(s))[0] * turned)

    total, left_over = 0.0, list(np.linspace(4, 0, 97))
    t = left_over.pop()
    here = direction(t)
    while left_over:
        there = direction(left_over[-1])
        turned = float(np.angle(there * here.conjugate()))
        if abs(turned) > 1 and left_over[-1] - t > 1e-9:
            left_over.append((t + left_over[-1]) / 2)
            continue
        total += turned
        t, here = left_over.pop(), there
    return round(total / (2 * np.pi))
