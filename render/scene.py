"""Three-dimensional pictures as arrays of pixels: bodies, lines and marked nodes under a camera.

Text, legends and colour bars are added by matplotlib around the picture, so that every figure has
the same letters and nothing overlaps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap, to_rgb
from numpy.typing import NDArray

from vanelock.render import annulus, offscreen, style
from vanelock.render.surface import Surface

Real = NDArray[np.float64]
Pixels = NDArray[np.uint8]

# Positions in the camera's own frame (right, up, towards the viewer) and strengths.
_LIGHTS: Final = (((0.0, 0.0, 1.0), 0.5), ((-0.7, 0.9, 0.8), 0.5))
# Drawn that many times finer in each direction and averaged: software drawing has no other
# anti-aliasing off-screen.
_FINER: Final = 2


@dataclass(frozen=True)
class Body:
    """Triangles with one colour, or with a colour (r, g, b in 0..1) at each point.

    Attributes
    ----------
    points : (m, 3) float
        m.
    triangles : (t, 3) int
        Into `points`; points shared by two triangles are shaded smoothly across them.
    colour : str or (m, 3) float
        A colour's name, or red, green and blue at each point.
    opacity : float
        1: solid.
    """

    points: Real
    triangles: NDArray[np.int64]
    colour: str | Real
    opacity: float = 1.0


@dataclass(frozen=True)
class Lines:
    """Straight edges (k, 2) between points (m, 3), with a width in pixels."""

    points: Real
    edges: NDArray[np.int64]
    colour: str = style.BLACK
    width: float = 1.0
    opacity: float = 1.0


@dataclass(frozen=True)
class Marks:
    """Points (m, 3) drawn as balls of a diameter in pixels; faintly where something hides them."""

    points: Real
    colour: str
    size: float = 12.0


@dataclass(frozen=True)
class Camera:
    """Parallel view along `direction` (from the camera on), `up` upwards.

    What `fit` holds fills the picture; None: everything drawn.
    """

    direction: tuple[float, float, float] | Real
    up: tuple[float, float, float] | Real
    fit: Real | None = None
    margin: float = 1.03


@dataclass(frozen=True)
class Scene:
    """What is drawn, and from where."""

    camera: Camera
    bodies: Sequence[Body] = ()
    lines: Sequence[Lines] = ()
    marks: Sequence[Marks] = field(default=())


def smooth_surface(points: Real, surface: Surface) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Points doubled along sharp edges, so that shading is smooth between them and crisp there.

    Returns
    -------
    (p,) int into `surface.nodes`, (t, 3) int into those p points.
    """
    pv = offscreen.pyvista()
    mesh = pv.PolyData.from_regular_faces(points, surface.triangles)
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


def colours(values: Real, colour_map: Colormap, low: float, high: float) -> Real:
    """(m, 3) colours of values; light grey where a value is not a number."""
    norm = mpl.colors.Normalize(low, high, clip=True)
    shown = colour_map(norm(np.nan_to_num(values)))[:, :3]
    shown[np.isnan(values)] = to_rgb(style.LIGHT)
    return np.asarray(shown, float)


def repeat(faces: NDArray[np.int64], points: int, copies: int) -> NDArray[np.int64]:
    """Triangles or edges of `copies` bodies whose points follow each other."""
    steps = points * np.arange(copies)[:, None, None]
    return (faces[None] + steps).reshape(-1, faces.shape[1])


def ring(points: Real, sectors: int) -> Real:
    """(N·m, 3) points of all sectors, sector after sector."""
    return np.concatenate([annulus.sector_points(points, j, sectors) for j in range(sectors)])


def snapshot(scene: Scene, size: tuple[int, int]) -> Pixels:
    """Draw on white and return (height, width, 3) bytes.

    Raises
    ------
    InputError
        If this machine cannot draw.
    """
    pv = offscreen.pyvista()
    fine = [_FINER * length for length in size]
    with offscreen.selected():
        plotter = pv.Plotter(off_screen=True, window_size=fine, lighting="none")
        try:
            plotter.set_background("white")
            for position, strength in _LIGHTS:
                lamp = pv.Light(position=position, light_type="camera light", intensity=strength)
                plotter.add_light(lamp)
            frame, pixel = _aim(plotter, scene, fine)
            nearer = -pixel * frame[2]  # moves nothing in a parallel view
            solid = [_add_body(pv, plotter, body) for body in scene.bodies]
            for lines in scene.lines:
                if len(lines.edges):
                    solid.append(_add_lines(pv, plotter, lines, 2 * nearer))
            for marks in scene.marks:
                plotter.add_points(
                    marks.points + _FINER * marks.size / 2 * nearer,
                    color=marks.colour,
                    point_size=_FINER * marks.size,
                    render_points_as_spheres=True,
                    ambient=0.55,
                    diffuse=0.55,
                    specular=0.0,
                )
            picture = _shoot(plotter)
            if scene.marks:
                for actor in solid:
                    actor.SetVisibility(False)
                plotter.render()  # a second screenshot alone would return the first
                picture = _shine_through(picture, _shoot(plotter))
        finally:
            plotter.close()
    return _coarser(picture)


