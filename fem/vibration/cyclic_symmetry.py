"""Cyclic symmetry: the constraint that ties the two faces of a sector."""

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from vanelock.common.arrays import Integers
from vanelock.common.cyclic import phase_factor, turn
from vanelock.common.errors import InputError
from vanelock.fem.model import Model
from vanelock.mesh import Part
from vanelock.mesh.part import called

TOLERANCE = 1e-6  # of the part's size: how far a face node may lie from its mate's image


def cyclic_transform(model: Model, nodal_diameter: int, sectors: int | None = None) -> sp.csc_array:
    """Transformation x = T y of the free dofs of a sector that vibrates at one nodal diameter.

    A wave of nodal diameter k repeats itself from one sector to the next, turned by 2π/N about
    the axis z and delayed by φ = 2π k/N, so that the faces obey

        u_right = R_z(2π/N) u_left e^{-iφ},

    and the sector's matrices become Tᴴ K T, Tᴴ M T. Those of k and N - k are complex conjugates.

    Parameters
    ----------
    model : Model
        One sector, whose part has the sets `left` and `right`.
    nodal_diameter : int
        k, taken modulo N.
    sectors : int, optional
        N, at least 2; by default that of the part.

    Returns
    -------
    (n, n_c) csc_array
        Real for k = 0 and k = N/2, else complex. Its columns are the model's dofs without those
        of the right face, in the same order. A face node whose mate is clamped is held too. A
        node on the axis is its own mate and keeps the motions that the wave allows there; their
        columns come last.

    Raises
    ------
    InputError
        If a face is missing, or the right one is not the left one turned by 2π/N.

    Notes
    -----
    After D. L. Thomas, Dynamics of rotationally periodic structures, Int. J. Numer. Meth. Engng
    14 (1979) 81-102, written in Cartesian components.
    """
    part = model.part
    sectors = part.sectors if sectors is None else sectors
    left, right = cyclic_faces(part, sectors)
    follow = turn(sectors) * phase_factor(nodal_diameter, sectors)
    n = model.K.shape[0]
    on_axis = left == right
    centre = model.dofs[left[on_axis]]
    centre = centre[centre[:, 0] >= 0]
    l_rows, r_rows = model.dofs[left[~on_axis]], model.dofs[right[~on_axis]]
    l_free, r_free = l_rows[:, 0] >= 0, r_rows[:, 0] >= 0
    dependent = [r_rows[r_free], l_rows[l_free & ~r_free], centre]
    kept = np.setdiff1d(np.arange(n), np.concatenate(dependent))
    column = np.full(n, -1)
    column[kept] = np.arange(len(kept))

    mates = l_free & r_free
    rows = np.repeat(r_rows[mates], 3)  # each row of a right node takes three left ones
    columns = column[np.repeat(l_rows[mates], 3, axis=0)].ravel()
    values = np.tile(follow.ravel(), int(mates.sum()))
    allowed = scipy.linalg.null_space(follow - np.eye(3), rcond=1e-9)  # of a node on the axis
    spread = np.arange(centre.shape[0] * allowed.shape[1]).reshape(
        len(centre), allowed.shape[1]
    ) + len(kept)
    T = sp.coo_array(
        (
            np.concatenate([np.ones(len(kept)), values, np.tile(allowed.ravel(), len(centre))]),
            (
                np.concatenate([kept, rows, np.repeat(centre, allowed.shape[1])]),
                np.concatenate(
                    [np.arange(len(kept)), columns, np.repeat(spread, 3, axis=0).ravel()]
                ),
            ),
        ),
        shape=(n, len(kept) + spread.size),
    ).tocsc()
    T.eliminate_zeros()
    return T


def cyclic_faces(part: Part, sectors: int) -> tuple[Integers, Integers]:
    """Node numbers of the sets `left` and `right`, mates at equal places.

    Raises
    ------
    InputError
        If a face is missing, or the right one is not the left one turned by 2π/N.
    """
    if sectors < 2:
        raise InputError(f"{part.name}: sectors = {sectors}: cyclic symmetry needs at least 2")
    for name in ("left", "right"):
        if called(part.node_sets, name) is None:
            raise InputError(f"{part.name}: cyclic symmetry needs a node set {name!r}")
    left, right = part.nodes("left"), part.nodes("right")
    if len(left) != len(right):
        raise InputError(
            f"{part.name}: {len(left)} nodes in `left`, {len(right)} in `right`: they must match"
        )
    gap = np.linalg.norm(part.points[right] - part.points[left] @ turn(sectors).T, axis=1)
    if len(gap) and gap.max() > TOLERANCE * np.ptp(part.points, axis=0).max():
        raise InputError(
            f"{part.name}: right node {right[gap.argmax()]} lies {gap.max():.3g} m from left node "
            f"{left[gap.argmax()]} turned by 2π/{sectors}: the faces must match node by node"
        )
    return left, right
