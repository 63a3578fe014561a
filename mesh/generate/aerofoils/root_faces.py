"""Divide the faces of aerofoils with fillets into rows and columns, before they are meshed.

As `faces` does without fillets: the fillets have the same columns as the aerofoil, and rows across
their arcs. The faces between them are cut at the quarters of the span, where output nodes lie.
"""

from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh.generate.aerofoils.faces import ROUND, divisions
from vanelock.mesh.generate.occ_solids import TOLERANCE
from vanelock.mesh.geometry import aerofoil, root_fillet
from vanelock.mesh.geometry.dimensions import VaneDimensions

TURN = np.radians(30.0)
"""Largest angle by which a fillet's elements turn from one row to the next, rad."""
_OFF = 5 * TOLERANCE  # m; where faces meet at a small angle, the kernel finds less exactly
_LEVELS = 7  # foot, top, three quarters, top, foot
_PIECES = _LEVELS - 1

Corner = tuple[int, int, int]
"""Aerofoil, level outwards, and the strip that begins there."""


def divide_filleted(gmsh: Any, vane: VaneDimensions, sectors: int, size: float) -> list[int]:
    """Prescribe the nodes on all faces of the aerofoils of the current model."""
    corners = _corners(gmsh, vane, sectors)
    faces = {}
    for _, face in gmsh.model.getEntities(2):
        bounding = gmsh.model.getBoundary([(2, face)], oriented=False, recursive=True)
        if len(bounding) == 4 and all(tag in corners for _, tag in bounding):
            faces[face] = [corners[tag] for _, tag in bounding]
    expected = vane.aerofoils * _PIECES * root_fillet.STRIPS
    if len(faces) != expected:
        raise InputError(
            f"vane.root_fillet = {vane.root_fillet or 0.0:g} m: {len(faces)} faces between the "
            f"shrouds instead of {expected}: the fillets leave their shrouds or meet"
        )
    across, divided = arc_rows(vane), divisions(vane, size)
    inner = divided.rows // 2 - divided.outer
    rows = (across, divided.outer, inner, inner, divided.outer, across)
    for face in faces:
        for _, curve in gmsh.model.getBoundary([(2, face)], oriented=False):
            ends = gmsh.model.getBoundary([(1, curve)], oriented=False)
            elements = _elements(rows, divided.columns, [corners[tag] for _, tag in ends])
            gmsh.model.mesh.setTransfiniteCurve(curve, elements + 1)
        gmsh.model.mesh.setTransfiniteSurface(face, "AlternateRight")
    return [face for face, ends in faces.items() if _on_a_side(ends)]


@lru_cache(maxsize=64)
def arc_rows(vane: VaneDimensions) -> int:
    """Rows of elements across a fillet."""
    return int(np.ceil(root_fillet.sweep(vane) / TURN))


def _elements(rows: tuple[int, ...], columns: int, ends: list[Corner]) -> int:
    """Elements along the curve between two corners, of rows from level to level and columns."""
    (_, low, one), (_, high, other) = sorted(ends)
    if low == high:
        return columns if _strip(one, other) % 2 == 0 else ROUND
    return rows[low]


def _strip(one: int, other: int) -> int:
    """The strip between the beginnings of two that follow each other."""
    return one if (one + 1) % root_fillet.STRIPS == other else other


def _on_a_side(ends: list[Corner]) -> bool:
    inside = all(0 < level < _LEVELS - 1 for _, level, _ in ends)
    one, other = {strip for _, _, strip in ends}
    return inside and _strip(one, other) % 2 == 0


def _corners(gmsh: Any, vane: VaneDimensions, sectors: int) -> dict[int, Corner]:
    """The model's vertices in which faces of aerofoils meet."""
    low, high = (root_fillet.strips(vane, outer) for outer in (False, True))
    quarters = np.array([root_fillet.levels(vane, k)[1:-1, 0] for k in range(root_fillet.STRIPS)])
    grid = np.concatenate(
        [
            root_fillet.feet(vane, False)[None],
            np.array([strip.top[0] for strip in low])[None],
            quarters.swapaxes(0, 1),
            np.array([strip.top[0] for strip in high])[None],
            root_fillet.feet(vane, True)[None],
        ]
    )
    grid[..., 2] += vane.hook.mid_plane
    turned = [grid @ rotation(angle).T for angle in aerofoil.angles(vane, sectors)]
    names = list(product(range(vane.aerofoils), range(_LEVELS), range(root_fillet.STRIPS)))
    tree = cKDTree(np.concatenate(turned).reshape(-1, 3))
    found: dict[int, Corner] = {}
    for _, tag in gmsh.model.getEntities(0):
        place: NDArray[np.float64] = gmsh.model.getValue(0, tag, [])
        distance, nearest = tree.query(place)
        if distance < _OFF:
            found[tag] = names[nearest]
    return found
