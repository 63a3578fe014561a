"""The motions that a singular matrix leaves free; in words: which nodes move, and how."""

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.model import Model
from vanelock.fem.solvers.backend import Solve, Sparse

# All thresholds are on eigenvalues of the matrix scaled to a unit diagonal.
_SINGULAR = 1e-16
"""Below it the matrix is singular. Round-off leaves some 1e-17 where a rigid-body motion is free;
thin flat elements come down to 1e-15."""
FREE = 1e-14
"""Below it a motion of a matrix that is singular counts as free."""
SOUGHT = 12
"""Motions that are looked for."""
_MOVING = 1e-3  # of the largest motion: a row that moves more takes part


class SingularError(InputError):
    """A matrix that leaves motions free.

    Attributes
    ----------
    rows : (k,) int
        Rows that move in them, the one that moves most first.
    count : int
        Number of free motions; twelve stands for twelve or more.
    motions : (n, count)
        Orthonormal basis of them.
    """

    def __init__(self, motions: Array) -> None:
        self.motions = motions
        self.count = motions.shape[1]
        share = np.linalg.norm(motions, axis=1)
        order = np.argsort(-share, kind="stable")
        self.rows: Integers = order[share[order] > _MOVING * share.max()]
        free = "a motion is free" if self.count == 1 else f"{self.count} motions are free"
        super().__init__(
            f"the matrix is not positive definite: {free}, in {_listed(self.rows)}; a part that is "
            "free to move as a rigid body needs a clamped set or a negative shift"
        )

    def __reduce__(self) -> tuple[type["SingularError"], tuple[Array]]:
        """Made again in another process from what it was made from, not from its message."""
        return SingularError, (self.motions,)


def _listed(rows: Integers) -> str:
    if len(rows) == 1:
        return f"row {rows[0]}"
    few = ", ".join(str(row) for row in rows[:4])
    return f"rows {few}" + (f" and {len(rows) - 4} others" if len(rows) > 4 else "")


def scale_of(A: sp.csc_array) -> Floats:
    """Square roots of the diagonal."""
    size = A.diagonal().real
    scale: Floats = np.sqrt(np.where(size > 0, size, 1.0))
    return scale


def is_singular(solve: Solve, scale: Floats) -> bool:
    """Whether two steps of inverse iteration find an eigenvalue below the threshold."""
    x = np.random.default_rng(0).standard_normal((len(scale), 1))
    for _ in range(2):
        x = x / np.linalg.norm(x)
        x = scale[:, None] * solve(scale[:, None] * x)
        if not np.linalg.norm(x) * _SINGULAR < 1:
            return True
    return False


def free_motions(A: sp.csc_array, solve: Solve, scale: Floats) -> tuple[Array, Floats]:
    """Motions that a matrix leaves free, and eigenvalues of the scaled one, ascending.

    Block inverse iteration with the factors of A, or of the lifted A.
    """
    scaled = sp.diags_array(1 / scale) @ A @ sp.diags_array(1 / scale)
    n = len(scale)
    x: Array = np.random.default_rng(0).standard_normal((n, min(SOUGHT, n)))
    for _ in range(4):
        x = np.linalg.qr(x)[0]
        x = scale[:, None] * solve(scale[:, None] * x)
    x = np.linalg.qr(x)[0]
    values, turns = np.linalg.eigh(x.conj().T @ (scaled @ x))
    free = abs(values) < FREE
    free[abs(values).argmin()] = True
    motions = np.linalg.qr((x @ turns[:, free]) / scale[:, None])[0]
    return motions, values


_RIGID = 1e-6  # 1 - cosine of the angle to the rigid-body motions, below which a motion is one
_NAMED = 3  # nodes that are named one by one


