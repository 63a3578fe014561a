"""What a reduction works on: the sparse matrices of one part and the rows that it keeps.

By cyclic symmetry the right face of a sector follows the left one. In cylindrical components
x_r = x_l e^{-iφ}, φ = 2π ND/N; in Cartesian ones the vectors of the right face are also turned by
2π/N about the engine axis.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Integers
from vanelock.common.cyclic import phase_factor, turn
from vanelock.common.errors import InputError
from vanelock.fem import (
    Interior,
    Model,
    SingularError,
    cyclic_faces,
    free_motion,
    schur_complement,
)
from vanelock.rom.joining.patches import with_means
from vanelock.rom.masters import Masters
from vanelock.rom.system.system import Matrix


def cyclic_constraint(faces: int, others: int, nodal_diameter: int, sectors: int) -> sp.csr_array:
    """W_cs in (x_l, x_r, others) = W_cs (x_l, others)."""
    follow = phase_factor(nodal_diameter, sectors) * turn(sectors)
    left = sp.vstack([sp.eye_array(3 * faces), sp.kron(sp.eye_array(faces), follow)])
    return sp.csr_array(sp.block_diag([left, sp.eye_array(others)]))


@dataclass(frozen=True)
class Problem:
    """A part, the rows of its masters, and those of its cyclic faces.

    Attributes
    ----------
    model : fem.Model
        The part.
    masters : Masters
        Its retained nodes.
    K, M : (n, n) sparse
        Real stiffness, N/m, and mass, kg; the model's, or those with patch means among the dofs.
    rows : (3m,) int
        Rows of x, y, z of each retained node.
    left, right : (b,) int
        Nodes of the cyclic faces that are free to move, mates at equal places; empty for a part in
        one piece.
    means : (n, n) sparse or None
        The model's free dofs from those of K and M, where some of these are patch means; see
        `vanelock.rom.joining.patches`.
    cyclic : bool
        Whether it continues into its neighbours.
    """

    model: Model
    masters: Masters
    K: sp.csc_array
    M: sp.csc_array
    rows: Integers
    left: Integers
    right: Integers
    means: sp.csc_array | None = None
    cyclic: bool = False

    @property
    def face_rows(self) -> Integers:
        """(6b,) rows of the left face, then of the right one."""
        rows: Integers = self.model.dofs[np.concatenate([self.left, self.right])].ravel()
        return rows

    @property
    def boundary_rows(self) -> Integers:
        """(6b + 3m,) rows of both faces, then of the masters."""
        return np.concatenate([self.face_rows, self.rows])

    @property
    def boundary_nodes(self) -> Integers:
        """(2b + m,) nodes of both faces, then the retained ones."""
        return np.concatenate([self.left, self.right, self.masters.nodes])

    def field(self, z: Matrix) -> Matrix:
        """Displacement (nodes, 3, k) of vectors (n, k) of the dofs of K and M."""
        u: Matrix = self.model.field(z if self.means is None else self.means @ z)
        return u


def problem(model: Model, masters: Masters, cyclic: bool) -> Problem:
    """Matrices and rows of a part whose reduction keeps `masters`."""
    name, none = model.part.name, np.empty(0, np.int64)
    left, right = _free_faces(model) if cyclic else (none, none)
    if shared := sorted(set(masters.nodes) & {*left, *right}):
        raise InputError(f"{name}: node {shared[0]} is a master and on a cyclic face")
    rows = model.dofs[masters.nodes]
    if np.any(rows < 0):
        clamped = masters.nodes[np.any(rows < 0, axis=1)]
        raise InputError(f"{name}: master node {clamped[0]} is clamped")
    if 2 * 3 * len(left) + rows.size == model.K.shape[0]:
        raise InputError(
            f"{name}: no node is left beside masters and cyclic faces: nothing to reduce"
        )
    means, K, M = with_means(model, masters.averaged)
    return Problem(model, masters, K, M, rows.ravel(), left, right, means, cyclic)


def condense(problem: Problem) -> tuple[Matrix, Interior]:
    """Stiffness condensed to faces and masters, and the factors of the rest."""
    rows = problem.boundary_rows
    try:
        S, interior = schur_complement(problem.K, rows)
        return S, interior
    except SingularError as error:
        rest = np.setdiff1d(np.arange(problem.K.shape[0]), rows)
        raise InputError(not_held(problem, error, rest)) from None


def not_held(problem: Problem, error: SingularError, rest: Integers) -> str:
    """What can still move although only the rows `rest` are free."""
    moving = rest if problem.means is None else problem.means[:, rest]
    found: str = free_motion(problem.model, error, moving)
    return found


def _free_faces(model: Model) -> tuple[Integers, Integers]:
    """Matching nodes of the left and right faces, those of clamped edges left out."""
    left, right = cyclic_faces(model.part, model.part.sectors)
    if np.any(on_axis := left == right):
        raise InputError(
            f"{model.part.name}: node {left[on_axis][0]} lies on the axis: a part that is reduced "
            "must not"
        )
    free = model.dofs[left, 0] >= 0
    if np.any(alone := free != (model.dofs[right, 0] >= 0)):
        raise InputError(
            f"{model.part.name}: node {left[alone][0]} of `left` and its mate {right[alone][0]} of "
            "`right`: one is clamped, the other free"
        )
    return left[free], right[free]
