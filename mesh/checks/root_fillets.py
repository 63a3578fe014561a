"""Refuse fillets of aerofoils that reach an edge of their shrouds or a quarter of the span.

The outermost of evenly spaced aerofoils stand half a spacing from the segment's ends: fillets that
keep off these do not meet one another.
How far a fillet reaches depends on the angle at which the aerofoil stands on the shroud, so that
the largest that fits is searched for.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh.geometry import aerofoil, contact_places, root_fillet
from vanelock.mesh.geometry.dimensions import CLEARANCE, VaneDimensions

SHORTEST = 0.25
"""Of its length, what is left of a piece of the hollow side's curve where the fillet ends."""
_STEP = 1e-5  # m; the largest radius that fits is given in multiples of it

Room = tuple[str, float]
"""Where a fillet lies, and the distance that it leaves there, m."""


USUAL, LEAST = 3e-3, 1.5e-3
"""Radius unless one is given, and the smallest that is then chosen, which coarse meshes follow, m.
"""


@lru_cache(maxsize=256)
def filleted(vane: VaneDimensions, sectors: int) -> VaneDimensions:
    """The vane with the radius of its aerofoils' fillets, chosen where none is given."""
    if vane.root_fillet is not None:
        return vane
    usual = not _too_narrow(vane, sectors, USUAL)
    radius = USUAL if usual else _largest(vane, sectors, USUAL)[0]
    return vane.model_copy(update={"root_fillet": radius if radius >= LEAST else 0.0})


def check_root_fillet(vane: VaneDimensions, sectors: int) -> None:
    """Refuse a fillet of the aerofoils that does not fit."""
    if not vane.root_fillet or not _too_narrow(vane, sectors, vane.root_fillet):
        return
    largest, where = _largest(vane, sectors, vane.root_fillet)
    least = f"at most {largest:g} m" if largest >= CLEARANCE else "none"
    raise InputError(f"vane.root_fillet = {vane.root_fillet:g} m: {where} {least} fits")


def _largest(vane: VaneDimensions, sectors: int, high: float) -> tuple[float, str]:
    """The largest radius below one that does not fit, and where that meets something."""
    low, where = 0.0, ""
    while high - low > 0.1 * _STEP:
        middle = 0.5 * (low + high)
        if found := _too_narrow(vane, sectors, middle):
            high, where = middle, found
        else:
            low = middle
    return float(_STEP * np.floor(low / _STEP)), where


def _too_narrow(vane: VaneDimensions, sectors: int, radius: float) -> str:
    """Where a fillet does not fit; "" if it does."""
    rooms = _rooms(vane, sectors, radius)
    return next((where for where, room in rooms if room < CLEARANCE), "")


def _rooms(vane: VaneDimensions, sectors: int, radius: float) -> Iterator[Room]:
    left = contact_places.interlock_frame(vane, sectors)
    planes = (left[0], contact_places.opposite(left, sectors)[0])
    angles = aerofoil.angles(vane, sectors)
    for outer, name in ((False, "inner_shroud"), (True, "outer_shroud")):
        strips = root_fillet.strips(vane, outer, radius)
        level = vane.outer_shroud_inner_radius if outer else vane.inner_shroud_outer_radius
        foot = np.concatenate([strip.foot[:-1] for strip in strips])
        front = vane.hook.mid_plane - float(np.abs(foot[:, 2]).max())
        yield f"behind vane.{name}_front", front - float(getattr(vane, f"{name}_front"))
        if outer:
            half = vane.outer_shroud_extent * np.pi / sectors
            ends = [_unrolled(foot @ rotation(a).T, level)[:, 0] for a in angles[[0, -1]]]
            room = half * level - max(float(np.abs(end).max()) for end in ends)
            yield "beside the ends of the outer shroud (vane.outer_shroud_extent)", room
        else:
            start = foot * [0.0, 1.0, 1.0] + [aerofoil.ends(vane)[0], 0.0, 0.0]
            room = min(
                float(-(points @ rotation(a).T @ plane).max())
                for points in (foot, start)
                for a, plane in zip(angles[[0, -1]], planes, strict=True)
            )
            yield "beside the interlock faces (vane.interlock_slant)", room
        for k, strip in enumerate(strips):
            quarters = root_fillet.levels(vane, k)
            span = np.linalg.norm(quarters[1] - quarters[0], axis=1)
            root = quarters[-1] if outer else quarters[0]
            height = np.linalg.norm(strip.top - root, axis=1)
            yield "within a quarter of the span between the shrouds", float((span - height).min())
        hollow = strips[2]
        at_the_foot, before = np.diff(hollow.foot, axis=0), np.diff(hollow.corner, axis=0)
        left_over = np.sum(at_the_foot * before, axis=1) / np.sum(before**2, axis=1)
        room = np.inf if left_over.min() > SHORTEST else 0.0
        yield "on the hollow side (vane.camber)", room


def _unrolled(points: NDArray[np.float64], level: float) -> NDArray[np.float64]:
    """Points (k, 2) of a cylinder: along its circumference, and axially."""
    return np.column_stack([level * np.arctan2(points[:, 1], points[:, 0]), points[:, 2]])