def free_motion(model: Model, error: SingularError, rows: Integers | Sparse | None = None) -> str:
    """One line that says what moves freely in a part whose stiffness has no inverse.

    Rigid-body motions of the whole part need a clamped set or a negative shift; motions of some of
    its nodes need a better mesh: a node without stiffness, or two
    bodies that hang together at an edge.

    Parameters
    ----------
    model : Model
        The part.
    error : SingularError
        What `factorise` raised.
    rows : (k,) int or (n, k) sparse, optional
        The model's dofs that the matrix's rows stand for, the others being held, or the
        transformation to the model's dofs (`cyclic_transform`); by default all dofs in order.

    Examples
    --------
    With the masters of a part held::

        try:
            factor = factorise(model.K[slaves][:, slaves])
        except SingularError as error:
            raise InputError(free_motion(model, error, slaves)) from None

    Raises
    ------
    InputError
        If the matrix has another number of rows.
    """
    motions = _of_all_dofs(model, error, rows)
    body = _rigid_motions(model)
    # Combinations of the free motions, from those nearest to a rigid-body motion.
    _, cosines, turns = np.linalg.svd(body.conj().T @ motions)
    whole = int(np.sum(1 - cosines < _RIGID))
    motions = motions @ turns.conj().T
    words = []
    if whole:
        one = "1 motion" if whole == 1 else f"{whole} motions"
        most = f", {_nodes(model, motions[:, :whole], 1)} the most" if whole < 6 else ""
        words.append(f"free to move as a rigid body: {one} not held{most}")
    local = motions.shape[1] - whole
    if local:
        count = f"{local} or more" if error.count == SOUGHT else str(local)
        words.append(
            f"{count} motion{'s' if local > 1 else ''} of some nodes without stiffness: "
            + _nodes(model, motions[:, whole:], _NAMED)
        )
    remedy = "hold a set of nodes or give a negative shift" if whole else "join or hold these nodes"
    return f"{model.part.name}: {'; '.join(words)}; {remedy}"


def _of_all_dofs(model: Model, error: SingularError, rows: Any) -> Array:
    """Orthonormal motions (n, count) of the model's dofs."""
    rows = np.arange(model.K.shape[0]) if rows is None else rows
    count = rows.shape[1] if sp.issparse(rows) else len(rows)
    if count != len(error.motions):
        raise InputError(f"rows: {count} of them; the matrix has {len(error.motions)}")
    if sp.issparse(rows):
        return np.linalg.qr(rows @ error.motions)[0]
    motions = np.zeros((model.K.shape[0], error.count), error.motions.dtype)
    motions[rows] = error.motions
    return motions


def _rigid_motions(model: Model) -> Floats:
    """Orthonormal basis (n, r) of the rigid-body motions that the clamped nodes allow."""
    points = model.part.points - model.part.points.mean(axis=0)
    points = points / np.linalg.norm(points, axis=1).max()
    field = np.zeros((len(points), 3, 6))
    field[:, :, :3] = np.eye(3)
    for axis in range(3):
        field[:, :, 3 + axis] = np.cross(np.eye(3)[axis], points)
    free = model.dofs >= 0
    if not free.all():
        field = field @ scipy.linalg.null_space(field[~free], rcond=1e-9)
    return np.linalg.qr(model.free(field))[0]


def _nodes(model: Model, motions: Array, named: int) -> str:
    """The nodes that move most, with their places and directions, and how many others move."""
    components = np.linalg.norm(model.field(motions), axis=2)
    size = np.linalg.norm(components, axis=1)
    order = np.argsort(-np.round(size / size.max(), 6), kind="stable")
    moving = order[size[order] > _MOVING * size.max()]
    words = []
    for node in moving[:named]:
        place = ", ".join(
            f"{a} = {p:.6g}" for a, p in zip("xyz", model.part.points[node], strict=True)
        )
        along = [a for a, c in zip("xyz", components[node], strict=True) if c > 0.1 * size[node]]
        words.append(f"node {node} ({place}) in {', '.join(along)}")
    others = len(moving) - len(words)
    if others and named > 1:
        words.append(f"{others} other node{'s' if others > 1 else ''}")
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
