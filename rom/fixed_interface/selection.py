"""Which fixed-interface vectors a reduction keeps: a number, up to a frequency, or by accuracy.

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

import math
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as sl

from vanelock.common.arguments import OfKind
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.fem.block_lanczos import KrylovSpace, krylov_space
from vanelock.rom.fixed_interface.basis import Candidates, Fixed, fixed_modes, inertia_loads
from vanelock.rom.fixed_interface.held import HeldPart, hermitian, lowest
from vanelock.rom.system.system import Matrix

_MARGIN = 2.0  # modes up to this multiple of the highest frequency are kept exactly
_LEVELS = 6  # times at which what is left of the error is treated again
_RESERVE = 12
"""Vectors known beyond those needed, so that all nodal diameters may keep equally many."""
_ROUND_OFF = 1e-12


def _accurate(part: HeldPart, accuracy: float, highest: float, space: KrylovSpace) -> Candidates:
    """Vectors for frequencies up to `highest` within a relative error."""
    modes = fixed_modes(space, below=_MARGIN * highest)
    chosen = Candidates.exactly(modes)
    if np.isinf(modes.complete) or part.K_mm.size == 0:
        return chosen
    bound = (1 - _MARGIN**-2) * accuracy  # E at ω exceeds E at 0 by no more
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
        for _ in range(_LEVELS):
            left, worst = _missing(part, chosen, loads, answers, bound, highest)
            if left.shape[1] == 0:
                break
            chosen = chosen.grown(part, part.held.solve(left), left)
            loads, answers = loads @ worst, answers @ worst
    every = space.shape[1]
    if chosen.count >= every:  # a small part in a wide band
        return Candidates.exactly(fixed_modes(space, every))
    most = min(first + _RESERVE, int(np.sum(error > _ROUND_OFF * error[0])))
    return replace(chosen, spare=X[:, first : min(most, first + every - chosen.count)])


def _missing(
    part: HeldPart, chosen: Candidates, loads: Matrix, answers: Matrix, bound: float, highest: float
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


def _pencil(A: Matrix, B: Matrix) -> tuple[Floats, Matrix]:
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


_ELASTIC = 10  # by default the band reaches to the tenth elastic mode of the part, its masters free
_ROUGH = 0.03  # residual of the modes that set the band
DEFAULT = 1e-4
"""Accuracy unless modes, a cut-off or another accuracy is given."""


@dataclass(frozen=True)
class Selection(OfKind):
    """One of: a number of modes, a cut-off frequency, an accuracy.

    Attributes
    ----------
    modes : int or None
        Number of the lowest fixed-interface modes.
    cutoff : float or None
        All fixed-interface modes up to this frequency, Hz.
    accuracy : float or None
        Relative error of every natural frequency in the band, see `rom.fixed_interface.selection`.
    band : float or None
        Frequency up to which the accuracy holds, Hz; None: up to the part's tenth elastic mode.
    least : float or None
        Frequency that such a band of its own reaches at least, Hz.

    Raises
    ------
    InputError
        If more than one of them is given, or one is out of range.
    """

    modes: int | None = None
    cutoff: float | None = None
    accuracy: float | None = None
    band: float | None = None
    least: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        given = {"modes": self.modes, "cutoff": self.cutoff, "accuracy": self.accuracy}
        reaches = {"band": self.band, "least": self.least}
        named = [f"{name} = {value:g}" for name, value in given.items() if value is not None]
        if len(named) != 1:
            raise InputError(f"{' and '.join(named) or 'nothing given'}: give one of {_one(given)}")
        if self.modes is not None and self.modes < 0:
            raise InputError(f"modes = {self.modes}: allowed are 0 and more")
        for name, value in {"cutoff": self.cutoff, **reaches}.items():
            if value is not None and not (value > 0 and math.isfinite(value)):
                raise InputError(f"{name} = {value:g} Hz: must be > 0 and finite")
        if self.accuracy is not None and not 1e-9 <= self.accuracy < 1:
            raise InputError(f"accuracy = {self.accuracy:g}: allowed are 1e-9 to 1")
        if self.band is not None and self.accuracy is None:
            raise InputError(f"band = {self.band:g} Hz: goes with accuracy only, not {named[0]}")

    def of(self, part: HeldPart) -> tuple[Candidates, float | None]:
        """What it takes of a part, and where an accuracy was asked for its band, Hz."""
        space = krylov_space(part.held.solve, part.M_ss)
        if self.accuracy is None:
            return Candidates.exactly(self.modes_in(space)), None
        band = self.band or max(_own_band(part, space), self.least or 0.0)
        return _accurate(part, self.accuracy, 2 * np.pi * band, space), band

    def modes_in(self, space: KrylovSpace) -> Fixed:
        """Fixed-interface modes, where these are what is wanted."""
        below = None if self.cutoff is None else 2 * np.pi * self.cutoff
        return fixed_modes(space, self.modes, below)


def _one(options: dict[str, float | None]) -> str:
    *names, last = options
    return f"{', '.join(names)} and {last}"


def _own_band(part: HeldPart, space: KrylovSpace) -> float:
    """Frequency of the tenth elastic mode of a part whose masters are free, Hz, by ten modes."""
    modes = fixed_modes(space, min(_ELASTIC, space.shape[1] - 1), tolerance=_ROUGH)
    LB = part.inertia.gather(modes.vectors)
    K = sl.block_diag(part.K_mm, np.diag(modes.omega_squared))
    M = np.block([[part.M_mm, LB], [LB.conj().T, np.eye(LB.shape[1])]])
    last = min(len(K), _ELASTIC + 6) - 1
    squared = lowest(K, M, last + 1)[0]
    elastic = squared[squared > 1e-6 * squared[-1]][:_ELASTIC]
    return float(np.sqrt(elastic[-1]) / (2 * np.pi))
