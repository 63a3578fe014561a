"""A cyclic part condensed to its faces and masters by one real factorisation, for all diameters.

With b the dofs of both faces and t those of the masters, all held in K_ss,

    S = K_mm - K_ms K_ss⁻¹ K_sm,    Ψ = -K_ss⁻¹ K_sm,    m = (b, t),

S is dense and small. At a nodal diameter the faces follow one another, x_b = W x_l, and K with the
masters held is solved by block elimination:

    (Wᴴ S_bb W) x_l = f_l + Wᴴ (Ψᵀ f_s)_b,    x_s = K_ss⁻¹ f_s + Ψ_b W x_l.

So a nodal diameter costs one dense Cholesky factorisation of its faces, instead of a sparse complex
one of the sector, and one real forward and backward sweep for each real column.

Loads at rest have static answers as further vectors. With the masters held, a load f has the answer
K_ss⁻¹ f_s. Where that is among the vectors, and with

    f_m + Ψᴴ f_s    on the masters,    Bᴴ f_s    on the vectors B,

the reduced part's displacement at rest is the full one's, whatever it is joined to: K has no term
between masters and vectors. The masters' own is exact without further vectors.

The route "cyclic" is cyclic symmetry on the sparse matrices, then Craig-Bampton: at each nodal
diameter the right face follows the left one, and what is left is a part like any other whose
matrices are complex: its masters are those of contacts, loads and outputs alone, its
fixed-interface modes are cyclic ones, and no interface remains to be reduced.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem import Interior, SingularError, free_motion, schur_complement
from vanelock.rom.component import Component
from vanelock.rom.fixed_interface.basis import Candidates, Projected, projected
from vanelock.rom.fixed_interface.held import HeldMatrices, HeldPart, held_part, hermitian
from vanelock.rom.fixed_interface.inertia import BoundaryAnswers, SectorInertia
from vanelock.rom.fixed_interface.selection import Selection
from vanelock.rom.routes.problem import Problem, cyclic_constraint, not_held
from vanelock.rom.system.system import Matrix, common_band

_FREE = 1e-11
"""Stiffness that the other dofs leave of one, relative to it, below which it moves freely."""


@dataclass(frozen=True)
class Condensed:
    """A part whose faces and masters are condensed out."""

    problem: Problem  # the part
    matrix: Matrix  # (b + t, b + t), S, rows of the faces first
    interior: Interior  # the factors of K_ss

    @cached_property
    def answers(self) -> BoundaryAnswers:
        """Static answers to faces and masters, which all nodal diameters share."""
        return BoundaryAnswers(self.interior, self.problem.M, self.faces)

    def forget_answers(self) -> None:
        """Let go of `answers`, which a further nodal diameter would begin anew."""
        self.__dict__.pop("answers", None)

    @property
    def slaves(self) -> Integers:
        """(s,) rows of K_ss."""
        rows: Integers = self.interior.rest
        return rows

    @property
    def faces(self) -> int:
        """Number of dofs of both faces."""
        return len(self.problem.face_rows)

    def follow(self, nodal_diameter: int) -> sp.csr_array:
        """W: both faces from the left one, (6b, 3b)."""
        return self._constraint(0, nodal_diameter)

    def stiffness(self, nodal_diameter: int) -> Matrix:
        """S at a nodal diameter, over the left face's dofs and the masters'."""
        W = self._constraint(len(self.problem.rows), nodal_diameter)
        return hermitian(W.conj().T @ (self.matrix @ W))

    def transform(self, nodal_diameter: int) -> sp.csc_array:
        """All dofs from those that move with the masters held: the left face's, the slaves'."""
        W = self.follow(nodal_diameter).tocoo()
        n, faces = self.problem.K.shape[0], W.shape[1]
        rows = np.concatenate([self.problem.face_rows[W.coords[0]], self.slaves])
        columns = np.concatenate([W.coords[1], faces + np.arange(len(self.slaves))])
        values = np.concatenate([W.data, np.ones(len(self.slaves))])
        shape = (n, faces + len(self.slaves))
        return sp.csc_array((values, (rows, columns)), shape=shape)

    def held(self, nodal_diameter: int) -> "_Sector":
        """The sector's stiffness at a nodal diameter, its masters held."""
        W, S = self.follow(nodal_diameter), self.stiffness(nodal_diameter)
        left = slice(W.shape[1])
        factor = definite_factor(S[left, left])
        if factor is None:
            raise InputError(self._free_motion(nodal_diameter, S[left, left]))
        return _Sector(self, W, S, factor)

    def _constraint(self, others: int, nodal_diameter: int) -> sp.csr_array:
        sectors = self.problem.model.part.sectors
        return cyclic_constraint(len(self.problem.left), others, nodal_diameter, sectors)

    def _free_motion(self, nodal_diameter: int, on_face: Matrix) -> str:
        """What moves freely at a nodal diameter although the masters are held."""
        scale = 1 / np.sqrt(np.diagonal(on_face).real)
        values, V = sl.eigh(scale[:, None] * on_face * scale)
        free = V[:, : max(1, int(np.sum(values < _FREE)))] * scale[:, None]
        moved = np.concatenate(
            [self.follow(nodal_diameter) @ free, np.zeros((len(self.problem.rows), free.shape[1]))]
        )
        motions = np.concatenate([free, self.interior.extend(moved)])
        error = SingularError(np.linalg.qr(motions)[0])
        T, means = self.transform(nodal_diameter), self.problem.means
        found = free_motion(self.problem.model, error, T if means is None else means @ T)
        return f"{found} (at nodal diameter {nodal_diameter}, the masters held)"


