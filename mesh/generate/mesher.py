"""Mesh with linear tetrahedra, again with slightly smaller ones where a sliver remains.

Whether the mesher leaves a sliver somewhere is chance, and some of them cannot be curved. A size a
few per cent smaller leads to another mesh. Where all of these have a bad one, Netgen's optimiser,
which splits elements, too, takes slivers away at a third more unknowns.
"""

from typing import Any

import numpy as np

from vanelock.mesh.checks.tetrahedra import condition
from vanelock.mesh.generate.flat_elements import level
from vanelock.mesh.generate.stretch import drawn_out
from vanelock.mesh.geometry.element_size import Local

FINER = (1.0, 0.98, 0.96, 0.93, 0.9, 0.86)
"""Sizes to try, relative to the one asked for."""
ENOUGH = 0.05
"""Smallest condition number (SICN) at which no other size is tried."""
BAD = 0.03
"""Smallest condition number that is not worth a third more unknowns."""
# Condition numbers below which the mesher changes an element: at first slivers only, since it
# tries in vain, for minutes, to improve what is flat because the wall is thin.
_SLIVER, _POOR = 0.02, 0.3
_TETRAHEDRON = 4  # gmsh's number of the linear element type


def tetrahedra(
    gmsh: Any,
    size: float,
    local: Local | None = None,
    stretch: float = 1.0,
    same_faces: bool = False,
) -> None:
    """Mesh the current model with linear tetrahedra no larger than `size`, m."""
    reached: dict[tuple[float, bool], float] = {}
    for split in (False, True):
        if max(reached.values(), default=-1.0) > BAD:
            break
        for finer in FINER:
            last = finer, split
            try:
                reached[last] = _attempt(gmsh, size, local, stretch, same_faces, *last)
            except Exception:  # all that gmsh raises
                reached[last] = -1.0
            if reached[last] > ENOUGH:
                return
    best = max(reached, key=reached.__getitem__)
    if best != last or reached[best] < 0:
        _attempt(gmsh, size, local, stretch, same_faces, *best)


def _attempt(
    gmsh: Any,
    size: float,
    local: Local | None,
    stretch: float,
    same_faces: bool,
    finer: float,
    split: bool,
) -> float:
    """Mesh anew; the smallest condition number, or 0 if an element lies flat on a face."""
    gmsh.model.mesh.clear()
    gmsh.option.setNumber("Mesh.MeshSizeMax", size if same_faces else finer * size)
    gmsh.model.mesh.removeSizeCallback()
    if local is not None or (same_faces and finer != 1):

        def largest(dim: int, _tag: int, x: float, y: float, z: float, lc: float) -> float:
            here = size if local is None else local(x, y, z)
            return min(lc, here if same_faces and dim < 3 else finer * here)

        gmsh.model.mesh.setSizeCallback(largest)
    gmsh.option.setNumber("Mesh.OptimizeThreshold", _SLIVER)
    gmsh.model.mesh.generate(3)
    # Generation leaves slivers in fine meshes.
    gmsh.option.setNumber("Mesh.OptimizeThreshold", _POOR)
    gmsh.model.mesh.optimize("Relocate3D")
    gmsh.model.mesh.optimize("")
    if split:
        gmsh.model.mesh.optimize("Netgen")
    if level(gmsh):
        return 0.0
    _, corners = gmsh.model.mesh.getElementsByType(_TETRAHEDRON)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    points = drawn_out(np.asarray(coordinates).reshape(-1, 3)[order], stretch)
    cells = np.searchsorted(tags[order], corners).reshape(-1, 4)
    return float(condition(points, cells).min())
