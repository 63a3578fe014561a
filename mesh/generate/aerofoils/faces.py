"""Divide the faces of aerofoils into rows and columns, before they are meshed.

A rounded edge is a face up to a thousand times longer than wide, and the two sides of an aerofoil
may lie closer to each other than an element is long. Left to itself the mesher joins nodes across
such a face from one shroud to the other, or lets the triangles of the two sides cross. Divided like
a chessboard, in as many columns along the chord and rows along the span on both sides, they keep
their distance, and the places of the output nodes are corners of the board.

Rows are short at the shrouds, where stresses grow, and long between, unless the thickness of the
rounded edges asks for short ones everywhere. With u from 0 to 1 along the rows and s along the
span,

    s = 1/2 + tanh(κ (2u - 1)) / (2 tanh κ),

which gmsh calls "Bump", its coefficient 1 - tanh²κ. κ is such that a corner stays at each quarter.
"""

from typing import Any, NamedTuple

import numpy as np

from vanelock.common.errors import InputError
from vanelock.mesh.generate.occ_solids import TOLERANCE
from vanelock.mesh.geometry import aerofoil
from vanelock.mesh.geometry.dimensions import VaneDimensions
from vanelock.mesh.geometry.element_size import SLENDER, thin

ROUND = 2
"""Columns around a rounded edge. A single element's side there bows by half its length, which
makes thin aerofoils stiffer in torsion than even straight sides do."""

_MESH_ADAPT = 1  # gmsh's number of the algorithm that grades a face to edges of 1 % of its size

WIDE = 0.5
"""Elements across an aerofoil's chord, in element sizes: its bending is found from few."""
NEAR = 5 / 3
"""Rows in each outer quarter of the span, over those in each inner one, by the elements' size."""


class Divisions(NamedTuple):
    """Rows along the span, those of them in each outer quarter, and columns along the chord."""

    rows: int
    outer: int
    columns: int

    @property
    def bump(self) -> float:
        """The coefficient of rows that have corners at the quarters of the span."""
        from scipy.optimize import brentq  # checks count elements, and need not load it

        share = 1 - 2 * self.outer / self.rows
        if share >= 0.5:
            return 1.0
        kappa = brentq(lambda k: np.tanh(k * share) - np.tanh(k) / 2, 1e-3, 20.0)
        return float(1 - np.tanh(kappa) ** 2)


def divide_aerofoils(gmsh: Any, vane: VaneDimensions, size: float) -> list[int]:
    """Prescribe the nodes on all faces of the aerofoils of the current model."""
    ends = _ends(gmsh, vane)
    faces = []
    for _, tag in gmsh.model.getEntities(2):
        corners = gmsh.model.getBoundary([(2, tag)], recursive=True)
        if all(corner in ends for _, corner in corners):
            faces.append(tag)
    if len(faces) != 4 * vane.aerofoils:
        raise InputError(
            f"vane.aerofoils = {vane.aerofoils}: {len(faces)} faces between the shrouds instead of "
            f"{4 * vane.aerofoils}: the aerofoils leave their shrouds"
        )
    rows, _, columns = found = divisions(vane, size)
    sides: list[int] = []
    shrouds: set[int] = set()
    for face in faces:
        for _, curve in gmsh.model.getBoundary([(2, face)], oriented=False):
            first, last = (ends[corner] for _, corner in gmsh.model.getBoundary([(1, curve)]))
            if first != last:
                gmsh.model.mesh.setTransfiniteCurve(curve, rows + 1, "Bump", found.bump)
                continue
            along = gmsh.model.occ.getMass(1, curve) > 0.5 * vane.chord  # or round an edge
            gmsh.model.mesh.setTransfiniteCurve(curve, (columns if along else ROUND) + 1)
            shrouds.update(gmsh.model.getAdjacencies(1, curve)[0].tolist())
            if along and face not in sides:
                sides.append(face)
        gmsh.model.mesh.setTransfiniteSurface(face, "AlternateRight")
    if thin(vane, size):
        for shroud in shrouds.difference(faces):
            gmsh.model.mesh.setAlgorithm(2, shroud, _MESH_ADAPT)
    return sides


def divisions(vane: VaneDimensions, size: float) -> Divisions:
    """How an aerofoil's sides are divided; columns are an even number.

    Elements are no longer than `SLENDER` edges are thick, a tenth more where rows differ in height,
    and the camber line's arc stands no further off an element's side than a quarter of the
    aerofoil's thickness.
    """
    span = vane.outer_shroud_inner_radius - vane.inner_shroud_outer_radius
    span /= np.cos(np.radians(vane.lean))
    by_size, by_edge = (
        int(np.ceil(span / 4 / longest)) for longest in (size, SLENDER * vane.edge_thickness)
    )
    inner = max(by_size, by_edge)
    outer = max(int(np.ceil(NEAR * by_size)), by_edge)
    bent = np.sqrt(4 * vane.camber * vane.chord / vane.thickness)
    columns = max(vane.chord / (WIDE * size), bent, 1.0)
    return Divisions(2 * (inner + outer), outer, 2 * int(np.ceil(columns / 2)))


def _ends(gmsh: Any, vane: VaneDimensions) -> dict[int, int]:
    """The vertices where aerofoils meet the inner shroud, 0, and the outer one, 1."""
    radii = np.array([vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius])
    half = max(float(np.abs(aerofoil.around(vane, radius)[:, 1]).max()) for radius in radii)
    found = {}
    for _, tag in gmsh.model.getEntities(0):
        x, y, z = gmsh.model.getValue(0, tag, [])
        off = np.abs(np.hypot(x, y) - radii)
        if off.min() < TOLERANCE and abs(z - vane.hook.mid_plane) < half + TOLERANCE:
            found[tag] = int(off.argmin())
    return found