@dataclass(frozen=True)
class _Sector:
    """A sector at a nodal diameter with its masters held, in the order of `Condensed.transform`."""

    part: Condensed
    follow: sp.csr_array  # (6b, 3b), W
    condensed: Matrix  # (3b + m, 3b + m), S at the nodal diameter
    factor: Matrix  # (3b, 3b), Cholesky factor of its part of the left face

    @property
    def stiffness(self) -> Matrix:
        """(m, m) stiffness of the part moved by its masters."""
        b = len(self.factor)
        half = sl.solve_triangular(self.factor, self.condensed[:b, b:], lower=True)
        return np.asarray(self.condensed[b:, b:] - half.conj().T @ half)

    def solve(self, b: Matrix) -> Matrix:
        """Displacements (3b + s, k) under loads."""
        nodes, interior = len(self.factor), self.part.interior
        halfway, gathered = interior.down(b[nodes:])
        on_face = b[:nodes] + self.follow.conj().T @ gathered[: self.part.faces]
        x_l = sl.cho_solve((self.factor, True), on_face)
        held = np.zeros((len(self.part.problem.rows), b.shape[1]), x_l.dtype)
        moved = np.concatenate([self.follow @ x_l, held])
        return np.concatenate([x_l, interior.up(halfway, moved)])

    def moved(self) -> Matrix:
        """(6b, m) motion of both faces when each master moves."""
        b = len(self.factor)
        x_l = -sl.cho_solve((self.factor, True), self.condensed[:b, b:])
        return np.asarray(self.follow @ x_l)


def definite_factor(A: Matrix) -> Matrix | None:
    """Lower Cholesky factor; None where A is singular but for round-off, or indefinite."""
    try:
        factor = np.asarray(sl.cholesky(A, lower=True))
    except sl.LinAlgError:
        return None
    left = np.diagonal(factor).real ** 2 / np.diagonal(A).real
    return factor if left.min(initial=1.0) > _FREE else None


def condensed(problem: Problem) -> Condensed:
    """Condense a part to its faces and masters: one real factorisation."""
    rows = problem.boundary_rows
    try:
        return Condensed(problem, *schur_complement(problem.K, rows))
    except SingularError as error:
        rest = np.setdiff1d(np.arange(problem.K.shape[0]), rows)
        raise InputError(not_held(problem, error, rest)) from None


Loads = Mapping[str, Floats]


@dataclass(frozen=True)
class _HeldLoads:
    """Loads at rest where the masters are held."""

    names: tuple[str, ...]  # of the loads, l of them
    masters: Matrix  # (m, l), forces that the part hands on to its masters, N
    slaves: Matrix  # (s, l), on the dofs of the fixed-interface vectors, N

    def answered(self, chosen: Candidates, part: HeldPart) -> tuple[Candidates, Matrix]:
        """The vectors with the answers that they do not hold; the answers (s, l) to the loads."""
        answers = part.held.solve(self.slaves)
        return chosen.answering(part, self.slaves, answers), answers

    def reduced(self, part: HeldPart, products: Projected, answers: Matrix) -> dict[str, Matrix]:
        """(m + a,) of each load in the coordinates of masters and vectors.

        The vectors' shares are Ω² B⁺ K_ss⁻¹ f_s, which is Bᴴ f_s for exact modes, and gives the
        exact answer for those that are exact to a tolerance.
        """
        B = products.vectors()
        MB = part.M_ss @ B
        shares = sl.solve(hermitian(B.conj().T @ MB), MB.conj().T @ answers, assume_a="pos")
        forces = products.omega_squared[:, None] * shares
        found = np.concatenate([self.masters, forces])
        return {name: found[:, i] for i, name in enumerate(self.names)}