def _shoot(plotter: Any) -> Pixels:
    return np.asarray(plotter.screenshot(return_img=True), np.uint8)[:, :, :3].copy()


def _coarser(picture: Pixels) -> Pixels:
    """Mean of each square of fine pixels, which smooths all edges."""
    height, width = (length // _FINER for length in picture.shape[:2])
    squares = picture.reshape(height, _FINER, width, _FINER, 3)
    smooth: Pixels = squares.mean(axis=(1, 3)).round().astype(np.uint8)
    return smooth


def _shine_through(picture: Pixels, marks: Pixels, strength: float = 0.45) -> Pixels:
    """Mix in the marks drawn alone: those already visible stay as they are."""
    there = np.any(marks < 255, axis=2)
    mixed = picture.astype(float)
    mixed[there] = (1 - strength) * mixed[there] + strength * marks[there]
    return mixed.round().astype(np.uint8)


def _add_body(pv: Any, plotter: Any, body: Body) -> Any:
    mesh = pv.PolyData.from_regular_faces(body.points, body.triangles)
    mesh = mesh.compute_normals(
        cell_normals=False,
        split_vertices=False,
        consistent_normals=False,
        non_manifold_traversal=False,
    )
    look = {"ambient": 0.45, "diffuse": 0.65, "specular": 0.0, "smooth_shading": True}
    if isinstance(body.colour, str):
        return plotter.add_mesh(mesh, color=body.colour, opacity=body.opacity, **look)
    mesh.point_data["colour"] = np.round(255 * body.colour).astype(np.uint8)
    return plotter.add_mesh(mesh, scalars="colour", rgb=True, opacity=body.opacity, **look)


def _add_lines(pv: Any, plotter: Any, lines: Lines, shift: Real) -> Any:
    """Edges, a little nearer to the camera so that the faces they border do not hide them."""
    mesh = pv.PolyData(lines.points + shift)
    mesh.verts = np.empty(0, int)
    count = np.full((len(lines.edges), 1), 2)
    mesh.lines = np.hstack([count, lines.edges]).ravel()
    return plotter.add_mesh(
        mesh,
        color=lines.colour,
        line_width=_FINER * lines.width,
        opacity=lines.opacity,
        lighting=False,
    )


def _aim(plotter: Any, scene: Scene, size: Sequence[int]) -> tuple[Real, float]:
    """Point the camera and fit what it shall show into the picture.

    Returns the view's side, up and forward directions (rows), and the length of a pixel in m.
    """
    camera = scene.camera
    forward = np.asarray(camera.direction, float)
    forward = forward / np.linalg.norm(forward)
    side = np.cross(forward, np.asarray(camera.up, float))
    side = side / np.linalg.norm(side)
    up = np.cross(side, forward)
    items: list[Body | Lines | Marks] = [*scene.bodies, *scene.lines, *scene.marks]
    drawn = np.concatenate([item.points for item in items])
    fit = drawn if camera.fit is None else camera.fit
    low = np.array([(fit @ axis).min() for axis in (side, up, forward)])
    high = np.array([(fit @ axis).max() for axis in (side, up, forward)])
    middle = (low + high) / 2
    half = (high - low) / 2 * camera.margin
    frame = np.vstack([side, up, forward])
    centre = middle @ frame
    reach = np.linalg.norm(np.ptp(drawn, axis=0)) + np.linalg.norm(centre - drawn.mean(axis=0))
    view = plotter.camera
    view.parallel_projection = True
    view.position = tuple(centre - 2 * reach * forward)
    view.focal_point = tuple(centre)
    view.up = tuple(up)
    view.parallel_scale = max(half[1], half[0] * size[1] / size[0])
    view.clipping_range = (0.01 * reach, 4 * reach)
    return frame, 2 * view.parallel_scale / size[1]
