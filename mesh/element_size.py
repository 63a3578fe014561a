"""Element sizes by name, those of regions, and elements longer around the ring than across it.

A vane is too stiff most of all where its hooks' legs and feet meet the outer shroud: in the mode of
interest an element there saves several times what one elsewhere does
(docs/benchmarks/mesh_error.md), and is smaller. Where an aerofoil's thin edge meets a shroud
without a fillet, elements grow with the distance from it.

Stresses of a ring's walls and of its re-entrant edges, which run around it, change quickly across
the section and slowly along the ring. A sector of a narrower pitch is meshed with elements as long
as wide, and then drawn out: every angle times the same number. Arcs stay arcs, plane cyclic faces
stay plane, and what lies evenly around the sector still does.
"""

import math
from collections.abc import Callable

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.mesh.geometry import aerofoil
from vanelock.mesh.geometry.dimensions import CasingDimensions, VaneDimensions

SIZES = {  # m
    "coarse": {"vane": 0.030, "casing": 0.0160},
    "medium": {"vane": 0.016, "casing": 0.0125},
    "paper": {"vane": 0.010, "casing": 0.0100},
    "fine": {"vane": 0.008, "casing": 0.0060},
}
SMALLEST, LARGEST = 0.001, 0.05
HOOKS, SHROUD = 0.5, 0.75
"""Largest elements of a vane's legs and feet, and of its outer shroud, over those elsewhere."""
SLENDER = 16
"""Longest elements along an aerofoil's rounded edges, in thicknesses of the edge: two elements lie
around it, and the condition number (SICN) of such slender ones is 0.85 over this."""
_FIRST, _GROWTH = 3, 0.5
"""Longest elements where such an edge meets a shroud, in its thicknesses, and what is added to that
over the distance from there. Longer ones are needles in the shroud."""

Local = Callable[[float, float, float], float]
"""Largest element edge at a place x, y, z, all in m."""


Size = str | float | tuple[float, float]


def element_size(size: Size, part: str) -> float:
    """Largest element edge of a part, m, from a name or a length."""
    if isinstance(size, str):
        if size not in SIZES:
            names = ", ".join(f'"{name}"' for name in SIZES)
            raise InputError(f'mesh.size = "{size}": allowed are {names} or a length in m')
        return SIZES[size][part]
    if isinstance(size, tuple):
        size = size[("vane", "casing").index(part)]
    if not SMALLEST <= size <= LARGEST:
        raise InputError(f"mesh.size = {size:g} m: must lie between {SMALLEST} and {LARGEST} m")
    return float(size)


def words_of(size: Size) -> str:
    """A size as people write it."""
    if isinstance(size, str):
        return size
    lengths = size if isinstance(size, tuple) else (size,)
    return " and ".join(f"{1e3 * each:.3g}" for each in lengths) + " mm"


def thin(vane: VaneDimensions, size: float) -> bool:
    """Whether aerofoils without fillets have edges that are too thin for elements of a size, m."""
    return not vane.root_fillet and SLENDER * vane.edge_thickness < size


def of_vane(vane: VaneDimensions, sectors: int, size: float) -> Local:
    """Largest element edges of a vane."""
    edge = 1e-6 * vane.outer_shroud_inner_radius
    least = _FIRST * vane.edge_thickness
    ends = aerofoil.noses(vane, sectors).tolist() if thin(vane, size) else None

    def at(x: float, y: float, z: float) -> float:
        radius = math.hypot(x, y)
        share = 1.0
        if radius > vane.outer_shroud_inner_radius - edge:
            share = SHROUD if radius < vane.outer_shroud_outer_radius - edge else HOOKS
        if ends is None:
            return share * size
        # Plain floats: the mesher asks a hundred thousand times.
        away = min((a - x) * (a - x) + (b - y) * (b - y) + (c - z) * (c - z) for a, b, c in ends)
        return min(share * size, least + _GROWTH * math.sqrt(away))

    return at


MOST_STRETCH = 8
"""Times longer, at most."""
_USUAL = 3
"""Half the error of elements as long as wide, at as many unknowns
(docs/benchmarks/mesh_error.md)."""


def drawn_out(points: Floats, stretch: float) -> Floats:
    """Points (n, 3) whose angles about z, from -π/stretch to π/stretch, grow by a factor."""
    x, y, z = points.T
    radius, angle = np.hypot(x, y), stretch * np.arctan2(y, x)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)


def checked_stretch(stretch: int | None, casing: CasingDimensions) -> int:
    """A stretch, `_USUAL` unless given where there are no bosses; round ones would become oval."""
    if stretch is None:
        return 1 if casing.bosses else _USUAL
    if stretch not in range(1, MOST_STRETCH + 1):
        raise InputError(
            f"mesh.stretch = {stretch:g}: must be a whole number from 1 to {MOST_STRETCH}"
        )
    if stretch > 1 and casing.bosses:
        raise InputError(
            f"mesh.stretch = {stretch}: only 1 is allowed where casing.bosses = {casing.bosses}"
        )
    return stretch
