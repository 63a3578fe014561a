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

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.rom.fixed_interface.block_lanczos import BLOCK, TOLERANCE, lowest_modes
from vanelock.rom.fixed_interface.held import HeldPart, Solve, hermitian
from vanelock.rom.system import Matrix

MARGIN = 2.0
"""Modes up to this multiple of the highest frequency are kept exactly."""
LEVELS = 6
"""Times at which what is left of the error is treated again."""
RESERVE = 12
"""Vectors at hand beyond those needed, so that all nodal diameters may keep equally many."""
_ROUND_OFF = 1e-12
_NEW = 1e-6
"""Least part of a further mode's strain energy that the vectors at hand do not hold."""


@dataclass(frozen=True)
class Fixed:
    """Fixed-interface modes, the lowest ones.

    Attributes
    ----------
    vectors : (s, f)
        Mass-normalised.
    omega_squared : (f,) float
        Ascending, rad²/s².
    complete : float
        Circular frequency up to which no fixed-interface mode is left out, rad/s; infinite where
        the vectors are all there are.
    """

    vectors: Matrix
    omega_squared: NDArray[np.float64]
    complete: float


def fixed_modes(
    solve: Solve,
    M_ss: sp.csc_array,
    count: int | None = None,
    below: float | None = None,
    tolerance: float = TOLERANCE,
) -> Fixed:
    """Lowest fixed-interface modes: a number of them, or all up to a circular frequency.

    Raises
    ------
    InputError
        If there are fewer than that.
    """
    s, most = M_ss.shape[0], heavy(M_ss)
    if s and (least := M_ss.diagonal().real.min()) < 0:
        raise InputError(f"the mass matrix has {least:.3g} on its diagonal: it must be >= 0")
    if count is not None and not 0 <= count <= most:
        raise InputError(
            f"{count} fixed-interface modes of {s} slave dofs: allowed are 0 to {most}"
        )
    if count == 0:
        return Fixed(np.empty((s, 0), M_ss.dtype), np.empty(0), 0.0)

    rng = np.random.default_rng(0)
    start = rng.standard_normal((s, min(s, BLOCK))).astype(M_ss.dtype)
    start[M_ss.diagonal() == 0] = 0
    highest = np.inf if below is None else below**2
    found = lowest_modes(solve, lambda x: M_ss @ x, start, count, highest, tolerance)
    all_of_them = len(found.omega_squared) == most
    complete = np.inf if all_of_them else float(np.sqrt(found.beyond))
    return Fixed(found.vectors, found.omega_squared, complete)


def heavy(M_ss: sp.csc_array) -> int:
    """Number of dofs that have a mass."""
    return int(np.count_nonzero(M_ss.diagonal()))


@dataclass(frozen=True)
class Candidates:
    """Fixed-interface modes, and vectors beside them of which the first few are needed.

    Attributes
    ----------
    modes : Fixed
        Exact modes.
    vectors : (s, a)
        Further vectors, K- and M-orthogonal to the modes, in the order of their use.
    stiffness, mass : (a, a)
        Their matrices.
    needed : int
        How many of them the accuracy asks for.
    """

    modes: Fixed
    vectors: Matrix
    stiffness: Matrix
    mass: Matrix
    needed: int

    @classmethod
    def exactly(cls, modes: Fixed) -> "Candidates":
        """Fixed-interface modes and nothing beside them."""
        s, none = len(modes.vectors), np.empty((0, 0), modes.vectors.dtype)
        return cls(modes, np.empty((s, 0), modes.vectors.dtype), none, none, 0)

    @property
    def count(self) -> int:
        """Number of modes and vectors needed together."""
        return len(self.modes.omega_squared) + self.needed

    @property
    def most(self) -> int:
        """Number of modes and vectors there are."""
        return len(self.modes.omega_squared) + int(self.vectors.shape[1])

    def filled(self, part: HeldPart, count: int) -> "Candidates":
        """The same, with what further modes add to it behind, where there are fewer than `count`.

        Raises
        ------
        InputError
            If the part has not so many dofs.
        """
        lacking = count - self.most
        if lacking <= 0:
            return self
        solve, M_ss, exact = part.held.solve, part.M_ss, len(self.modes.omega_squared)
        if self.vectors.shape[1] == 0:
            return Candidates.exactly(fixed_modes(solve, M_ss, count))
        W, more = self.vectors, lacking
        while True:
            # W may hold some of them already: what counts is the part that is orthogonal to it.
            further = fixed_modes(solve, M_ss, exact + more)
            Phi, squared = further.vectors[:, exact:], further.omega_squared[exact:]
            Phi, MPhi = Phi / np.sqrt(squared), M_ss @ (Phi * np.sqrt(squared))
            overlap = W.conj().T @ MPhi
            c = sl.solve(self.stiffness, overlap, assume_a="pos")
            new, V = sl.eigh(np.eye(more) - hermitian(overlap.conj().T @ c))
            if np.sum(new > _NEW) >= lacking or exact + more == heavy(M_ss):
                break
            more = min(more + lacking, heavy(M_ss) - exact)
        if np.sum(new > _NEW) < lacking:
            raise InputError(f"{count} fixed-interface vectors of {heavy(M_ss)} slave dofs")
        V = V[:, -lacking:] / np.sqrt(new[-lacking:])
        W = np.hstack([W, Phi @ V - W @ (c @ V)])
        stiffness = sl.block_diag(self.stiffness, np.eye(lacking))
        return Candidates(self.modes, W, stiffness, hermitian(W.conj().T @ (M_ss @ W)), self.needed)

    def all(self, count: int | None = None) -> Matrix:
        """(s, f + a) the modes and the vectors, or the first of them."""
        return np.hstack([self.modes.vectors, self.vectors])[:, :count]

    def first(self, count: int) -> tuple[Matrix, NDArray[np.float64]]:
        """Combinations of the first `count` of them that Rayleigh and Ritz call modes.

        Returns
        -------
        (count, count) coefficients and (count,) their ω², rad²/s².
        """
        exact = len(self.modes.omega_squared)
        if count == exact:
            return np.eye(exact), self.modes.omega_squared
        used = slice(count - exact)
        values, V = sl.eigh(self.stiffness[used, used], self.mass[used, used])
        squared = np.concatenate([self.modes.omega_squared, values])
        return sl.block_diag(np.eye(exact), V), squared


