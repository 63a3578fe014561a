"""Sharp re-entrant corners of a part: where linear elasticity has no stress to converge to.

At a re-entrant edge without a fillet the stress grows as r^(λ-1), λ < 1, towards the edge (M. L.
Williams, Stress singularities resulting from various boundary conditions in angular corners of
plates in extension, J. Appl. Mech. 19 (1952) 526-528), so that the value at its nodes only reflects
the mesh; so does that at a node which carries a contact's force. Such places need a fillet in the
model, or the stress some way off, as hot-spot rules for welds take it at 0.4 of the wall's
thickness and beyond (A. F. Hobbacher, Recommendations for Fatigue Design of Welded Joints and
Components, IIW, Springer 2016, section 2.2.3).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vanelock.common.arrays import Floats
from vanelock.mesh import Part
from vanelock.render.scenes.surface import surface

SHARP = 35.0
"""Degrees by which the skin turns at an edge: a meshed fillet turns by less in one step."""
READ_OUT = 0.4
"""Of the wall's thickness, the least distance from a corner at which a stress is read."""


def reentrant_edges(part: Part, bend: float = SHARP) -> Floats:
    """Ends (k, 2, 3) of the skin's edges that are sharp and re-entrant, m.

    Edges of the sector's left and right faces are none: the part goes on there.
    """
    skin = surface(part)
    points, triangles = part.points[skin.nodes], skin.triangles[~skin.cyclic]
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    normals /= np.where(length > 0, length, 1.0)[:, None]
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    owner = np.tile(np.arange(len(triangles)), 3)
    edges.sort(axis=1)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    same = np.flatnonzero(np.all(edges[1:] == edges[:-1], axis=1))
    one, other = owner[same], owner[same + 1]
    turned = np.einsum("ij,ij->i", normals[one], normals[other]) < np.cos(np.radians(bend))
    towards = corners[other].mean(axis=1) - points[edges[same, 0]]
    inwards = np.einsum("ij,ij->i", towards, normals[one]) > 0
    return np.asarray(points[edges[same][turned & inwards]])


def within(points: Floats, edges: Floats, distance: float) -> NDArray[np.bool_]:
    """(n,) points that lie within a distance of line segments (k, 2, 3), m."""
    if not len(edges):
        return np.zeros(len(points), bool)
    a, along = edges[:, 0], edges[:, 1] - edges[:, 0]
    longest = float(np.linalg.norm(along, axis=1).max())
    reach = distance + longest / 2
    near = cKDTree(edges.mean(axis=1)).query_ball_point(points, reach)
    found = np.zeros(len(points), bool)
    squared = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    for i, chosen in enumerate(near):
        if not chosen:
            continue
        to = points[i] - a[chosen]
        t = (np.einsum("ij,ij->i", to, along[chosen]) / squared[chosen]).clip(0, 1)
        gap = np.linalg.norm(to - t[:, None] * along[chosen], axis=1).min()
        found[i] = gap <= distance
    return found
