"""Element sizes by name, and those of a vane's regions.

A vane's stiffness is lost most of all where its hooks' legs and feet meet the outer shroud: in the
mode of interest an element there saves several times what one elsewhere does
(docs/benchmarks/mesh_error.md), and is smaller.
"""

from collections.abc import Callable

from vanelock.common.errors import InputError
from vanelock.mesh.geometry.dimensions import VaneDimensions

SIZES = {  # m
    "coarse": {"vane": 0.030, "casing": 0.0160},
    "medium": {"vane": 0.016, "casing": 0.0125},
    "paper": {"vane": 0.010, "casing": 0.0100},
    "fine": {"vane": 0.008, "casing": 0.0060},
}
SMALLEST, LARGEST = 0.001, 0.05
HOOKS, SHROUD = 0.5, 0.75
"""Largest elements of a vane's legs and feet, and of its outer shroud, over those elsewhere."""


def element_size(size: str | float, part: str) -> float:
    """Largest element edge of a part, m, from a name or a length.

    Parameters
    ----------
    size : {"coarse", "medium", "paper", "fine"} or float
        A name, or a length in m between 1 and 50 mm.
    part : {"vane", "casing"}
        A named size may differ from part to part.

    Raises
    ------
    InputError
        For an unknown name or a length out of range.
    """
    if isinstance(size, str):
        if size not in SIZES:
            names = ", ".join(f'"{name}"' for name in SIZES)
            raise InputError(f'mesh.size = "{size}": allowed are {names} or a length in m')
        return SIZES[size][part]
    if not SMALLEST <= size <= LARGEST:
        raise InputError(f"mesh.size = {size:g} m: must lie between {SMALLEST} and {LARGEST} m")
    return float(size)


def of_vane(vane: VaneDimensions, size: float) -> Callable[[float], float]:
    """Largest element edge of a vane at a radius, both in m.

    Parameters
    ----------
    vane : VaneDimensions
    size : float
        Of the vane, m.
    """
    edge = 1e-6 * vane.outer_shroud_inner_radius

    def at(radius: float) -> float:
        if radius < vane.outer_shroud_inner_radius - edge:
            return size
        return (SHROUD if radius < vane.outer_shroud_outer_radius - edge else HOOKS) * size

    return at
