"""The vectors that a part keeps at one nodal diameter, and the matrices reduced to them.

All nodal diameters of a part that are reduced together keep equally many: where one needs fewer,
the answers that come next in the order of their use follow, and behind them further modes: fixed-
interface modes, K_ss φ = ω² M_ss φ, a number of them, or all below a frequency.

In masters and fixed-interface vectors the matrices are

    K = [ K_mm      ]      M = [ M_mm  LᴴB ]
        [       Ω²  ]          [ BᴴL    1  ]

and what they leave out (`rom.errors.frequency_errors`), from r = K B η - θ (L x_m + M B η):

    G₀ = [ 0     ]    G₁ = [ 0    LᴴB ]    G₂ = [ LᴴY   YᴴMB      ]
         [    Ω² ]         [ BᴴL   2  ]         [ BᴴMY  BᴴMK⁻¹MB  ]      Y = K_ss⁻¹ L

All follow from products that need no solve beyond those by which the vectors were chosen.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as sl

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.fem.block_lanczos import TOLERANCE, KrylovSpace, krylov_space, lowest_modes
from vanelock.rom.component import Reduced
from vanelock.rom.fixed_interface.held import HeldPart, hermitian, refuse_negative_mass
from vanelock.rom.system.system import Matrix


@dataclass(frozen=True)
class Fixed:
    """Fixed-interface modes, the lowest ones."""

    vectors: Matrix  # (s, f), mass-normalised
    omega_squared: Floats  # (f,), ascending, rad²/s²
    complete: float
    """Circular frequency up to which no fixed-interface mode is left out, rad/s; infinite where
    the vectors are all there are."""


def fixed_modes(
    space: KrylovSpace,
    count: int | None = None,
    below: float | None = None,
    tolerance: float = TOLERANCE,
) -> Fixed:
    """Lowest fixed-interface modes: a number of them, or all up to a circular frequency."""
    s, most = space.shape
    if count is not None and not 0 <= count <= most:
        raise InputError(
            f"{count} fixed-interface modes of {s} slave dofs: allowed are 0 to {most}"
        )
    highest = np.inf if below is None else below**2
    if count == 0:
        first = lowest_modes(space, 1, highest, tolerance).omega_squared if most else [np.inf]
        return Fixed(space.vectors(np.empty((0, 0))), np.empty(0), float(np.sqrt(first[0])))
    found = lowest_modes(space, count, highest, tolerance)
    all_of_them = len(found.omega_squared) == most
    complete = np.inf if all_of_them else float(np.sqrt(found.beyond))
    return Fixed(found.vectors, found.omega_squared, complete)


_NEW = 1e-6  # least part of a further vector's strain energy that the vectors so far do not hold

_SEEN = 1e-22
"""That of answers to loads, over the whole answer's: their amplitude goes with its root."""


