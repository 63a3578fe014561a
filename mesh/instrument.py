"""Places on an aerofoil's surface, as an engineer names them for a strain gauge."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from vanelock.cyclic import rotation
from vanelock.errors import InputError
from vanelock.mesh.aerofoil import angles, outline
from vanelock.mesh.dimensions import VaneDimensions

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
        From 0 at the leading edge to 1 at the trailing edge.
    side : "suction" or "pressure"
        The convex or the concave side.
    direction : "span", "chord" or float
        Along the aerofoil's radial axis, along the profile towards the trailing edge, or the angle
        from the former towards the latter, degrees.

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
    if side not in get_args(Side):
        raise InputError(f"side = {side!r}: allowed are 'suction' and 'pressure'")
    if isinstance(direction, str) and direction not in ("span", "chord"):
        raise InputError(
            f"direction = {direction!r}: allowed are 'span', 'chord' and an angle in degrees"
        )
    degrees = {"span": 0.0, "chord": 90.0}[direction] if isinstance(direction, str) else direction

    step = 1e-4
    stations = 2 * chord - 1 + np.array([-step, 0.0, step])  # a parabola: exact differences
    before, (across, axial), after = outline(vane, stations)[get_args(Side).index(side)]
    tangent = (after - before) / np.linalg.norm(after - before)
    normal = np.array([tangent[1], -tangent[0]]) * (1 if side == "suction" else -1)
    # The shrouds are cylinders, the aerofoil a prism that stands off their axis by `across`.
    inner, outer = (
        np.sqrt(radius**2 - across**2)
        for radius in (vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius)
    )
    turn = rotation(angles(vane, sectors)[aerofoil - 1])
    angle = np.radians(degrees)
    return AerofoilPoint(
        turn @ [inner + span * (outer - inner), across, vane.hook.mid_plane + axial],
        turn @ [np.cos(angle), *(np.sin(angle) * tangent)],
        turn @ [0.0, *normal],
    )
