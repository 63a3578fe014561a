"""Places on an aerofoil's surface, as an engineer names them for a strain gauge."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh.geometry.aerofoil import angles, on_side, spanwise
from vanelock.mesh.geometry.dimensions import VaneDimensions

STEP = 1e-5
"""Of the station, for the direction along the profile."""
Side = Literal["suction", "pressure"]


@dataclass(frozen=True)
class AerofoilPoint:
    """A place on an aerofoil and a direction in its surface.

    Attributes
    ----------
    position, direction, normal : (3,) float
        Where, m; the unit direction; the unit outward normal.
    """

    position: NDArray[np.float64]
    direction: NDArray[np.float64]
    normal: NDArray[np.float64]


def on_aerofoil(
    vane: VaneDimensions,
    sectors: int,
    aerofoil: int,
    span: float,
    chord: float,
    side: Side = "suction",
    direction: float | Literal["span", "chord"] = "span",
) -> AerofoilPoint:
    """A place on the surface of an aerofoil of the vane segment.

    Parameters
    ----------
    vane : VaneDimensions
    sectors : int
        Segments in the ring.
    aerofoil : int
        1, 2, ... by ascending angle about the engine axis.
    span : float
        From 0 at the inner shroud to 1 at the outer shroud.
    chord : float
        From 0 where the rounded leading edge ends to 1 where the trailing one begins.
    side : "suction" or "pressure"
        The convex or the concave side.
    direction : "span", "chord" or float
        Along the straight line that rules the surface there, which is radial without lean and
        twist; along the profile towards the trailing edge; or the angle from the former towards
        the latter, degrees.

    Raises
    ------
    InputError
        Naming what is out of range.
    """
    if not 1 <= aerofoil <= vane.aerofoils:
        raise InputError(f"aerofoil = {aerofoil}: allowed are 1 to {vane.aerofoils}")
    for name, value in (("span", span), ("chord", chord)):
        if not 0 <= value <= 1:
            raise InputError(f"{name} = {value:g}: allowed are 0 to 1")
    degrees = {"span": 0.0, "chord": 90.0}[direction] if isinstance(direction, str) else direction

    turn = rotation(angles(vane, sectors)[aerofoil - 1])
    side_number, station = get_args(Side).index(side), 2 * chord - 1

    # Straight lines rule the surface; the shrouds that end them are cylinders.
    inner, outer = spanwise(vane, side_number, station)
    along_span = outer - inner
    position = inner + span * along_span
    along_span /= np.linalg.norm(along_span)
    ahead, behind = (
        on_side(vane, side_number, station + step, position[0]) for step in (STEP, -STEP)
    )
    tangent = ahead - behind
    tangent /= np.linalg.norm(tangent)
    normal = np.cross(along_span, tangent) * (-1 if side == "suction" else 1)
    normal /= np.linalg.norm(normal)
    position[2] += vane.hook.mid_plane
    angle = np.radians(degrees)
    if direction == "chord":
        chosen = tangent
    else:
        aside = tangent - (tangent @ along_span) * along_span
        chosen = np.cos(angle) * along_span + np.sin(angle) * aside / np.linalg.norm(aside)
    return AerofoilPoint(turn @ position, turn @ chosen, turn @ normal)