@dataclass(frozen=True)
class Candidates:
    """Fixed-interface modes, vectors beside them, and what comes next."""

    modes: Fixed  # exact modes
    vectors: Matrix
    """(s, a), further vectors W, K- and M-orthogonal to the modes, in the order of their use."""
    loads: Matrix  # (s, a), K_ss W and K_ss⁻¹ M_ss W
    answers: Matrix
    stiffness: Matrix  # (a, a), matrices of W, ones on the diagonal of the first
    mass: Matrix
    spare: Matrix  # (m, r), motions of the masters, the static answers to whose inertia come next

    @classmethod
    def exactly(cls, modes: Fixed) -> "Candidates":
        """Fixed-interface modes and nothing beside them."""
        kind = modes.vectors.dtype
        none, nothing = np.empty((len(modes.vectors), 0), kind), np.empty((0, 0), kind)
        return cls(modes, none, none, none, nothing, nothing, nothing)

    @property
    def count(self) -> int:
        """Number of modes and vectors together."""
        return len(self.modes.omega_squared) + int(self.vectors.shape[1])

    def filled(self, part: HeldPart, count: int) -> "Candidates":
        """The same with what comes next behind it, and further modes behind that, up to `count`."""
        lacking = count - self.count
        if lacking <= 0:
            return self
        if self.spare.shape[1]:
            loads = inertia_loads(part, self.modes, self.spare[:, :lacking])
            more = self.grown(part, part.held.solve(loads), loads)
            return replace(more, spare=self.spare[:, lacking:]).filled(part, count)
        if self.vectors.shape[1] == 0:
            return Candidates.exactly(fixed_modes(krylov_space(part.held.solve, part.M_ss), count))
        return self.grown(part, *self._further(part, lacking))

    def _further(self, part: HeldPart, lacking: int) -> tuple[Matrix, Matrix]:
        """What so many further modes add, K-orthogonal to W and in itself, and K times it."""
        M_ss, exact = part.M_ss, len(self.modes.omega_squared)
        space = krylov_space(part.held.solve, M_ss)
        W, more, every = self.vectors, lacking, space.shape[1]
        while True:
            # W may hold some of them already: what counts is the part that is orthogonal to it.
            further = fixed_modes(space, exact + more)
            Phi, squared = further.vectors[:, exact:], further.omega_squared[exact:]
            Phi, KPhi = Phi / np.sqrt(squared), M_ss @ (Phi * np.sqrt(squared))
            overlap = W.conj().T @ KPhi
            c = sl.solve(self.stiffness, overlap, assume_a="pos")
            new, V = sl.eigh(np.eye(more) - hermitian(overlap.conj().T @ c))
            if np.sum(new > _NEW) >= lacking or exact + more == every:
                break
            more = min(more + lacking, every - exact)
        if np.sum(new > _NEW) < lacking:
            count = self.count + lacking
            raise InputError(f"{count} fixed-interface vectors of {every} slave dofs")
        V = V[:, -lacking:] / np.sqrt(new[-lacking:])
        return Phi @ V - W @ (c @ V), KPhi @ V - self.loads @ (c @ V)

    def grown(self, part: HeldPart, X: Matrix, loads: Matrix) -> "Candidates":
        """The same with vectors X and K_ss X behind; one solve for each."""
        scale = 1 / np.sqrt(np.einsum("ij,ij->j", X.conj(), loads).real)
        X, loads = X * scale, loads * scale
        MX, W = part.M_ss @ X, self.vectors
        return replace(
            self,
            vectors=np.hstack([W, X]),
            loads=np.hstack([self.loads, loads]),
            answers=np.hstack([self.answers, part.held.solve(MX)]),
            stiffness=_bordered(self.stiffness, W.conj().T @ loads, X.conj().T @ loads),
            mass=_bordered(self.mass, W.conj().T @ MX, X.conj().T @ MX),
        )

    def answering(self, part: HeldPart, loads: Matrix, answers: Matrix) -> "Candidates":
        """The same with static answers (s, p) to loads on the slaves behind it where new.

        One after the other: eigenvalues of all their products would blur what is small in some.
        """
        Phi, energy = self.modes.vectors, np.einsum("ij,ij->j", loads.conj(), answers).real
        modal = Phi.conj().T @ loads
        X = answers - Phi @ (modal / self.modes.omega_squared[:, None])
        F = loads - part.M_ss @ (Phi @ modal)
        new, held = X[:, :0], F[:, :0]
        for i in range(X.shape[1]):
            x, f = X[:, [i]], F[:, [i]]
            for _ in range(2):
                x, f = _beside(x, f, self.vectors, self.loads, self.stiffness)
                x, f = _beside(x, f, new, held, np.eye(new.shape[1]))
            left = np.vdot(x, f).real
            if left > _SEEN * energy[i]:
                new, held = (np.hstack([A, a / left**0.5]) for A, a in ((new, x), (held, f)))
        return self.grown(part, new, held) if new.shape[1] else self

    def ritz(self) -> tuple[Matrix, Floats]:
        """Combinations of the vectors that Rayleigh and Ritz call modes, and their ω², rad²/s²."""
        try:
            values, V = sl.eigh(self.stiffness, self.mass)
        except sl.LinAlgError:
            refuse_negative_mass(self.mass)
            raise
        return V, values


