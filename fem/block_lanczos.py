"""Lowest modes of a stiffness that can be solved with, by block Lanczos.

The operator K⁻¹M is self-adjoint in the inner product of M; its largest eigenvalues are the inverse
of the lowest ω². A Krylov space is built block by block, each made M-orthonormal to all before,
and searched by Rayleigh-Ritz. Blocks of right-hand sides cost a sparse solver a fraction of as many
single ones, which outweighs that a block method takes a few more of them. (Grimes, Lewis and Simon,
A shifted block Lanczos algorithm, SIAM J. Matrix Anal. Appl. 15 (1994) 228-272.)

Of a repeated mode such a space holds no more copies than its blocks have columns. So where as many
have been found, as in a part with many equal blades, the blocks are widened and the search goes on
for as many steps again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg as sl

from vanelock.common.arrays import Array, Floats
from vanelock.common.errors import InputError

_Apply = Callable[[Array], Array]

BLOCK = 8
TOLERANCE = 1e-8
"""Residual of a mode relative to its eigenvalue. The eigenvalue's error is of the second order in
it, but that of the vector of the first, and what is kept beside modes is made orthogonal to them.
"""
_MOST = 500  # modes below an eigenvalue, beyond which someone has mistyped it
_FAR = 1e5
"""Times the lowest frequency that these many modes of one part never reach: a mistaken unit."""
_TRUSTED = 0.03
"""Residual of the first mode that is not wanted, at which it is trusted to be the next one."""
_EQUAL = 1e-4  # relative distance of eigenvalues that may be copies of one
_LARGEST = 400  # blocks


@dataclass(frozen=True)
class _Lowest:
    """The lowest modes of a part."""

    omega_squared: Floats  # (f,), ascending
    vectors: Array  # (n, f), mass-normalised
    beyond: float  # no further mode has an ω² below this


class KrylovSpace:
    """A space that grows by a block at a time, M-orthonormal, and K⁻¹M in it.

    What it holds serves every search in it: one goes on where another ended.
    """

    def __init__(self, solve: _Apply, mass: _Apply, start: Array) -> None:
        self.solve, self.mass = solve, mass
        self._heavy = np.any(start != 0, axis=1)[:, None]
        self._space = self._image = np.empty((len(start), 0), start.dtype)
        self._Q, self._MQ = self._space, self._image
        self._H = np.empty((0, 0), start.dtype)
        self._coupling = self._H
        self._block, self._of_block = _orthonormal(start, mass, self._Q, self._Q)
        self.width, self.steps = self._block.shape[1], 0
        self._rng = np.random.default_rng(1)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows, and how many of them have a mass."""
        return len(self._heavy), int(self._heavy.sum())

    @property
    def whole(self) -> bool:
        """Whether nothing is left to add."""
        return self._block.shape[1] == 0 or self._Q.shape[1] == self.shape[1]

    def grow(self) -> None:
        """Add the current block, and make the next one."""
        if self.steps and self.whole:
            return
        block, of_block = self._block, self._of_block
        self._space, self._Q = _appended(self._space, self._Q, block)
        self._image, self._MQ = _appended(self._image, self._MQ, of_block)
        grown = self.solve(of_block)
        overlap = self._MQ.conj().T @ grown
        self._H = _bordered(self._H, overlap, block.shape[1])
        rest = self._heavy * (grown - self._Q @ overlap)
        self._block, self._of_block = _orthonormal(rest, self.mass, self._Q, self._MQ)
        self._coupling = self._of_block.conj().T @ rest
        self.steps += 1

    def widen(self) -> None:
        """Take more columns into each block from now on, for modes with more copies."""
        fresh = self._rng.standard_normal((len(self._Q), BLOCK)).astype(self._Q.dtype)
        block = np.hstack([self._block, self._heavy * fresh])
        self._block, self._of_block = _orthonormal(block, self.mass, self._Q, self._MQ)
        self.width += BLOCK

    def ritz(self) -> tuple[Floats, Array, Floats]:
        """Values of K⁻¹M, descending, their vectors in the space, and the residuals of these."""
        theta, S = sl.eigh(self._H)
        theta, S = theta[::-1], S[:, ::-1]
        return theta, S, np.linalg.norm(self._coupling @ S[-self._coupling.shape[1] :], axis=0)

    def vectors(self, S: Array) -> Array:
        """(n, k) of combinations of the space."""
        return np.asarray(self._Q[:, : len(S)] @ S)


def krylov_space(solve: _Apply, M: Any) -> KrylovSpace:
    """The space in which modes are searched for, still empty."""
    n = M.shape[0]
    if n and (least := M.diagonal().real.min()) < 0:
        raise InputError(f"the mass matrix has {least:.3g} on its diagonal: it must be >= 0")
    start = np.random.default_rng(0).standard_normal((n, min(n, BLOCK))).astype(M.dtype)
    start[M.diagonal() == 0] = 0
    return KrylovSpace(solve, lambda x: M @ x, start)


