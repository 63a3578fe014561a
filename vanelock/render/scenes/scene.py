"""What three-dimensional pictures show: bodies, lines and marked nodes under a camera.

Text, legends and colour bars are added by matplotlib around the picture, so that every figure has
the same letters and nothing overlaps.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap, to_rgb

from vanelock.common.arrays import Floats, Integers
from vanelock.common.process import latest
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import offscreen
from vanelock.render.scenes.annulus import sector_points
from vanelock.render.scenes.surface import Surface, surface


@dataclass(frozen=True)
class SceneBody:
    """Triangles with one colour, or with a colour (r, g, b in 0..1) at each point.

    A solid body is closed, or its inside cannot be seen: only the front of its triangles is drawn.

    Attributes
    ----------
    points : (m, 3) float
        m.
    triangles : (t, 3) int
        Into `points`, counter-clockwise seen from outside; points shared by two triangles are
        shaded smoothly across them.
    colour : str or (m, 3) float
        A colour's name, or red, green and blue at each point.
    opacity : float
        1: solid.
    """

    points: Floats
    triangles: Integers
    colour: str | Floats
    opacity: float = 1.0


@dataclass(frozen=True)
class SceneLines:
    """Straight edges (k, 2) between points (m, 3), with a width in pixels."""

    points: Floats
    edges: Integers
    colour: str = style.BLACK
    width: float = 1.0
    opacity: float = 1.0


@dataclass(frozen=True)
class Marks:
    """Points (m, 3) drawn as balls of a diameter in pixels; faintly where something hides them."""

    points: Floats
    colour: str
    size: float = 12.0


@dataclass(frozen=True)
class Camera:
    """Parallel view along `direction` (from the camera on), `up` upwards.

    What `fit` holds fills the picture; None: everything drawn.
    """

    direction: tuple[float, float, float] | Floats
    up: tuple[float, float, float] | Floats
    fit: Floats | None = None
    margin: float = 1.03


@dataclass(frozen=True)
class DrawnScene:
    """What is drawn, and from where."""

    camera: Camera
    bodies: Sequence[SceneBody]
    lines: Sequence[SceneLines] = ()
    marks: Sequence[Marks] = ()


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


def smooth_surface(points: Floats, skin: Surface) -> tuple[Integers, Integers]:
    """Points doubled along sharp edges, so that shading is smooth between them and crisp there."""
    pv = offscreen.pyvista()
    mesh = pv.PolyData.from_regular_faces(points, skin.triangles)
    mesh.point_data["place"] = np.arange(len(points))
    split = mesh.compute_normals(
        cell_normals=False,
        split_vertices=True,
        feature_angle=35.0,
        consistent_normals=False,
        non_manifold_traversal=False,
    )
    place = np.asarray(split.point_data["place"])
    return place, np.asarray(split.regular_faces, np.int64)


Skin: TypeAlias = tuple[Surface, Integers, Integers]
_skins: dict[tuple[int, bool], tuple[Part, Skin]] = {}
"""Of parts known again by being the same object, which is held so that its id stays its own."""


def smooth_skin(part: Part, corners_only: bool = False) -> Skin:
    """A part's skin and what `smooth_surface` makes of it, found once for several pictures."""

    def made() -> tuple[Part, Skin]:
        skin = surface(part, corners_only)
        return part, (skin, *smooth_surface(part.points[skin.nodes], skin))

    return latest(_skins, (id(part), corners_only), made, 8)[1]


def colours(values: Floats, colour_map: Colormap, low: float, high: float) -> Floats:
    """(m, 3) colours of values; light grey where a value is not a number."""
    norm = mpl.colors.Normalize(low, high, clip=True)
    shown = colour_map(norm(np.nan_to_num(values)))[:, :3]
    shown[np.isnan(values)] = to_rgb(style.LIGHT)
    return np.asarray(shown, float)


def repeat(faces: Integers, points: int, copies: int) -> Integers:
    """Triangles or edges of `copies` bodies whose points follow each other."""
    steps = points * np.arange(copies)[:, None, None]
    return (faces[None] + steps).reshape(-1, faces.shape[1])


def ring(points: Floats, sectors: int) -> Floats:
    """(N·m, 3) points of all sectors, sector after sector."""
    return np.concatenate([sector_points(points, j, sectors) for j in range(sectors)])
