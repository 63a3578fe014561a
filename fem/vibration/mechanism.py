"""The free motions of a singular stiffness in words: which nodes of the part move, and how."""

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.fem.model import Model
from vanelock.fem.solvers.backend import Sparse
from vanelock.fem.solvers.singular import MOVING, SOUGHT, SingularError

RIGID = 1e-6  # 1 - cosine of the angle to the rigid-body motions, below which a motion is one
NAMED = 3  # nodes that are named one by one


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
    """
    motions = _of_all_dofs(model, error, rows)
    body = _rigid_motions(model)
    # Combinations of the free motions, from those nearest to a rigid-body motion.
    _, cosines, turns = np.linalg.svd(body.conj().T @ motions)
    whole = int(np.sum(1 - cosines < RIGID))
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
            + _nodes(model, motions[:, whole:], NAMED)
        )
    remedy = "hold a set of nodes or give a negative shift" if whole else "join or hold these nodes"
    return f"{model.part.name}: {'; '.join(words)}; {remedy}"


def _of_all_dofs(model: Model, error: SingularError, rows: Any) -> Array:
    """Orthonormal motions (n, count) of the model's dofs."""
    if rows is None:
        return error.motions
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
    moving = order[size[order] > MOVING * size.max()]
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
