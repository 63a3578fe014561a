"""Scenes as arrays of pixels: one picture, or many of a scene whose points move.

Text, legends and colour bars are added by matplotlib around the pictures, so that every figure has
the same letters and nothing overlaps.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vanelock.common.arrays import Floats
from vanelock.render import style
from vanelock.render.scenes import offscreen
from vanelock.render.scenes.scene import Camera, DrawnScene, Marks, SceneBody, SceneLines

Pixels = NDArray[np.uint8]

# Positions in the camera's own frame (right, up, towards the viewer) and strengths.
_LIGHTS: Final = (((0.0, 0.0, 1.0), 0.5), ((-0.7, 0.9, 0.8), 0.5))
# Drawn that many times finer in each direction and averaged. VTK's own samples of a pixel smooth
# nothing when software draws off-screen, and take two thirds of the time, so there are none.
_FINER: Final = 2
_LOOK: Final = {"ambient": 0.45, "diffuse": 0.65, "specular": 0.0, "smooth_shading": True}


@dataclass(frozen=True)
class _Window:
    """An open window: plotter, actors of the scene, and a fine pixel towards the viewer, m."""

    plotter: Any
    bodies: list[Any]
    lines: list[Any]
    nearer: Floats

    def move(self, scene: DrawnScene) -> None:
        """Show other points and colours; triangles, edges and the camera stay."""
        for actor, body in zip(self.bodies, scene.bodies, strict=True):
            actor.mapper.dataset = _surface(body)
        for actor, lines in zip(self.lines, _drawn(scene.lines), strict=True):
            actor.mapper.dataset.points = lines.points + 2 * self.nearer

    def picture(self) -> Pixels:
        """(height, width, 3) bytes."""
        return _coarser(self.shot())

    def shot(self) -> Pixels:
        """The fine pixels."""
        self.plotter.render()  # a second screenshot alone would return the first
        shot = self.plotter.screenshot(return_img=True)
        return np.asarray(shot, np.uint8)[:, :, :3]


@contextmanager
def window(scene: DrawnScene, size: tuple[int, int]) -> Iterator[_Window]:
    """Open a window of that size in pixels on a scene without marks, on white."""
    pv = offscreen.pyvista()
    fine = [_FINER * length for length in size]
    with offscreen.selected():
        plotter = pv.Plotter(off_screen=True, window_size=fine, lighting="none")
        try:
            plotter.render_window.SetMultiSamples(0)
            plotter.set_background("white")
            for position, strength in _LIGHTS:
                lamp = pv.Light(position=position, light_type="camera light", intensity=strength)
                plotter.add_light(lamp)
            frame, pixel = _aim(plotter, scene, fine)
            nearer = -pixel * frame[2]  # moves nothing in a parallel view
            yield _Window(
                plotter,
                [_add_body(plotter, body) for body in scene.bodies],
                [_add_lines(plotter, lines, 2 * nearer) for lines in _drawn(scene.lines)],
                nearer,
            )
        finally:
            plotter.close()


def snapshot(scene: DrawnScene, size: tuple[int, int]) -> Pixels:
    """Draw on white and return (height, width, 3) bytes."""
    with window(scene, size) as opened:
        for marks in scene.marks:
            opened.plotter.add_points(
                marks.points + _FINER * marks.size / 2 * opened.nearer,
                color=marks.colour,
                point_size=_FINER * marks.size,
                render_points_as_spheres=True,
                ambient=0.55,
                diffuse=0.55,
                specular=0.0,
                reset_camera=False,
                render=False,
            )
        picture = opened.shot()
        if scene.marks:
            for actor in (*opened.bodies, *opened.lines):
                actor.SetVisibility(False)
            picture = _shine_through(picture, opened.shot())
    return _coarser(picture)


def image(figure: Figure, scene: DrawnScene, *box: float) -> None:
    """A scene in a figure, at left, bottom, width and height in inches."""
    axes, size = style.image_axes(figure, *box)
    style.show(axes, snapshot(scene, size))


def panel(figure: Figure, scene: DrawnScene, left: float, width: float, heading: str) -> None:
    """A scene 5.3 inches high, under its heading."""
    image(figure, scene, left, 0.4, width, 5.25)
    style.heading(figure, left + 0.05, 5.72, heading)


def _coarser(picture: Pixels) -> Pixels:
    """Mean of each square of fine pixels, which smooths all edges."""
    corners = [picture[i::_FINER, j::_FINER] for i in range(_FINER) for j in range(_FINER)]
    total = np.full(corners[0].shape, len(corners) // 2, np.uint16)  # so that halves go up
    for corner in corners:
        total += corner
    smooth: Pixels = (total // len(corners)).astype(np.uint8)
    return smooth


def _shine_through(picture: Pixels, marks: Pixels) -> Pixels:
    """Mix in the marks drawn alone: those already visible stay as they are."""
    there = np.any(marks < 255, axis=2)
    mixed = picture.copy()
    both = 0.55 * picture[there] + 0.45 * marks[there]
    mixed[there] = both.round().astype(np.uint8)
    return mixed


def _drawn(lines: Sequence[SceneLines]) -> list[SceneLines]:
    return [each for each in lines if len(each.edges)]


def _surface(body: SceneBody) -> Any:
    """The body's triangles for VTK, with the normals that smooth shading takes."""
    mesh = offscreen.pyvista().PolyData.from_regular_faces(body.points, body.triangles)
    mesh = mesh.compute_normals(
        cell_normals=False,
        split_vertices=False,
        consistent_normals=False,
        non_manifold_traversal=False,
    )
    if not isinstance(body.colour, str):
        mesh.point_data["colour"] = np.round(255 * body.colour).astype(np.uint8)
        mesh.set_active_scalars("colour")
    return mesh


