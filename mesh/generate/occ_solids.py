"""Solids of revolution and curves on them, for gmsh's OpenCASCADE kernel.

The functions take the module `gmsh` of an open session and return entity tags.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.mesh.geometry.revolved import PIECE, Corner, edges

Entity = tuple[int, int]  # dimension, tag

# The kernel's intersections are good to 1e-7 m.
TOLERANCE = 1e-6

_ASPECT, _DRAWN_OUT = 10.0, 24.0
"""Elements along a fillet are at most so many times longer than its pieces are wide: as they are
meshed, and once they are drawn out around the ring."""


def revolve(gmsh: Any, corners: Sequence[Corner], half_angle: float) -> Entity:
    """Solid from an outline in radius and z, revolved from -half_angle to +half_angle about z."""
    occ = gmsh.model.occ
    c, s = np.cos(half_angle), np.sin(half_angle)

    def put(point: Floats) -> int:
        tag: int = occ.addPoint(point[0] * c, -point[0] * s, point[1])
        return tag

    outline = edges(corners)
    starts = [put(edge.start) for edge in outline]
    curves = []
    for edge, start, end in zip(outline, starts, starts[1:] + starts[:1], strict=True):
        if edge.centre is None:
            curves.append(occ.addLine(start, end))
        else:
            centre = put(edge.centre)
            curves.append(occ.addCircleArc(start, centre, end))
            occ.remove([(0, centre)])
    face = (2, occ.addPlaneSurface([occ.addCurveLoop(curves)]))
    swept = occ.revolve([face], 0, 0, 0, 0, 0, 1, 2 * half_angle)
    solid: Entity = next(entity for entity in swept if entity[0] == 3)
    return solid


def arc(gmsh: Any, start: Floats, end: Floats) -> Entity:
    """Circular arc about z between two points of one radius and axial position."""
    occ = gmsh.model.occ
    centre = occ.addPoint(0.0, 0.0, start[2])
    tag = occ.addCircleArc(occ.addPoint(*start), centre, occ.addPoint(*end))
    occ.remove([(0, centre)])
    return 1, tag


def point(gmsh: Any, position: Floats) -> Entity:
    """A point to imprint on a face."""
    return 0, gmsh.model.occ.addPoint(*position)


def imprint(gmsh: Any, solid: Entity, *others: Sequence[Entity]) -> list[list[int]]:
    """Fragment a solid with curves and points that lie on its faces.

    They are embedded there, so that the mesh follows them.
    """
    tools = [entity for entities in others for entity in entities]
    _, pieces = gmsh.model.occ.fragment([solid], tools)
    gmsh.model.occ.synchronize()
    if any(len(piece) != 1 for piece in pieces):
        raise InputError(f"{gmsh.model.getCurrent()}: a contact band or a point leaves its face")
    tags = iter([piece[0][1] for piece in pieces[1:]])
    return [[next(tags) for _ in entities] for entities in others]


def grade_fillets(gmsh: Any, fillet: float, size: float, stretch: float = 1.0) -> None:
    """Limit the elements along fillets to a multiple of their width, evenly around the ring."""
    longest = min(size, min(_ASPECT, _DRAWN_OUT / stretch) * PIECE * fillet)
    for _, face in gmsh.model.getEntities(2):
        if gmsh.model.getType(2, face) != "Torus":
            continue
        for _, edge in gmsh.model.getBoundary([(2, face)], oriented=False):
            length = gmsh.model.occ.getMass(1, edge)
            if length > np.pi * fillet:  # none of the arcs in the section
                intervals = int(np.ceil(length / longest))
                gmsh.model.mesh.setTransfiniteCurve(edge, intervals + 1)
