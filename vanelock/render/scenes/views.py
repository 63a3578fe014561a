"""From where a sector and a ring are looked at, in every picture alike."""

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.render.scenes.scene import Camera


def _directions(points: Floats) -> tuple[Floats, Floats, Floats]:
    """Radial, circumferential and axial direction at the middle of a sector's points."""
    middle = points.mean(axis=0)
    radius = np.hypot(middle[0], middle[1])
    radial = np.array([middle[0], middle[1], 0.0]) / radius if radius > 0 else np.eye(3)[1]
    axial = np.array([0.0, 0.0, 1.0])
    return radial, np.cross(axial, radial), axial


def sector_camera(points: Floats, fit: Floats | None = None) -> Camera:
    """View of one sector, its outer side up, from in front, a little below and to one side."""
    radial, around, axial = _directions(points)
    return Camera(0.72 * axial - 0.62 * around + 0.25 * radial, radial, fit)


def ring_camera(points: Floats, fit: Floats | None = None) -> Camera:
    """View of the ring from in front and above, the sector of these points at the top."""
    radial, around, axial = _directions(points)
    return Camera(0.87 * axial + 0.22 * around - 0.44 * radial, radial, fit)