def _beside(
    x: Matrix, f: Matrix, vectors: Matrix, loads: Matrix, stiffness: Matrix
) -> tuple[Matrix, Matrix]:
    """Answer x and load f = K x without what vectors, their loads and their stiffness hold."""
    if not vectors.shape[1]:
        return x, f
    c = sl.solve(stiffness, vectors.conj().T @ f, assume_a="her")
    return x - vectors @ c, f - loads @ c


def inertia_loads(part: HeldPart, modes: Fixed, x: Matrix) -> Matrix:
    """Inertia forces of static answers to masters' motions x, without what modes take up."""
    taken_up = modes.vectors @ (part.inertia.gather(modes.vectors).conj().T @ x)
    return np.asarray(part.inertia.push(x) - part.M_ss @ taken_up)


def _bordered(A: Matrix, across: Matrix, block: Matrix) -> Matrix:
    return np.block([[A, across], [across.conj().T, hermitian(block)]])


@dataclass(frozen=True)
class Projected:
    """A part's products with its candidate vectors B, a of them."""

    candidates: Candidates  # the vectors
    K_mm: Matrix  # (m, m), Guyan's matrices
    M_mm: Matrix
    inertia: Matrix
    """(m, a), LᴴB and YᴴMB, B the modes and the Ritz vectors of what is kept beside them."""
    answer: Matrix
    compliance: Matrix  # (m, m), LᴴY
    second: Matrix  # (a, a), BᴴMK⁻¹MB
    ritz: Matrix  # (v, v), those Ritz vectors in the vectors kept
    omega_squared: Floats  # (a,), ω² of B, rad²/s²

    def vectors(self) -> Matrix:
        """(s, a) fixed-interface vectors of the reduced model."""
        given = self.candidates
        return np.hstack([given.modes.vectors, given.vectors @ self.ritz])

    def reduced(self, vectors: Matrix | None = None) -> Reduced:
        """Reduced matrices."""
        count, m, squared = len(self.omega_squared), len(self.K_mm), self.omega_squared
        LB, YMB = self.inertia, self.answer
        G0 = sl.block_diag(np.zeros((m, m)), np.diag(squared))
        G1 = np.block([[np.zeros((m, m)), LB], [LB.conj().T, 2 * np.eye(count)]])
        G2 = np.block([[self.compliance, YMB], [YMB.conj().T, self.second]])
        return Reduced(
            K=sl.block_diag(self.K_mm, np.diag(squared)),
            M=np.block([[self.M_mm, LB], [LB.conj().T, np.eye(count)]]),
            vectors=vectors,
            neglected=np.array([G0.astype(G2.dtype), G1, G2]),
            complete=self.candidates.modes.complete / (2 * np.pi),
        )


def projected(part: HeldPart, candidates: Candidates) -> Projected:
    """Products of a part with the vectors that it keeps; K⁻¹M of a mode is the mode over ω²."""
    squared, Phi, W = candidates.modes.omega_squared, candidates.modes.vectors, candidates.vectors
    V, of_ritz = candidates.ritz()
    of_modes = part.inertia.gather(Phi)
    second = (part.M_ss @ W).conj().T @ candidates.answers
    return Projected(
        candidates,
        part.K_mm,
        part.M_mm,
        inertia=np.hstack([of_modes, part.inertia.gather(W) @ V]),
        answer=np.hstack([of_modes / squared, part.inertia.gather(candidates.answers) @ V]),
        compliance=part.compliance,
        second=sl.block_diag(np.diag(1 / squared), hermitian(V.conj().T @ second @ V)),
        ritz=V,
        omega_squared=np.concatenate([squared, of_ritz]),
    )
