"""Elements that are longer around the ring than across it.

Stresses of a ring's walls and of its re-entrant edges, which run around it, change quickly across
the section and slowly along the ring. A sector of a narrower pitch is meshed with elements as long
as wide, and then drawn out: every angle times the same number. Arcs stay arcs, plane cyclic faces
stay plane, and what lies evenly around the sector still does.
"""

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.mesh.geometry.dimensions import CasingDimensions

MOST = 8
"""Times longer, at most."""
USUAL = 3
"""Half the error of elements as long as wide, at as many unknowns
(docs/benchmarks/mesh_error.md)."""


def drawn_out(points: NDArray[np.float64], stretch: float) -> NDArray[np.float64]:
    """Points (n, 3) whose angles about z, from -π/stretch to π/stretch, grow by a factor."""
    x, y, z = points.T
    radius, angle = np.hypot(x, y), stretch * np.arctan2(y, x)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)


def checked_stretch(stretch: int | None, casing: CasingDimensions) -> int:
    """A stretch, `USUAL` unless given where there are no bosses; round ones would become oval."""
    if stretch is None:
        return 1 if casing.bosses else USUAL
    if stretch not in range(1, MOST + 1):
        raise InputError(f"mesh.stretch = {stretch:g}: must be a whole number from 1 to {MOST}")
    if stretch > 1 and casing.bosses:
        raise InputError(
            f"mesh.stretch = {stretch}: only 1 is allowed where casing.bosses = {casing.bosses}"
        )
    return stretch
