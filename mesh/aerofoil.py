"""The profile of an aerofoil: a parabolic camber line under a parabolic thickness."""

import numpy as np
from numpy.typing import NDArray

from vanelock.cyclic import rotation
from vanelock.mesh.dimensions import VaneDimensions

STATIONS = np.linspace(-1.0, 1.0, 5)  # from the leading to the trailing edge, in half chords


def profile(vane: VaneDimensions) -> NDArray[np.float64]:
    """Points of the convex and of the concave side, which splines join.

    With s the station in half chords, the camber line stands camber·chord·(1/2 - s²) off the
    chord's line, which centres it, and the thickness is edge + (thickness - edge)·(1 - s²).

    Returns
    -------
    (2, 5, 2) float
        Circumferential and axial position, m, relative to the aerofoil's radial axis.
    """
    return outline(vane, STATIONS)


def outline(vane: VaneDimensions, station: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convex and concave side at stations from -1, leading edge, to 1: (2, n, 2), see `profile`."""
    along = 0.5 * vane.chord * station
    camber = vane.camber * vane.chord * (0.5 - station**2)
    half = 0.5 * (vane.edge_thickness + (vane.thickness - vane.edge_thickness) * (1 - station**2))
    stagger = np.radians(vane.stagger)
    chord = np.array([np.sin(stagger), np.cos(stagger)])
    normal = np.array([np.cos(stagger), -np.sin(stagger)])
    sides = [
        np.outer(along, chord) + np.outer(camber + side * half, normal) for side in (1.0, -1.0)
    ]
    return np.array(sides)


def angles(vane: VaneDimensions, sectors: int) -> NDArray[np.float64]:
    """Angular positions of the aerofoils' radial axes, rad, evenly spaced about zero."""
    pitch = 2 * np.pi / sectors
    return pitch * ((np.arange(vane.aerofoils) + 0.5) / vane.aerofoils - 0.5)


def ends(vane: VaneDimensions) -> tuple[float, float]:
    """Start and end of an aerofoil's prism along its radial axis, m, both inside the shrouds."""
    start = 0.5 * (vane.inner_shroud_inner_radius + vane.inner_shroud_outer_radius)
    return start, 0.5 * (vane.outer_shroud_inner_radius + vane.outer_shroud_outer_radius)


def accessory_points(vane: VaneDimensions, sectors: int) -> NDArray[np.float64]:
    """Output nodes on the convex side at mid-chord of the middle aerofoil: (3, 3) m.

    They lie at 25, 50 and 75 % of the span, counted from the inner shroud.
    """
    across, axial = profile(vane)[0, len(STATIONS) // 2]
    inner, outer = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    span = inner + np.array([0.25, 0.5, 0.75]) * (outer - inner)
    points = np.stack([span, np.full(3, across), np.full(3, vane.hook.mid_plane + axial)], axis=-1)
    axis = angles(vane, sectors)[(vane.aerofoils - 1) // 2]
    return np.asarray(points @ rotation(axis).T)
