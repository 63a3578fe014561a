"""Tran's reduction without the faces' constraint modes: a second way to the route "paper".

Of the thousand constraint modes of the cyclic faces, Tran's reduction keeps ten combinations. The
face modes solve (S, ΨᴴMΨ) with S the face's Schur complement, dense, and Ψ the static answer of the
part to its faces, which is never formed: a step of Lanczos sweeps up the real factors for Ψx, and
down for Ψᴴ(Mz). One real factorisation serves all nodal diameters (`rom.routes.condensed`), and
columns are formed for what is retained alone. Two bases of a face, its modes Φ those of the part
reduced statically to it:

- "published": all other masters condensed, x_b = Φ η, as the route "paper" takes them;
- "followed": the other masters held, and the face's static answer to those masters,
  x_b = Φ η - K_bb⁻¹ K_bt x_t.
"""

from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
import scipy.linalg as sl

from vanelock import fem, rom
from vanelock.fem.block_lanczos import BLOCK, KrylovSpace, krylov_space, lowest_modes
from vanelock.rom.fixed_interface.basis import Fixed
from vanelock.rom.fixed_interface.held import COLUMNS, hermitian
from vanelock.rom.routes.condensed import Condensed, definite_factor
from vanelock.rom.routes.problem import cyclic_constraint
from vanelock.rom.system.system import Matrix

Interface = Literal["published", "followed"]
FACE = 1e-11  # residual of a face mode: the subspace is the paper's to round-off
DENSE = 4  # beyond a fourth of the face's dofs, its modes come from dense matrices


def direct(
    model: fem.Model,
    masters: Sequence[str],
    modes: int = 10,
    nodal_diameters: Iterable[int] = (1,),
    interface: Interface = "published",
    interface_modes: int = 10,
) -> rom.Component:
    """Reduce a cyclic part; with the published interface as the route "paper" of `rom.reduce`."""
    shared, wanted = rom.prepare(model, masters), rom.Selection(modes=modes)
    problem = shared.problem
    M_ss = problem.M[shared.slaves][:, shared.slaves].tocsc()
    fixed = wanted.modes_in(krylov_space(shared.interior.solve, M_ss))
    del M_ss
    held = None
    if interface == "published":  # the masters' columns are the same at all diameters
        unit = np.eye(shared.faces + len(problem.rows), len(problem.rows), -shared.faces)
        held = _mass(shared, fixed.vectors, unit)
    return rom.Component(
        masters=problem.masters,
        cyclic=True,
        route="direct",
        interface_modes=interface_modes,
        fixed_modes=fixed.vectors.shape[1],
        diameters={
            k: _at_diameter(_Face(shared, k, interface), fixed, interface_modes, held)
            for k in nodal_diameters
        },
        boundary_nodes=problem.boundary_nodes,
        vectors=fixed.vectors,
    )


def _mass(shared: Condensed, Phi: Matrix, moved: Matrix) -> tuple[Matrix, Matrix]:
    """Mass between all faces and masters, or modes, and static answers to what is moved."""
    problem, slaves = shared.problem, shared.slaves
    boundary = problem.boundary_rows
    forces, modal = [], []
    for start in range(0, max(1, moved.shape[1]), COLUMNS):
        block = moved[:, start : start + COLUMNS]
        x = np.empty((problem.K.shape[0], block.shape[1]), block.dtype)
        x[boundary] = block
        x[slaves] = shared.interior.extend(block)
        f = problem.M @ x
        f_s = f[slaves]
        forces.append(f[boundary] + shared.interior.restrict(f_s))
        modal.append(Phi.T @ f_s)
    return np.hstack(forces), np.hstack(modal)


class _Face:
    """The face of a condensed part at a nodal diameter, b its dofs and t the masters'.

    Attributes
    ----------
    S : (b + t, b + t)
        Stiffness of the condensed part.
    others : (t, b)
        What the masters do when the face moves: follow it statically, or nothing.
    stiffness : (b, b)
        Of the face, the masters as `others`.
    follow : (b, t)
        What the face does when the masters move.
    """

    def __init__(self, shared: Condensed, nodal_diameter: int, interface: Interface) -> None:
        self.shared = shared
        self.nodal_diameter = nodal_diameter
        self.W = shared.follow(nodal_diameter)
        self.S = S = shared.stiffness(nodal_diameter)
        b, t = slice(self.W.shape[1]), slice(self.W.shape[1], None)
        self.others = np.zeros_like(S[t, b])
        self.follow = np.zeros_like(S[b, t])
        if interface == "published" and self.others.size:
            self.others = -sl.solve(S[t, t], S[t, b], assume_a="her")
        elif interface == "followed":
            self.follow = -sl.solve(S[b, b], S[b, t], assume_a="her")
        self.stiffness = hermitian(S[b, b] + S[b, t] @ self.others)

    def moved(self, x_b: Matrix, x_t: Matrix) -> Matrix:
        """(m, k) displacement of both faces and the masters."""
        return np.concatenate([self.W @ x_b, x_t])

    def onto(self, forces: Matrix) -> Matrix:
        """(b + t, k) forces at one face and the masters, from those at both faces, (m, k)."""
        faces = self.shared.faces
        return np.concatenate([self.W.conj().T @ forces[:faces], forces[faces:]])

    def mass(self, x_b: Matrix) -> Matrix:
        """Mass of the part moved statically by its face, times face displacements."""
        none = np.empty((len(self.shared.slaves), 0))
        forces = self.onto(_mass(self.shared, none, self.moved(x_b, self.others @ x_b))[0])
        b = len(x_b)
        return np.asarray(forces[:b] + self.others.conj().T @ forces[b:])

    def modes(self, count: int) -> Matrix:
        """(b, count) lowest face modes."""
        size = len(self.stiffness)
        factor = definite_factor(self.stiffness) if count * DENSE <= size else None
        if factor is None:  # many modes are wanted, or the part is free to move
            mass = hermitian(self.mass(np.eye(size, dtype=self.S.dtype)))
            return np.asarray(sl.eigh(self.stiffness, mass, subset_by_index=[0, count - 1])[1])
        start = np.random.default_rng(0).standard_normal((size, BLOCK)).astype(self.S.dtype)
        space = KrylovSpace(lambda f: sl.cho_solve((factor, True), f), self.mass, start)
        return lowest_modes(space, count, tolerance=FACE).vectors


def _at_diameter(
    face: _Face, fixed: Fixed, count: int, held: tuple[Matrix, Matrix] | None
) -> rom.Reduced:
    """Matrices in face modes, masters and fixed-interface modes."""
    modes = face.modes(count)
    b, t = face.follow.shape
    static = np.block([[modes, face.follow], [np.zeros((t, count)), np.eye(t)]])
    answers = static if held is None else static[:, :count]
    forces, modal = _mass(face.shared, fixed.vectors, face.moved(answers[:b], answers[b:]))
    if held is not None:
        forces, modal = np.hstack([forces, held[0]]), np.hstack([modal, held[1]])
    f = len(fixed.omega_squared)
    K = sl.block_diag(hermitian(static.conj().T @ face.S @ static), np.diag(fixed.omega_squared))
    M_static = hermitian(static.conj().T @ face.onto(forces))
    M = np.block([[M_static, modal.conj().T], [modal, np.eye(f)]])
    problem = face.shared.problem
    W_cs = cyclic_constraint(
        len(problem.left), t + f, face.nodal_diameter, problem.model.part.sectors
    )
    return rom.Reduced(K, M, basis=W_cs @ sl.block_diag(static, np.eye(f)))