def _held_loads(shared: Condensed, loads: Loads, held: object) -> _HeldLoads:
    """Loads on the free dofs of a model, for what is held: a sector at a diameter, or all of it."""
    problem = shared.problem
    f = np.column_stack([_of_dofs(problem, name, load) for name, load in loads.items()])
    slaves = f[shared.slaves]
    carried = f[problem.boundary_rows] + shared.interior.restrict(slaves)
    faces, masters = carried[: shared.faces], carried[shared.faces :]
    if isinstance(held, _Sector):
        masters = masters + held.moved().conj().T @ faces
        slaves = np.concatenate([held.follow.conj().T @ f[problem.face_rows], slaves])
    return _HeldLoads(tuple(loads), masters, slaves)


def _of_dofs(problem: Problem, name: str, load: Floats) -> Floats:
    """(n,) load on the dofs of a problem from that on the model's."""
    given, n = np.asarray(load, float), problem.model.K.shape[0]
    if given.shape != (n,):
        raise InputError(f"loads[{name!r}]: shape {given.shape}: needed is ({n},), the free dofs")
    if not np.isfinite(given).all():
        raise InputError(f"loads[{name!r}]: must be finite")
    return given if problem.means is None else np.asarray(problem.means.T @ given)


def reduced(
    shared: Condensed, selection: Selection, diameters: Iterable[int], loads: Loads | None = None
) -> Component:
    """Reduce a part: a cyclic one at nodal diameters, one in one piece at 0 alone.

    All keep equally many fixed-interface vectors. Static answers to loads at rest are among those
    of nodal diameter 0.
    """
    problem = shared.problem
    parts, vectors, bands = {}, {}, []
    at_rest = None
    for k in diameters:
        parts[k] = _at_diameter(shared, k) if problem.cyclic else _in_one_piece(shared)
        vectors[k], band = selection.of(parts[k])
        bands.append(band)
        if k == 0 and loads:
            at_rest = _held_loads(shared, loads, parts[k].held)
            vectors[k], answers = at_rest.answered(vectors[k], parts[k])
    count = max(found.count for found in vectors.values())
    products = {k: projected(part, vectors[k].filled(part, count)) for k, part in parts.items()}
    own = {k: p.vectors() for k, p in products.items()}
    return Component(
        masters=problem.masters,
        cyclic=problem.cyclic,
        route="cyclic" if problem.cyclic else "whole",
        interface_modes=0,
        fixed_modes=count,
        diameters={k: p.reduced(own[k] if problem.cyclic else None) for k, p in products.items()},
        boundary_nodes=problem.masters.nodes,
        vectors=None if problem.cyclic else own[0],
        band=common_band(bands),
        loads=None if at_rest is None else at_rest.reduced(parts[0], products[0], answers),
    )


def _in_one_piece(shared: Condensed) -> HeldPart:
    """The part, its masters held."""
    problem = shared.problem
    return held_part(HeldMatrices(shared.matrix, shared.interior), problem.M, problem.rows)


def _at_diameter(shared: Condensed, nodal_diameter: int) -> HeldPart:
    """The sector at a nodal diameter, its masters held."""
    held = shared.held(nodal_diameter)
    masters = shared.answers.at(held.moved())
    W = held.follow.conj().T
    half = sl.solve_triangular(held.factor, W @ masters.reaching, lower=True)
    return HeldPart(
        held,
        M_ss=shared.answers.mass(held.follow),
        K_mm=hermitian(held.stiffness),
        M_mm=hermitian(masters.mass),
        inertia=SectorInertia(W @ masters.on_faces, masters.blocks, masters.coefficients),
        compliance=hermitian(masters.energy + half.conj().T @ half),
    )
