"""Solids of revolution and curves on them, for gmsh's OpenCASCADE kernel.

The functions take the module `gmsh` of an open session and return entity tags.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.errors import InputError

Entity = tuple[int, int]  # dimension, tag

# The kernel's intersections are good to 1e-7 m.
TOLERANCE = 1e-6


def revolve(gmsh: Any, outline: Sequence[tuple[float, float]], half_angle: float) -> Entity:
    """Solid from a polygon of (radius, z), revolved from -half_angle to +half_angle about z."""
    occ = gmsh.model.occ
    c, s = np.cos(half_angle), np.sin(half_angle)
    corners = [occ.addPoint(radius * c, -radius * s, z) for radius, z in outline]
    edges = [occ.addLine(*ends) for ends in zip(corners, corners[1:] + corners[:1], strict=True)]
    face = (2, occ.addPlaneSurface([occ.addCurveLoop(edges)]))
    swept = occ.revolve([face], 0, 0, 0, 0, 0, 1, 2 * half_angle)
    solid: Entity = next(entity for entity in swept if entity[0] == 3)
    return solid


def arc(gmsh: Any, start: NDArray[np.float64], end: NDArray[np.float64]) -> Entity:
    """Circular arc about z between two points of one radius and axial position."""
    occ = gmsh.model.occ
    centre = occ.addPoint(0.0, 0.0, start[2])
    tag = occ.addCircleArc(occ.addPoint(*start), centre, occ.addPoint(*end))
    occ.remove([(0, centre)])
    return 1, tag


def point(gmsh: Any, position: NDArray[np.float64]) -> Entity:
    """A point to imprint on a face."""
    return 0, gmsh.model.occ.addPoint(*position)


def imprint(gmsh: Any, solid: Entity, *others: Sequence[Entity]) -> list[list[int]]:
    """Fragment a solid with curves and points that lie on its faces.

    They are embedded there, so that the mesh follows them.

    Returns
    -------
    list of list of int
        For each sequence the tags that its entities have afterwards, one each.

    Raises
    ------
    InputError
        If an entity was cut in pieces.
    """
    tools = [entity for entities in others for entity in entities]
    _, pieces = gmsh.model.occ.fragment([solid], tools)
    gmsh.model.occ.synchronize()
    if any(len(piece) != 1 for piece in pieces):
        raise InputError(f"{gmsh.model.getCurrent()}: a contact band or a point leaves its face")
    tags = iter([piece[0][1] for piece in pieces[1:]])
    return [[next(tags) for _ in entities] for entities in others]


def faces_at(gmsh: Any, z: float) -> list[int]:
    """The faces that lie in the plane at z."""
    found = []
    for _, tag in gmsh.model.getEntities(2):
        _, _, low, _, _, high = gmsh.model.getBoundingBox(2, tag)
        if abs(low - z) < TOLERANCE and abs(high - z) < TOLERANCE:
            found.append(tag)
    return found


def end_faces(gmsh: Any, corners: int) -> tuple[int, int]:
    """The two plane faces of a revolved polygon with more than four corners, left one first."""
    found = {}
    for _, tag in gmsh.model.getEntities(2):
        if len(gmsh.model.getBoundary([(2, tag)], combined=False)) == corners:
            _, y, _ = gmsh.model.occ.getCenterOfMass(2, tag)
            found["left" if y < 0 else "right"] = tag
    return found["left"], found["right"]