def lowest_modes(
    space: KrylovSpace,
    count: int | None = None,
    below: float = np.inf,
    tolerance: float = TOLERANCE,
) -> _Lowest:
    """Lowest pairs of K x = λ M x: a number of them, or all below an eigenvalue."""
    first, due = 0, 0
    least = 1 / below if below else np.inf
    while space.steps < _LARGEST:
        space.grow()
        theta, S, residual = space.ritz()
        wanted = int(np.sum(theta > least)) if count is None else count
        if count is None and wanted > _MOST:
            raise InputError(
                f"more than {_MOST} fixed-interface modes below {_hertz(below):.4g} Hz, the lowest "
                f"at {_hertz(1 / theta[0]):.4g} Hz: {_mistaken(below * theta[0])}choose a lower "
                "cutoff, or a lower band, which needs them up to its double"
            )
        if wanted > len(theta) or (wanted == len(theta) and not space.whole):
            if space.whole:
                raise InputError(f"{count} modes: the part has {len(theta)}")
            continue
        # A Ritz value lies below its eigenvalue by less than its residual; the largest converge
        # first, so once the next one has roughly done so, no larger one is left.
        highest = (theta + residual)[wanted:].max(initial=0.0)
        trusted = bool(
            np.all(residual[wanted : wanted + 1] < _TRUSTED * theta[wanted : wanted + 1])
        )
        none_left = count is not None or (trusted and highest < least)
        converged = none_left and bool(np.all(residual[:wanted] < tolerance * theta[:wanted]))
        copied = converged and space.steps >= due and not space.whole
        if copied and _copies(theta[:wanted]) >= space.width:
            space.widen()
            first = first or space.steps
            due = space.steps + first
        if space.whole or (converged and space.steps >= due):
            vectors = space.vectors(S[:, :wanted])
            squared, vectors = _refined(space.solve, space.mass, vectors, theta[:wanted])
            if count is None:
                return _Lowest(squared, vectors, 1 / highest if highest else np.inf)
            return _Lowest(squared, vectors, float(squared[-1]) if wanted else 0.0)
    raise InputError("the modes of the part did not converge")


def _mistaken(ratio: float) -> str:
    """What is more likely than a wide band; `ratio` is that of squared frequencies."""
    return "are densities and moduli in the units that are meant? else " if ratio > _FAR**2 else ""


def _hertz(eigenvalue: float) -> float:
    return float(np.sqrt(eigenvalue) / (2 * np.pi))


def _appended(space: Array, used: Array, block: Array) -> tuple[Array, Array]:
    """The used columns of a space and a block after them, in a larger space where need be."""
    old = used.shape[1]
    new = old + block.shape[1]
    if new > space.shape[1]:
        space = np.empty((len(block), max(2 * new, 8 * BLOCK)), block.dtype, order="F")
        space[:, :old] = used
    space[:, old:new] = block
    return space, space[:, :new]


def _copies(theta: Floats) -> int:
    """Length of the longest run of nearly equal values, descending."""
    apart = np.flatnonzero(theta[:-1] - theta[1:] > _EQUAL * theta[:-1])
    return int(np.diff(np.r_[-1, apart, len(theta) - 1]).max(initial=0))


def _orthonormal(block: Array, mass: _Apply, Q: Array, MQ: Array) -> tuple[Array, Array]:
    """The block made M-orthonormal to Q and in itself, without dependent columns; M times it.

    M is applied once, as it may be dear: its product follows the block's combinations.
    """
    size = np.linalg.norm(block, axis=0)
    block = block[:, size > 0] / size[size > 0]
    of_block = mass(block)
    for _ in range(2):  # twice is enough
        overlap = MQ.conj().T @ block
        block, of_block = block - Q @ overlap, of_block - MQ @ overlap
        values, vectors = sl.eigh(_hermitian(block.conj().T @ of_block))
        kept = values > 1e-14 * values[-1:]
        turn = vectors[:, kept] / np.sqrt(values[kept])
        block, of_block = block @ turn, of_block @ turn
    return block, of_block


def _bordered(H: Array, columns: Array, width: int) -> Array:
    """H with the columns of a new block, and their adjoint as rows."""
    old = len(H)
    grown: Array = np.zeros((old + width, old + width), np.result_type(H, columns))
    grown[:old, :old] = H
    grown[:, old:] = columns
    grown[old:, :old] = columns[:old].conj().T
    grown[old:, old:] = _hermitian(columns[old:])
    return grown


def _refined(solve: _Apply, mass: _Apply, X: Array, theta: Floats) -> tuple[Floats, Array]:
    """One step of subspace iteration, which squares the error that is left."""
    load = mass(X / theta)
    X = solve(load)
    try:
        values, V = sl.eigh(_hermitian(X.conj().T @ load), _hermitian(X.conj().T @ mass(X)))
    except sl.LinAlgError:
        raise InputError("the mass of its modes is not positive: is this a mass matrix?") from None
    return values, X @ V


def _hermitian(A: Any) -> Array:
    return np.asarray((A + A.conj().T) / 2)
