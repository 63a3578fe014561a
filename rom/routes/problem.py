"""What a reduction works on: the sparse matrices of one part and the rows that it keeps.

Patch means are degrees of freedom by an exact change of variables: each patch mean y = W x takes
the place of its contact node's displacement in

    x = T z,    K' = Tᵀ K T,    M' = Tᵀ M T,

and every other displacement stays a coordinate. One node p of each patch, its pivot, is expressed
by the mean and the others, x_p = W_p⁻¹ (y - W_r x_r). So a mean can be held, loaded or kept as a
master like any displacement, and whatever is done with K' and M' needs no constraint equations.

K' couples all nodes of a patch. On the scene's parts its factors are 1.6 times as large as those of
K on coarse and medium meshes and 1.3 times at 8 mm; to factorise takes 1.7 and 1.3 times as long.

By cyclic symmetry the right face of a sector follows the left one. In cylindrical components
x_r = x_l e^{-iφ}, φ = 2π ND/N; in Cartesian ones the vectors of the right face are also turned by
2π/N about the engine axis.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from vanelock.common.arrays import Booleans, Integers
from vanelock.common.cyclic import phase_factor, turn
from vanelock.common.errors import InputError
from vanelock.fem import Model, SingularError, cyclic_faces, free_motion
from vanelock.mesh import Part
from vanelock.rom.component import Masters
from vanelock.rom.system.system import Matrix

# As a pivot, a node that several patches touch counts for this share of its weight. Eliminating it
# couples those patches to one another, so that K' fills; a small weight costs digits instead.
_SHARED = 0.1
_DISTINCT = 1e-3  # least ratio of the pivots' weights: below it, patches have no node of their own


def with_means(
    model: Model, nodes: Integers
) -> tuple[sp.csc_array | None, sp.csc_array, sp.csc_array]:
    """T, K' and M' of a part with the means over the patches of some of its nodes.

    K and M themselves, and no T, where there are no such nodes.
    """
    if not len(nodes):
        return None, model.K, model.M
    T = _patch_transform(model, nodes)
    back = T.T.tocsc()  # products of unlike formats sort the large matrix anew

    def changed(A: sp.csc_array) -> sp.csc_array:
        B = back @ (A @ T)
        return sp.csc_array((B + B.T.tocsc()) / 2)

    return T, changed(model.K), changed(model.M)


def _patch_transform(model: Model, nodes: Integers) -> sp.csc_array:
    """The transformation x = T z after which the dofs of some contact nodes are patch means."""
    part = model.part
    free = np.flatnonzero(model.dofs[:, 0] >= 0)
    numbered = free[np.argsort(model.dofs[free, 0])]  # rows 3i to 3i + 2 are those of numbered[i]
    number = np.full(len(part.points), -1)
    number[numbered] = np.arange(len(numbered))
    reserved = np.isin(numbered, np.concatenate([[-1], *part.node_sets.values()]))
    reserved[number[nodes]] = False
    weights = _patch_weights(part, nodes)[:, numbered]
    pivots = _pivots(sp.csc_array(weights), ~reserved, part.name)
    T = _of_one_component(weights, number[nodes], pivots)
    return sp.csc_array(sp.kron(T, sp.eye_array(3), format="csc"))


def _patch_weights(part: Part, nodes: Integers) -> sp.csr_array:
    """Weights (k, n) of all nodes in the mean over the patch of each of some contact nodes."""
    place = np.full(len(part.points), -1)
    rows, first = [sp.csr_array((0, len(part.points)))], 0
    for name, weights in part.patches.items():
        place[part.node_sets[name]] = first + np.arange(weights.shape[0])
        rows.append(sp.csr_array(weights))
        first += weights.shape[0]
    if np.any(without := place[nodes] < 0):
        raise InputError(f"{part.name}: contact node {nodes[without][0]} has no patch")
    return sp.csr_array(sp.csr_array(sp.vstack(rows))[place[nodes]])


def _of_one_component(weights: sp.csr_array, contact: Integers, pivots: Integers) -> sp.csr_array:
    """T between nodes: weights (k, n), the nodes (k,) whose places the means take, the pivots."""
    k, n = weights.shape
    # The displacement of a contact node that is no pivot moves to the place of one.
    place = np.arange(n)
    place[np.setdiff1d(contact, pivots)] = np.setdiff1d(pivots, contact)
    rest = np.setdiff1d(np.arange(n), pivots)
    others = sp.csr_array((np.ones(len(rest)), (rest, place[rest])), shape=(n, n))
    means = sp.csr_array((np.ones(k), (np.arange(k), contact)), shape=(k, n))
    # Between patches that no pivot links, elimination leaves exact zeros, which are not stored.
    inverse = sp.csr_array(np.linalg.inv(weights[:, pivots].toarray()))
    eliminated = inverse @ (means - weights @ others)
    spread = sp.csr_array((np.ones(k), (pivots, np.arange(k))), shape=(n, k))
    return sp.csr_array(others + spread @ eliminated)


def _pivots(weights: sp.csc_array, allowed: Booleans, name: str) -> Integers:
    """Nodes (k,), in any order, that the means and the other nodes determine well.

    QR with column pivoting. Where the mesh is fine enough each is of one patch alone.
    """
    candidates = np.flatnonzero((np.diff(weights.indptr) > 0) & allowed)
    columns = weights[:, candidates]
    preference = np.where(np.diff(columns.indptr) == 1, 1.0, _SHARED)
    R, order = scipy.linalg.qr(columns.toarray() * preference, mode="r", pivoting=True)
    k = weights.shape[0]
    size = np.abs(np.diagonal(R))[:k]
    if len(size) < k or not size.min(initial=1.0) > _DISTINCT * size.max(initial=0.0):
        raise InputError(
            f"{name}: the mesh is too coarse to resolve the contact patches: "
            "choose another mesh.size"
        )
    return np.asarray(candidates[order[:k]])


def cyclic_constraint(faces: int, others: int, nodal_diameter: int, sectors: int) -> sp.csr_array:
    """W_cs in (x_l, x_r, others) = W_cs (x_l, others)."""
    follow = phase_factor(nodal_diameter, sectors) * turn(sectors)
    left = sp.vstack([sp.eye_array(3 * faces), sp.kron(sp.eye_array(faces), follow)])
    return sp.csr_array(sp.block_diag([left, sp.eye_array(others)]))


@dataclass(frozen=True)
class Problem:
    """A part, the rows of its masters, and those of its cyclic faces."""

    model: Model  # the part
    masters: Masters  # its retained nodes
    K: sp.csc_array
    """(n, n), real stiffness, N/m, and mass, kg; the model's, or those with patch means among
    the dofs."""
    M: sp.csc_array
    rows: Integers  # (3m,), rows of x, y, z of each retained node
    left: Integers
    """(b,), nodes of the cyclic faces that are free to move, mates at equal places; empty for a
    part in one piece."""
    right: Integers
    means: sp.csc_array | None = None
    """(n, n), the model's free dofs from those of K and M, where some of these are patch means;
    see `vanelock.rom.routes.problem`."""
    cyclic: bool = False  # whether it continues into its neighbours

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
