"""Contacts and structure stepped through a period together, compiled.

Within a step the relative displacements run straight from where they are to where they come to
rest at its end, u = u_known + G w, G the motion that a deviation w causes within the step. Along
a straight path the contact law is exact: a slider that meets its bound goes with it, and one that
comes back into contact holds on where the path crosses v = 0. What is left to find are the
deviations of all contacts at the end of the step, one scalar problem each that is solved exactly,
in turn, until none of them changes (nonlinear Gauss-Seidel).
"""

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.compiled import kernel

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]

SWEEPS = 400  # a step that takes more is counted as not solved


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
    u: Floats, coupling: Floats, sector: int, column: int, change: float, listed: NDArray[np.int64]
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
def _sweep(
    u: Floats,
    w: Floats,
    u_before: Floats,
    w_before: Floats,
    coupling: Floats,
    alpha: Floats,
    listed: NDArray[np.int64],
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
def _gather(moved: Complex, known: Floats, shift: Complex, weight: Floats, u: Floats) -> None:
    """Displacements u (N, d): what is known plus amplitudes (k, d) by diameter."""
    u[:, :] = known
    for k in range(moved.shape[0]):
        for j in range(u.shape[0]):
            turn = weight[k] * shift[k, j]
            for a in range(u.shape[1]):
                u[j, a] += turn.real * moved[k, a].real - turn.imag * moved[k, a].imag


@kernel
def _predict(
    state: Complex, load: Complex, transition: Floats, hold: Floats, predicted: Complex
) -> None:
    """States (k, 3, n) at the end of the step under the load at its beginning."""
    for k in range(state.shape[0]):
        for e in range(3):
            for m in range(state.shape[2]):
                predicted[k, e, m] = (
                    transition[k, e, 0, m] * state[k, 0, m]
                    + transition[k, e, 1, m] * state[k, 1, m]
                    + transition[k, e, 2, m] * state[k, 2, m]
                    + hold[k, e, m] * load[k, m]
                )


@kernel
def _changes(w: Floats, w_before: Floats, shift: Complex, out: Complex) -> NDArray[np.int64]:
    """Changes of the deviations in a step by diameter (k, d), and which columns are not zero."""
    sectors = w.shape[0]
    out[:] = 0.0
    changed = np.empty(w.shape[1], np.int64)
    count = 0
    for a in range(w.shape[1]):
        found = False
        for j in range(sectors):
            change = (w[j, a] - w_before[j, a]) / sectors
            if change != 0.0:
                found = True
                for k in range(out.shape[0]):
                    out[k, a] += np.conj(shift[k, j]) * change
        if found:
            changed[count] = a
            count += 1
    return changed[:count]


@kernel
def _awaken(u: Floats, w: Floats, u_before: Floats, alpha: Floats, awake: Flags) -> bool:
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


@kernel
def march(
    linear: Floats,
    rows: Complex,
    transition: Floats,
    hold: Floats,
    rise: Floats,
    rigid: Complex,
    response: Complex,
    coupling: Floats,
    shift: Complex,
    weight: Floats,
    stiffness: Floats,
    alpha: Floats,
    small: float,
    state: Complex,
    load: Complex,
    static: Complex,
    u: Floats,
    w: Floats,
    awake: Flags,
    path: Floats,
    places: Floats,
    motion: Complex,
) -> tuple[int, int]:
    """One period of all sectors; sweeps in all, and steps that were not solved.

    Parameters
    ----------
    linear : (s, N, 3c)
        Steady linear displacements at the end of each step.
    rows : (k, 3c, n)
        b of the modes that have inertia, by diameter.
    transition, hold, rise : (k, 3, 3, n), (k, 3, n), (k, 3, n)
        Their steps.
    rigid : (k, 3c, 3c)
        Column by column (as rows), displacements that a deviation causes through the other modes.
    response : (k, 3c, 3c)
        The same through all modes at the end of a step.
    coupling : (N, 3c, 3c)
        The same from sector 0 to each.
    shift, weight : (k, N), (k,)
        Of the ring.
    stiffness : (3c,)
    alpha : (c, 2)
    small : float
        Change of a deviation at which a step counts as solved, m.
    state, load, static, u, w : (k, 3, n), (k, n), (k, 3c), (N, 3c), (N, 3c)
        Updated: states, modal loads, static displacements, displacements and deviations.
    awake : (c,)
        Contacts that may deviate more; grows.
    path, places, motion : (s, N, 3c), (s, N, 3c), (s, k, n)
        Receive u, w and y at the end of each step.
    """
    steps = linear.shape[0]
    predicted = np.empty_like(state)
    known = np.empty_like(static)
    moved = np.empty_like(static)
    change = np.empty_like(static)
    total, unsolved = 0, 0
    for i in range(steps):
        u_before, w_before = u.copy(), w.copy()
        _predict(state, load, transition, hold, predicted)
        for k in range(rows.shape[0]):
            known[k] = np.dot(rows[k], predicted[k, 0]) + static[k]
        _gather(known, linear[i], shift, weight, u)
        while True:
            listed = np.flatnonzero(awake)
            solved = False
            for _ in range(SWEEPS):
                total += 1
                if _sweep(u, w, u_before, w_before, coupling, alpha, listed) <= small:
                    solved = True
                    break
            changed = _changes(w, w_before, shift, change)
            for k in range(rows.shape[0]):
                moved[k] = known[k]
                for a in changed:
                    moved[k] += response[k, a] * change[k, a]
            _gather(moved, linear[i], shift, weight, u)
            if not _awaken(u, w, u_before, alpha, awake):
                break
        if not solved:
            unsolved += 1
        for k in range(rows.shape[0]):
            push = np.zeros(state.shape[2], np.complex128)
            for a in changed:
                static[k] += rigid[k, a] * change[k, a]
                push += np.conj(rows[k, a]) * (stiffness[a] * change[k, a])
            load[k] += push
            for e in range(3):
                state[k, e] = predicted[k, e] + rise[k, e] * push
            motion[i, k] = state[k, 0]
        path[i] = u
        places[i] = w
    return total, unsolved
