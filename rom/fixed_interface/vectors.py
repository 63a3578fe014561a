"""Which fixed-interface vectors to keep: a number of modes, all below a frequency, or by accuracy.

A Craig-Bampton model answers static loads on its masters exactly. What it misses is the dynamics
of the slaves that its vectors B leave out: at ω, the masters' dynamic stiffness is too large by

    ω⁴ E,    E = Lᴴ [(K_ss - ω² M_ss)⁻¹ - B (Bᴴ (K_ss - ω² M_ss) B)⁻¹ Bᴴ] L ≥ 0,

for ω below the fixed-interface modes left out. A mode of any structure that the part belongs to,
of unit mass and frequency ω, moves its masters so that x_mᴴ K_mm x_m ≤ ω² and
x_mᴴ M̃ x_m ≤ 1, since stiffness and mass of other parts and of joints are positive, with M̃ the
least mass that moves with x_m when the fixed-interface modes up to 2ω move as they like; those
above ω move along with the masters and only add to it. The frequencies of all such structures up
to ω are therefore in error by

    δω/ω = ω² x_mᴴ E x_m / 2 ≤ largest eigenvalue of (ω² E, K_mm/ω² + M̃),

whatever the joints do. So the eigenvectors x of that pencil, with their static answers Y x, are
the vectors worth keeping: those whose eigenvalue exceeds the accuracy. First E is taken at ω = 0,
where it costs nothing more; the vectors kept leave an error of higher order in ω, whose residual
is treated in the same way until each is below the accuracy. What the steps leave acts together, so
the largest eigenvalue of all of it can lie a little above; the errors themselves lie well below.
(That static answers to inertia forces are worth more than further modes is known as modal
truncation augmentation: Dickens, Nakagawa and Wittbrodt, Computers & Structures 62 (1997) 985-998;
their choice by this bound is our own.)
"""

from dataclasses import replace

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from vanelock.fem.vibration.block_lanczos import KrylovSpace
from vanelock.rom.fixed_interface.candidates import Candidates, inertia_loads
from vanelock.rom.fixed_interface.held import HeldPart, hermitian
from vanelock.rom.fixed_interface.modes import fixed_modes
from vanelock.rom.system.system import Matrix

MARGIN = 2.0
"""Modes up to this multiple of the highest frequency are kept exactly."""
LEVELS = 6
"""Times at which what is left of the error is treated again."""
RESERVE = 12
"""Vectors known beyond those needed, so that all nodal diameters may keep equally many."""
_ROUND_OFF = 1e-12


def accurate(part: HeldPart, accuracy: float, highest: float, space: KrylovSpace) -> Candidates:
    """Vectors for frequencies up to `highest` within a relative error."""
    modes = fixed_modes(space, below=MARGIN * highest)
    chosen = Candidates.exactly(modes)
    if np.isinf(modes.complete) or part.K_mm.size == 0:
        return chosen
    bound = (1 - MARGIN**-2) * accuracy  # E at ω exceeds E at 0 by no more
    m_j = part.inertia.gather(modes.vectors).conj().T
    E = part.compliance - (m_j.conj().T / modes.omega_squared) @ m_j
    metric = part.K_mm / highest**2 + part.M_mm - m_j.conj().T @ m_j
    error, X = _pencil(highest**2 * E, metric)
    first = int(np.sum(error > bound))
    # Inertia forces without what the modes take up, and their static answers.
    if first:
        loads = inertia_loads(part, modes, X[:, :first])
        answers = part.held.solve(loads)
        chosen = chosen.grown(part, answers, loads)
        for _ in range(LEVELS):
            left, worst = _missing(part, chosen, loads, answers, bound, highest)
            if left.shape[1] == 0:
                break
            chosen = chosen.grown(part, part.held.solve(left), left)
            loads, answers = loads @ worst, answers @ worst
    every = space.shape[1]
    if chosen.count >= every:  # a small part in a wide band
        return Candidates.exactly(fixed_modes(space, every))
    most = min(first + RESERVE, int(np.sum(error > _ROUND_OFF * error[0])))
    return replace(chosen, spare=X[:, first : min(most, first + every - chosen.count)])


def _missing(
    part: HeldPart,
    chosen: Candidates,
    loads: Matrix,
    answers: Matrix,
    bound: float,
    highest: float,
) -> tuple[Matrix, Matrix]:
    """What the vectors leave of loads at the highest frequency where that is too much.

    The second matrix combines the loads to those that still cause too large an error. All static
    answers to what is left are known, but for round-off, which is enough to choose by.
    """
    W, Phi = chosen.vectors, chosen.modes.vectors
    D = chosen.stiffness - highest**2 * chosen.mass
    c = sl.solve(D, W.conj().T @ loads, assume_a="her")
    left = loads - chosen.loads @ c + highest**2 * (part.M_ss @ (W @ c))
    of_modes = Phi.conj().T @ left
    left -= part.M_ss @ (Phi @ of_modes)
    more = answers - W @ c + highest**2 * (chosen.answers @ c)
    more -= Phi @ (of_modes / chosen.modes.omega_squared[:, None])
    error, V = sl.eigh(highest**2 * hermitian(left.conj().T @ more))
    worst = V[:, error > bound]
    return left @ worst, worst


def _pencil(A: Matrix, B: Matrix) -> tuple[NDArray[np.float64], Matrix]:
    """Eigenvalues of (A, B), descending, with XᴴBX = 1; B scaled to a unit diagonal first.

    What has neither stiffness nor mass in B, as a rotation that the part does not resist, is left
    out.
    """
    own = np.diagonal(B).real
    if not np.all(kept := own > 1e-13 * own.max()):
        values, some = _pencil(A[np.ix_(kept, kept)], B[np.ix_(kept, kept)])
        X = np.zeros((len(B), len(values)), some.dtype)
        X[kept] = some
        return values, X
    scale = 1 / np.sqrt(own)
    values, V = sl.eigh(
        hermitian(scale[:, None] * A * scale), hermitian(scale[:, None] * B * scale)
    )
    return values[::-1], (scale[:, None] * V)[:, ::-1]
