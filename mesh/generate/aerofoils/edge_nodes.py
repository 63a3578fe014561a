"""Nodes in the middle of sides that run around an aerofoil's rounded edge.

The kernel finds them by iteration on the surface, and not always half-way. There they must be for a
quadratic element's side to be the parabola that rounds the edge.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.common.cyclic import rotation
from vanelock.mesh.generate.extract import MeshArrays
from vanelock.mesh.geometry import aerofoil
from vanelock.mesh.geometry.dimensions import VaneDimensions

TRIANGLE6 = 9  # gmsh's number of the element type
_SIDES = [(0, 1), (1, 2), (2, 0)]


def half_way(gmsh: Any, mesh: MeshArrays, vane: VaneDimensions, sectors: int) -> MeshArrays:
    """The mesh with those nodes half-way around."""
    points = mesh.points.copy()
    for _, tag in gmsh.model.getEntities(2):
        _, tags = gmsh.model.mesh.getElementsByType(TRIANGLE6, tag)
        triangles = mesh.number(tags).reshape(-1, 6)
        for angle in aerofoil.angles(vane, sectors):
            found = _on_edge(mesh, vane, triangles, rotation(angle))
            if found is not None:
                points[triangles[:, 3:].ravel()] = found
    return replace(mesh, points=points)


def _on_edge(
    mesh: MeshArrays, vane: VaneDimensions, triangles: NDArray[np.int64], turn: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Middles (3t, 3) of the triangles' sides, if they cover a rounded edge of this aerofoil."""
    axis = np.array([0.0, 0.0, vane.hook.mid_plane])
    corners = (mesh.points[triangles[:, :3]].reshape(-1, 3) - axis) @ turn
    for number in (0, 1):
        aside = aerofoil.on_rounding(vane, corners, number)
        if aside is not None:
            along, round_ = (
                v.reshape(-1, 3)[:, _SIDES].mean(axis=2) for v in (corners[:, 0], aside)
            )
            middles = aerofoil.rounding(vane, along.ravel(), round_.ravel(), number)
            return np.asarray(middles @ turn.T + axis)
    return None
