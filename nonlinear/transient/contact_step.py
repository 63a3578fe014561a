"""Contact elements at the end of a time step, compiled.

Within a step the relative displacements run straight from where they are to where they come to
rest at its end, u = known + G w, G the motion that the deviations w cause within the step. Along
a straight path the contact law is exact: a slider that meets its bound goes with it, and one that
comes back into contact holds on where the path crosses v = 0. The deviations at the end of the
step are one scalar problem each, solved exactly, in turn, until none changes (nonlinear
Gauss-Seidel).
"""

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.fourier.kernels import kernel

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Columns = NDArray[np.int64]


@kernel
def normal_deviation(known: float, own: float) -> float:
    """Deviation w = min(v, 0) where v = known + own w."""
    return min(known, 0.0) / (1.0 - own)


@kernel
def slider_place(
    known: float,
    own: float,
    held: float,
    u_before: float,
    v_before: float,
    v: float,
    alpha: float,
) -> float:
    """Place w of a slider at the end of a step, u = known + own w.

    Parameters
    ----------
    known, own : float
        u and what w adds to it.
    held : float
        w at the beginning.
    u_before, v_before : float
        Displacements at the beginning.
    v : float
        Normal displacement at the end.
    alpha : float
        μ kn/kt: the slider is no further than alpha v from u.
    """
    if v <= 0.0:
        return known / (1.0 - own)
    place = held
    if v_before < 0.0:  # touches down on the way, unstressed
        share = v_before / (v_before - v)
        place = ((1.0 - share) * u_before + share * known) / (1.0 - share * own)
    apart = known + own * place - place
    if apart > alpha * v:
        return (known - alpha * v) / (1.0 - own)
    if apart < -alpha * v:
        return (known + alpha * v) / (1.0 - own)
    return place


@kernel
def _spread(
    u: Floats, coupling: Floats, sector: int, column: int, change: float, listed: Columns
) -> None:
    """Move the listed contacts of all sectors by the change of one deviation."""
    sectors = u.shape[0]
    for i in range(sectors):
        row = coupling[(i - sector) % sectors, column]
        for c in listed:
            u[i, 3 * c] += row[3 * c] * change
            u[i, 3 * c + 1] += row[3 * c + 1] * change
            u[i, 3 * c + 2] += row[3 * c + 2] * change


@kernel
def sweep(
    u: Floats,
    w: Floats,
    u_before: Floats,
    w_before: Floats,
    coupling: Floats,
    alpha: Floats,
    listed: Columns,
) -> float:
    """Solve the listed contacts once, one after the other; the largest change of a deviation."""
    largest = 0.0
    for j in range(u.shape[0]):
        for c in listed:
            for e in range(3):
                a = 3 * c + e
                own = coupling[0, a, a]
                known = u[j, a] - own * w[j, a]
                if e == 0:
                    place = normal_deviation(known, own)
                else:
                    v_before, v = u_before[j, 3 * c], u[j, 3 * c]
                    place = slider_place(
                        known, own, w_before[j, a], u_before[j, a], v_before, v, alpha[c, e - 1]
                    )
                change = place - w[j, a]
                if change != 0.0:
                    w[j, a] = place
                    _spread(u, coupling, j, a, change, listed)
                    largest = max(largest, abs(change))
    return largest


@kernel
def follow(u: Floats, alpha: Floats, w: Floats) -> None:
    """Move the deviations w (N, 3c) along displacements u (s, N, 3c), which begin at u[0]."""
    for i in range(1, u.shape[0]):
        for j in range(u.shape[1]):
            for a in range(u.shape[2]):
                c = a // 3
                if a % 3 == 0:
                    w[j, a] = min(u[i, j, a], 0.0)
                else:
                    w[j, a] = slider_place(
                        u[i, j, a],
                        0.0,
                        w[j, a],
                        u[i - 1, j, a],
                        u[i - 1, j, 3 * c],
                        u[i, j, 3 * c],
                        alpha[c, a % 3 - 1],
                    )


@kernel
def awaken(u: Floats, w: Floats, alpha: Floats, awake: Flags) -> bool:
    """Mark sleeping contacts that no longer stick in some sector; whether there are any."""
    found = False
    for c in range(awake.size):
        if awake[c]:
            continue
        for j in range(u.shape[0]):
            v = u[j, 3 * c]
            for e in range(2):
                a = 3 * c + 1 + e
                if v < 0.0 or abs(u[j, a] - w[j, a]) > alpha[c, e] * v:
                    awake[c] = True
                    found = True
    return found
