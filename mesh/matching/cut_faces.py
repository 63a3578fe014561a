"""What the cut faces of a user's sector must be, beyond that their listed nodes meet."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vanelock.common.cyclic import turn
from vanelock.mesh.cells import solid
from vanelock.mesh.exterior import exterior
from vanelock.mesh.matching.side import Side

Integers = NDArray[np.int64]


def check_cut_faces(side: Side, tolerance: float) -> list[str]:
    """Refuse cut faces of which nodes are not listed, or of whose mates one alone is clamped.

    Nodes left out would be a gap in the ring, which later stages would take for a free edge.
    """
    left, right = side.sets["left"], side.sets["right"]
    problems = []
    fixed = side.sets.get("fixed", np.empty(0, np.int64))
    own, mate = _unlisted(side, tolerance)
    both = np.isin(own, fixed) & np.isin(mate, fixed)  # clamped mates move as one in any case
    own, mate = own[~both], mate[~both]
    if len(own):
        problems.append(
            f"{side.source}, left and right: {_missing(len(own))}, such "
            f"as {side.describe(int(own[0]))}, which meets {side.describe(int(mate[0]))} when "
            f"turned by 2π/{side.sectors}: all nodes of the cut faces are needed"
        )
    alone = np.flatnonzero(np.isin(left, fixed) != np.isin(right, fixed))
    if len(alone):
        pair = [int(left[alone[0]]), int(right[alone[0]])]
        held, free = pair if pair[0] in fixed else pair[::-1]
        problems.append(
            f"{side.source}, fixed: at {len(alone)} of {len(left)} pairs of the cut faces one node "
            f"is clamped and its mate is not, such as {side.describe(held)} and its mate "
            f"{side.describe(free)}: clamp both or neither"
        )
    return problems


def _unlisted(side: Side, tolerance: float) -> tuple[Integers, Integers]:
    """Nodes on the outside that meet another one a sector further, both on neither face's list."""
    outside = np.unique(exterior(side.cells, solid(side.cell_type)))
    outside = np.setdiff1d(outside, np.concatenate([side.sets["left"], side.sets["right"]]))
    places = side.points[outside]
    none = np.empty(0, np.int64)
    if not len(outside):
        return none, none
    distance, nearest = cKDTree(places).query(places @ turn(side.sectors).T)
    own, mate = outside, outside[nearest]
    # A node on the axis meets itself, and in a ring of two either node of a pair meets the other.
    meet = (distance <= tolerance) & (own < mate if side.sectors == 2 else own != mate)
    return own[meet], mate[meet]


def _missing(count: int) -> str:
    return (
        "1 node of either face is missing"
        if count == 1
        else f"{count} nodes of either face are missing"
    )
