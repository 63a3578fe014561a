"""Frequencies that the mesh study measures errors against.

Re-entrant edges, where aerofoils meet shrouds and legs meet feet, limit the convergence of every
element: about an edge of 270° displacements grow as r^0.5445 (M. L. Williams, Stress singularities
resulting from various boundary conditions in angular corners of plates in extension, J. Appl.
Mech. 19 (1952) 526-528), so that frequencies are off as the size there to the power of 1.09.
References are therefore refined all over and most of all towards those edges, and extrapolated with
that power.
"""

from functools import partial
from importlib import import_module
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from benchmarks.mesh.blocks import Sizes
from benchmarks.mesh.families import SHARP, Row, hexahedral, measured
from vanelock import mesh
from vanelock.mesh import CasingDimensions, Part, VaneDimensions

Floats = NDArray[np.float64]

ORDER = 2 * 0.5445
SIZES = ((0.034, 0.0056), (0.017, 0.0028), (0.0085, 0.0014))  # away from those edges and at them, m
GROWTH = 0.7  # of the tetrahedra, of the distance from an edge


class Reference(NamedTuple):
    """Frequencies without error of the mesh.

    Attributes
    ----------
    rows : list of Row
        Its meshes, each twice as fine as the one before.
    frequency : (10,) float
        Extrapolated, Hz.
    order : (10,) float
        At which they converge.
    """

    rows: list[Row]
    frequency: Floats
    order: Floats


def reference() -> Reference:
    """Refine hexahedra of 20 nodes all over and most of all towards the re-entrant edges."""
    rows = []
    for size, corner in SIZES:
        name = f"{1e3 * size:g} mm, corners {1e3 * corner:g} mm"
        make = hexahedral("hexahedron20", Sizes(size, corner))
        rows.append(measured("hexahedron20, local", name, make))
    f = [row.frequency for row in rows]
    order = np.log2((f[-3] - f[-2]) / (f[-2] - f[-1]))
    return Reference(rows, extrapolated(f[-2], f[-1]), order)


def extrapolated(coarse: Floats, fine: Floats, order: float | Floats = ORDER) -> Floats:
    """Limit of values at a size and at half of it."""
    return np.asarray(fine + (fine - coarse) / (2**order - 1))


def graded(part: str, corner: float, size: float) -> Part:
    """The product's "vane" or "casing", its elements growing from the re-entrant edges."""
    module = import_module(f"vanelock.mesh.generate.{part}")
    make = {"vane": partial(mesh.vane_segment, SHARP), "casing": mesh.casing_sector}[part]
    usual = module.generate

    def generate(gmsh: Any, largest: float, *_others: Any) -> Any:
        field = gmsh.model.mesh.field
        distance, local = field.add("Distance"), field.add("MathEval")
        field.setNumbers(distance, "CurvesList", _reentrant(gmsh, part))
        field.setNumber(distance, "Sampling", 200)
        field.setString(local, "F", f"{corner} + {GROWTH} * F{distance}")
        field.setAsBackgroundMesh(local)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
        return usual(gmsh, largest)

    with patch.object(module, "generate", generate):
        return make(size=size)


def _reentrant(gmsh: Any, part: str) -> list[int]:
    """Curves along which walls meet at re-entrant angles."""
    vane, casing = VaneDimensions(), CasingDimensions()
    hook, mid = vane.hook, vane.hook.mid_plane
    arcs = {  # radius and axial position at the front; the rear mirrors them
        "vane": [
            (vane.outer_shroud_outer_radius, vane.leg_front),
            (vane.outer_shroud_outer_radius, vane.leg_rear),
            (hook.lip_radius, vane.leg_front),
        ],
        "casing": [
            (casing.outer_radius, casing.flange_thickness),
            (casing.inner_radius, casing.rail_front),
            (casing.inner_radius, casing.groove_mouth),
            (hook.roof_radius, casing.groove_bottom),
            (hook.lip_radius, casing.groove_bottom),
        ],
    }[part]
    roots = {  # radius, and the shroud's end before which the aerofoils stand
        "vane": [
            (vane.inner_shroud_outer_radius, vane.inner_shroud_front),
            (vane.outer_shroud_inner_radius, vane.outer_shroud_front),
        ],
        "casing": [],
    }[part]
    found = []
    for _, tag in gmsh.model.getEntities(1):
        low, high = gmsh.model.getParametrizationBounds(1, tag)
        x, y, z = np.reshape(gmsh.model.getValue(1, tag, np.linspace(low[0], high[0], 7)), (7, 3)).T
        radius, off, turn = np.hypot(x, y), mid - abs(z - mid), np.ptp(np.arctan2(y, x))
        on = [abs(radius - r).max() < 1e-5 for r, _ in arcs + roots]
        along = [abs(off - front).max() < 1e-5 for _, front in arcs]
        along += [off.min() > front + 1e-4 and turn > 1e-9 for _, front in roots]
        if any(a and b for a, b in zip(on, along, strict=True)):
            found.append(tag)
    least = 2 * len(arcs) + 4 * vane.aerofoils * len(roots)
    assert len(found) >= least, f"{len(found)} re-entrant edges of at least {least}"
    return found
