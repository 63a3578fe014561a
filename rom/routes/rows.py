"""Craig-Bampton reduction of matrices alone: some rows are kept, the rest follows.

At a nodal diameter of a sector whose faces `high` follow `low`, x_high = T x_low e^{-iφ} with
φ = 2π k/N and T the turn from one face's directions to the other's, the matrices are those of

    x = W x',    K' = Wᴴ K W,    M' = Wᴴ M W,

complex Hermitian, whose kept rows and vectors then are chosen as for a part in one piece
(`vanelock.rom.reduction`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from vanelock.common.arguments import OfKind
from vanelock.common.arrays import Integers
from vanelock.common.cyclic import phase_factor
from vanelock.fem import schur_complement
from vanelock.rom.component import Reduced
from vanelock.rom.fixed_interface.basis import Projected, projected
from vanelock.rom.fixed_interface.held import HeldMatrices, HeldPart, held_part, hermitian
from vanelock.rom.fixed_interface.selection import DEFAULT, Selection
from vanelock.rom.system.system import Matrix

_ANSWERS = 2  # static answers for a load: to itself, and to the inertia of the one before


@dataclass(frozen=True)
class ReducedRows:
    """Matrices over kept rows, in their order, and fixed-interface vectors behind them.

    Attributes
    ----------
    matrices : Reduced
        Stiffness, mass, damping where it was given, and what the reduction leaves out.
    vectors : int
        Number of fixed-interface vectors.
    band : float or None
        Frequency up to which an accuracy was asked for, Hz.
    loads : (p, r) or None
        Forces on the coordinates, one load a row, where loads were given.
    outputs : (o, r) or None
        Displacements of the rows that were to be followed, from the coordinates.
    """

    matrices: Reduced
    vectors: int
    band: float | None = None
    loads: Matrix | None = None
    outputs: Matrix | None = None

    @property
    def reach(self) -> float | None:
        """Frequency up to which it answers, Hz, as of `Component`."""
        return self.matrices.reach if self.band is None else self.band


@dataclass(frozen=True)
class Faces(OfKind):
    """How the rows of a high cyclic face follow those of the low one.

    Attributes
    ----------
    low, high : (f,) int
        Rows of the faces.
    turn : (f, f) sparse
        Motion of the high rows from that of the low ones, each in its sector's own directions
        turned by 2π/N; the unit matrix where directions are cylindrical.
    sectors : int
        N.
    """

    low: Integers
    high: Integers
    turn: sp.csc_array
    sectors: int

    def follow(self, size: int, nodal_diameter: int) -> tuple[sp.csc_array, Integers]:
        """W, (size, size - f), and the rows of the sector that are its columns."""
        left = np.setdiff1d(np.arange(size), self.high)
        place = np.full(size, -1)
        place[left] = np.arange(len(left))
        phase = phase_factor(nodal_diameter, self.sectors)
        turn = (phase * self.turn).tocoo()
        rows = np.concatenate([left, self.high[turn.coords[0]]])
        columns = np.concatenate([np.arange(len(left)), place[self.low[turn.coords[1]]]])
        values = np.concatenate([np.ones(len(left)), turn.data])
        return sp.csc_array((values, (rows, columns)), shape=(size, len(left))), left


def reduce_rows(
    K: sp.csc_array,
    M: sp.csc_array,
    rows: Integers,
    selection: Selection | None = None,
    C: sp.csc_array | None = None,
    loads: sp.csc_array | None = None,
    outputs: Integers | None = None,
) -> ReducedRows:
    """Reduce matrices to some of their rows and fixed-interface vectors.

    Loads and outputs need not be rows that are kept: the static answer to a load and that to the
    inertia of this one are two vectors, however many rows the load acts on, and an output is a row
    of the basis.

    Parameters
    ----------
    K, M : (n, n) sparse
        Stiffness and mass, symmetric or Hermitian.
    rows : (m,) int
        Rows that are kept as coordinates, at most n - 1.
    selection : Selection, optional
        How many vectors; by default those that an accuracy of 1e-4 takes.
    C : (n, n) sparse, optional
        Damping.
    loads : (n, p) sparse, optional
        Real forces, one load a column.
    outputs : (o,) int, optional
        Rows whose displacements are asked for.

    Raises
    ------
    SingularError
        If something moves although the kept rows are held.
    InputError
        If fewer vectors exist than are asked for.
    """
    part = _held_rows(K, M, rows)
    chosen, band = (selection or Selection(accuracy=DEFAULT)).of(part)
    rest = np.setdiff1d(np.arange(K.shape[0]), rows)
    if loads is not None:
        forces = loads[rest].toarray()
        for _ in range(_ANSWERS):
            answers = part.held.solve(forces)
            chosen = chosen.answering(part, forces, answers)
            forces = part.M_ss @ answers
    products = projected(part, chosen)
    found = replace(_kept(part, products, C, rows), band=band)
    if loads is not None:
        found = replace(found, loads=_seen(part, products, loads, rows, rest))
    if outputs is not None:
        each = sp.eye_array(K.shape[0], format="csc")[:, outputs]
        found = replace(found, outputs=_seen(part, products, each, rows, rest))
    return found


def reduce_sector(
    K: sp.csc_array,
    M: sp.csc_array,
    rows: Integers,
    faces: Faces,
    nodal_diameters: Sequence[int],
    selection: Selection | None = None,
    C: sp.csc_array | None = None,
) -> dict[int, ReducedRows]:
    """Reduce one sector of a ring at nodal diameters; all keep equally many vectors.

    Parameters
    ----------
    K, M, rows, selection, C
        As for `reduce_rows`, of the sector with both faces free; no kept row lies on one.
    faces : Faces
        What joins it to its neighbours.
    nodal_diameters : sequence of int
        0 to N - 1.
    """
    selection, found = selection or Selection(accuracy=DEFAULT), {}
    for k in nodal_diameters:
        W, left = faces.follow(K.shape[0], k)
        own = np.searchsorted(left, rows)
        part = _held_rows(_through(W, K), _through(W, M), own)
        chosen, band = selection.of(part)
        products, damping = projected(part, chosen), None if C is None else _through(W, C)
        found[k] = part, products, damping, own, band
    counts = [products.candidates.count for _, products, *_ in found.values()]
    count = max(counts, default=0)
    reduced = {}
    for k, (part, products, damping, own, band) in found.items():
        if count > products.candidates.count:
            products = projected(part, products.candidates.filled(part, count))
        reduced[k] = replace(_kept(part, products, damping, own), band=band)
    return reduced


def _held_rows(K: sp.csc_array, M: sp.csc_array, rows: Integers) -> HeldPart:
    """The matrices with their kept rows held."""
    return held_part(HeldMatrices(*schur_complement(K, rows)), M, rows)


def _kept(
    part: HeldPart, products: Projected, C: sp.csc_array | None, rows: Integers
) -> ReducedRows:
    matrices, count = products.reduced(), products.candidates.count
    if C is not None:
        assert isinstance(part.held, HeldMatrices)
        m, n = len(rows), C.shape[0]
        basis = np.zeros((n, m + count), np.result_type(part.K_mm, C.dtype))
        rest = np.setdiff1d(np.arange(n), rows)
        basis[rows, np.arange(m)] = 1
        basis[rest, :m] = part.held.slaves.extend(np.eye(m, dtype=part.K_mm.dtype))
        basis[rest, m:] = products.vectors()
        matrices = replace(matrices, C=hermitian(basis.conj().T @ (C @ basis)))
    return ReducedRows(matrices, count)


def _seen(
    part: HeldPart, products: Projected, columns: sp.csc_array, rows: Integers, rest: Integers
) -> Matrix:
    """(k, r) products of columns (n, k) with the reduction's basis."""
    assert isinstance(part.held, HeldMatrices)
    own, inner = columns[rows].toarray(), columns[rest].toarray()
    carried = own + part.held.slaves.restrict(inner)
    return np.hstack([carried.T, inner.T @ products.vectors()])


def _through(W: sp.csc_array, A: sp.csc_array) -> sp.csc_array:
    found = sp.csc_array(W.conj().T @ A @ W)
    return sp.csc_array((found + found.conj().T) / 2)
