"""Aerofoils as solids: ruled between two sections, or sewn from faces where they have fillets.

They reach from inside the inner to inside the outer shroud, with which they are then united.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.mesh.generate.occ_solids import Entity
from vanelock.mesh.geometry import aerofoil, root_fillet
from vanelock.mesh.geometry.dimensions import VaneDimensions

DECIMALS = 10
"""Of the places, m, and weights that the kernel gets of an aerofoil: processors differ in digits
beyond, and where they do the mesher connects other nodes."""


def aerofoil_solids(gmsh: Any, vane: VaneDimensions, sectors: int) -> list[Entity]:
    """The aerofoils of a segment, in the open session."""
    made = []
    strips = root_fillet.faces(vane) if vane.root_fillet else []
    for angle in aerofoil.angles(vane, sectors):
        solid = _filleted(gmsh, vane, strips) if strips else _ruled(gmsh, vane)
        gmsh.model.occ.rotate([solid], 0, 0, 0, 0, 0, 1, angle)
        made.append(solid)
    return made


def remove_strays(gmsh: Any, solid: Entity) -> None:
    """Remove what is left of faces that were sewn: all that does not bound the solid."""
    kernel = gmsh.model.occ
    kernel.synchronize()
    bounding = [solid]
    for dimension in (2, 1, 0):
        bounding = gmsh.model.getBoundary(bounding, combined=False, oriented=False)
        bounding = list(dict.fromkeys(bounding))
        kept = set(bounding)
        kernel.remove([each for each in kernel.getEntities(dimension) if each not in kept])
    kernel.synchronize()


def _ruled(gmsh: Any, vane: VaneDimensions) -> Entity:
    kernel = gmsh.model.occ
    start, end = aerofoil.ends(vane)
    root = _section(gmsh, vane, start)
    if vane.twist == 0:
        shift = np.tan(np.radians(vane.lean)) * (end - start)
        face = (2, kernel.addPlaneSurface([root]))
        swept = kernel.extrude([face], end - start, shift, 0)
    else:
        tip = _section(gmsh, vane, end)
        swept = kernel.addThruSections([root, tip], makeSolid=True, makeRuled=True)
    solid: Entity = next(entity for entity in swept if entity[0] == 3)
    return solid


def _section(gmsh: Any, vane: VaneDimensions, along: float) -> int:
    """Closed wire around an aerofoil's section, in the frame of its radial axis."""
    kernel = gmsh.model.occ

    def point(place: NDArray[np.float64]) -> int:
        return _put(gmsh, along, place[0], vane.hook.mid_plane + place[1])

    sides = [[point(p) for p in s] for s in aerofoil.outline(vane, aerofoil.STATIONS, along)]
    leading, trailing = (point(place) for place in aerofoil.edges(vane, along).control)
    convex, concave = sides[0], sides[1][::-1]
    wire: int = kernel.addWire(
        [
            kernel.addSpline(convex),
            kernel.addBezier([convex[-1], trailing, concave[0]]),
            kernel.addSpline(concave),
            kernel.addBezier([concave[-1], leading, convex[0]]),
        ]
    )
    # Only the ends of its curves are points of the wire.
    kernel.remove([(0, tag) for tag in (*convex[1:-1], *concave[1:-1], leading, trailing)])
    return wire


def _filleted(
    gmsh: Any, vane: VaneDimensions, strips: list[list[root_fillet.RationalFace]]
) -> Entity:
    kernel = gmsh.model.occ
    faces = [_face(gmsh, vane, face) for strip in strips for face in strip]
    for end, row in ((0, 0), (-1, -1)):
        rim = [_curve(gmsh, vane, strip[end], row) for strip in strips]
        faces.append(kernel.addPlaneSurface([kernel.addWire(rim)]))
    solid = (3, kernel.addVolume([kernel.addSurfaceLoop(faces, sewing=True)]))
    kernel.remove([(2, face) for face in faces], recursive=True)
    return solid


def _face(gmsh: Any, vane: VaneDimensions, face: root_fillet.RationalFace) -> int:
    points, weights, knots = face.control()
    values, counts = np.unique(knots, return_counts=True)
    degree = len(points) - 1
    tags = [_point(gmsh, vane, place) for row in points for place in row]
    made: int = gmsh.model.occ.addBSplineSurface(
        tags,
        points.shape[1],
        degreeU=3,
        degreeV=degree,
        weights=np.round(weights, DECIMALS).ravel().tolist(),
        knotsU=np.round(values, DECIMALS).tolist(),
        knotsV=[0.0, 1.0],
        multiplicitiesU=counts.tolist(),
        multiplicitiesV=[degree + 1, degree + 1],
    )
    gmsh.model.occ.remove([(0, tag) for tag in tags])
    return made


def _curve(gmsh: Any, vane: VaneDimensions, face: root_fillet.RationalFace, row: int) -> int:
    """The first or the last of the curves along a face."""
    points, _, knots = face.control()
    values, counts = np.unique(knots, return_counts=True)
    tags = [_point(gmsh, vane, place) for place in points[row]]
    curve: int = gmsh.model.occ.addBSpline(
        tags, degree=3, knots=np.round(values, DECIMALS).tolist(), multiplicities=counts.tolist()
    )
    gmsh.model.occ.remove([(0, tag) for tag in tags[1:-1]])
    return curve


def _point(gmsh: Any, vane: VaneDimensions, place: NDArray[np.float64]) -> int:
    return _put(gmsh, place[0], place[1], vane.hook.mid_plane + place[2])


def _put(gmsh: Any, *place: float) -> int:
    tag: int = gmsh.model.occ.addPoint(*np.round(place, DECIMALS))
    return tag
