"""Mesh with linear tetrahedra, again with slightly smaller ones where a sliver remains.

Whether the mesher leaves a sliver somewhere is chance: three meshes of a hundred have one, and one
of them cannot be curved. A size a few per cent smaller leads to another mesh.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from vanelock.mesh.generate.flat_elements import level

FINER = (1.0, 0.95, 0.9, 0.85)
"""Sizes to try, relative to the one asked for."""
ENOUGH = 0.02
"""Smallest condition number (SICN) at which no other size is tried."""
# Condition numbers below which the mesher changes an element: at first slivers only, since it
# tries in vain, for minutes, to improve what is flat because the wall is thin.
_SLIVER, _POOR = 0.02, 0.3
_TETRAHEDRON = 4  # gmsh's number of the linear element type


def tetrahedra(gmsh: Any, size: float, local: Callable[[float], float] | None = None) -> None:
    """Mesh the current model with linear tetrahedra no larger than `size`, m.

    Parameters
    ----------
    gmsh : module
    size : float
        m.
    local : callable, optional
        Largest edge at a radius, m; not above `size`.
    """
    reached = {}
    for finer in FINER:
        try:
            reached[finer] = _attempt(gmsh, size, local, finer)
        except Exception:  # all that gmsh raises
            reached[finer] = -1.0
        if reached[finer] > ENOUGH:
            return
    best = max(FINER, key=lambda finer: reached[finer])
    if best != FINER[-1] or reached[best] < 0:
        _attempt(gmsh, size, local, best)


def _attempt(gmsh: Any, size: float, local: Callable[[float], float] | None, finer: float) -> float:
    """Mesh anew; the smallest condition number, or 0 if an element lies flat on a face."""
    gmsh.model.mesh.clear()
    gmsh.option.setNumber("Mesh.MeshSizeMax", finer * size)
    if local is not None:
        gmsh.model.mesh.setSizeCallback(
            lambda _dim, _tag, x, y, _z, lc: min(lc, finer * local(math.hypot(x, y)))
        )
    gmsh.option.setNumber("Mesh.OptimizeThreshold", _SLIVER)
    gmsh.model.mesh.generate(3)
    # Generation leaves slivers in fine meshes.
    gmsh.option.setNumber("Mesh.OptimizeThreshold", _POOR)
    gmsh.model.mesh.optimize("Relocate3D")
    gmsh.model.mesh.optimize("")
    if level(gmsh):
        return 0.0
    tags, _ = gmsh.model.mesh.getElementsByType(_TETRAHEDRON)
    return float(np.min(gmsh.model.mesh.getElementQualities(tags, "minSICN")))