def accurate(part: HeldPart, accuracy: float, highest: float) -> Candidates:
    """Vectors for frequencies up to `highest` within a relative error.

    Parameters
    ----------
    part : HeldPart
        The part with its masters held.
    accuracy : float
        Largest relative error of any natural frequency, from this part.
    highest : float
        Circular frequency up to which that holds, rad/s.
    """
    modes = fixed_modes(part.held.solve, part.M_ss, below=MARGIN * highest)
    Phi, squared = modes.vectors, modes.omega_squared
    if np.isinf(modes.complete) or part.K_mm.size == 0:
        return Candidates.exactly(modes)
    bound = (1 - MARGIN**-2) * accuracy  # E at ω exceeds E at 0 by no more
    m_j = Phi.conj().T @ part.inertia
    E = part.compliance - (m_j.conj().T / squared) @ m_j
    metric = part.K_mm / highest**2 + part.M_mm - m_j.conj().T @ m_j
    error, X = _pencil(highest**2 * E, metric)
    first = int(np.sum(error > bound))
    most = min(first + RESERVE, int(np.sum(error > _ROUND_OFF * error[0])))
    # Inertia forces without what the modes take up, and their static answers.
    m_x = m_j @ X[:, :most]
    loads = part.inertia @ X[:, :most] - part.M_ss @ (Phi @ m_x)
    answers = part.held.solve(loads)
    W, KW = answers[:, :first], loads[:, :first]
    treated = loads[:, :first]
    for _ in range(LEVELS):
        more, of_more, worst = _missing(part, modes, W, KW, treated, bound, highest)
        if more.shape[1] == 0:
            break
        treated = treated @ worst
        W, KW = np.hstack([W, more]), np.hstack([KW, of_more])
    needed = W.shape[1]
    every = heavy(part.M_ss)
    if len(squared) + needed >= every:  # a small part in a wide band
        return Candidates.exactly(fixed_modes(part.held.solve, part.M_ss, every))
    most = min(most, first + every - len(squared) - needed)
    answers, loads = answers[:, :most], loads[:, :most]
    W, KW = np.hstack([W, answers[:, first:]]), np.hstack([KW, loads[:, first:]])
    scale = 1 / np.sqrt(np.einsum("ij,ij->j", W.conj(), KW).real)
    W, KW = W * scale, KW * scale
    mass = hermitian(W.conj().T @ (part.M_ss @ W))
    return Candidates(modes, W, hermitian(W.conj().T @ KW), mass, needed)


def _missing(
    part: HeldPart,
    modes: Fixed,
    W: Matrix,
    KW: Matrix,
    loads: Matrix,
    bound: float,
    highest: float,
) -> tuple[Matrix, Matrix, Matrix]:
    """Static answers, and their loads, to what W leaves of the loads at the highest frequency.

    The last matrix combines the loads to those that still cause too large an error.
    """
    if W.shape[1] == 0:
        return W, KW, W[:0]
    MW = part.M_ss @ W
    scale = 1 / np.sqrt(np.einsum("ij,ij->j", W.conj(), KW).real)
    D = scale[:, None] * hermitian(W.conj().T @ KW - highest**2 * (W.conj().T @ MW)) * scale
    c = scale[:, None] * sl.solve(D, scale[:, None] * (W.conj().T @ loads), assume_a="her")
    left = loads - KW @ c + highest**2 * (MW @ c)
    left -= part.M_ss @ (modes.vectors @ (modes.vectors.conj().T @ left))
    more = part.held.solve(left)
    error, V = sl.eigh(highest**2 * hermitian(left.conj().T @ more))
    worst = V[:, error > bound]
    return more @ worst, left @ worst, worst


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