def _add_body(plotter: Any, body: SceneBody) -> Any:
    look: dict[str, Any] = {**_LOOK, "opacity": body.opacity, "render": False}
    if isinstance(body.colour, str):
        look["color"] = body.colour
    else:
        look |= {"scalars": "colour", "rgb": True}
    if body.opacity == 1:
        look["culling"] = "back"
    return plotter.add_mesh(_surface(body), reset_camera=False, **look)


def _add_lines(plotter: Any, lines: SceneLines, shift: Floats) -> Any:
    """Edges, a little nearer to the camera so that the faces they border do not hide them."""
    mesh = offscreen.pyvista().PolyData(lines.points + shift)
    mesh.verts = np.empty(0, int)
    count = np.full((len(lines.edges), 1), 2)
    mesh.lines = np.hstack([count, lines.edges]).ravel()
    return plotter.add_mesh(
        mesh,
        color=lines.colour,
        line_width=_FINER * lines.width,
        opacity=lines.opacity,
        lighting=False,
        reset_camera=False,
        render=False,
    )


@dataclass(frozen=True)
class _CameraView:
    """A parallel view: side, up and forward direction (rows), middle and half height of it, m."""

    frame: Floats
    centre: Floats
    half_height: float

    def pixels(self, points: Floats, size: tuple[int, int]) -> Floats:
        """(m, 2) where points lie in a picture of that size: to the right, and downwards."""
        across, up = ((np.asarray(points) - self.centre) @ self.frame[:2].T).T
        fine = size[1] / 2 / self.half_height
        return np.column_stack([size[0] / 2 + fine * across, size[1] / 2 - fine * up])


def aimed(camera: Camera, fit: Floats, size: Sequence[int]) -> _CameraView:
    """A camera's view in which points (m, 3) fill a picture of that size."""
    forward = np.asarray(camera.direction, float)
    forward = forward / np.linalg.norm(forward)
    side = np.cross(forward, np.asarray(camera.up, float))
    side = side / np.linalg.norm(side)
    frame = np.vstack([side, np.cross(side, forward), forward])
    seen = fit @ frame.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    half = (high - low) / 2 * camera.margin
    return _CameraView(frame, (low + high) / 2 @ frame, max(half[1], half[0] * size[1] / size[0]))


def _aim(plotter: Any, scene: DrawnScene, size: Sequence[int]) -> tuple[Floats, float]:
    """Point the camera and fit what it shall show into the picture.

    Returns the view's side, up and forward directions (rows), and the length of a pixel in m.
    """
    items: list[SceneBody | SceneLines | Marks] = [*scene.bodies, *scene.lines, *scene.marks]
    drawn = np.concatenate([item.points for item in items])
    view = aimed(scene.camera, drawn if scene.camera.fit is None else scene.camera.fit, size)
    reach = np.linalg.norm(np.ptp(drawn, axis=0)) + np.linalg.norm(view.centre - drawn.mean(axis=0))
    camera = plotter.camera
    camera.parallel_projection = True
    camera.position = tuple(view.centre - 2 * reach * view.frame[2])
    camera.focal_point = tuple(view.centre)
    camera.up = tuple(view.frame[1])
    camera.parallel_scale = view.half_height
    camera.clipping_range = (0.01 * reach, 4 * reach)
    return view.frame, 2 * view.half_height / size[1]
