"""Geometry and phase of a ring of N equal sectors about the z axis.

Sector j+1 is sector j turned by 2π/N. A wave of nodal diameter k reaches it later by the phase
φ = 2π k/N: in each sector's own frame, x_{j+1} = x_j e^{-iφ}.
"""

import numpy as np

from vanelock.common.arrays import Floats

COMPONENTS = ("radial", "circumferential", "axial")
"""Cylindrical components, in the order of every output."""


def rotation(angle: float) -> Floats:
    """(3, 3) rotation by `angle`, rad, about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def cylindrical(points: Floats) -> Floats:
    """(k, 3, 3) turn from Cartesian components to cylindrical ones at each of k points."""
    return np.array([rotation(-angle) for angle in np.arctan2(points[:, 1], points[:, 0])])


def turn(sectors: int, steps: int = 1) -> Floats:
    """(3, 3) rotation from a sector to the one that many steps on."""
    return rotation(2 * np.pi * steps / sectors)


def folded(nodal_diameter: int, sectors: int) -> int:
    """The diameter from 0 to N/2 whose matrices, or their conjugates, serve k: k or N - k."""
    k = nodal_diameter % sectors
    return min(k, sectors - k)


def phase_factor(nodal_diameter: int, sectors: int) -> complex | float:
    """e^{-iφ} from a sector to the next, exactly real at the nodal diameters 0 and N/2."""
    k = nodal_diameter % sectors
    if k == 0:
        return 1.0
    return -1.0 if 2 * k == sectors else complex(np.exp(-2j * np.pi * k / sectors))
