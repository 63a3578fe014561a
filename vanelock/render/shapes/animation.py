"""A mode, or the vibration at resonance, as it travels round the full ring in one period.

Frame k of K shows the phase angle α = 2πk/K of the excitation, at which sector j is displaced by

    Re Σ_h x_h e^{-i j φ_h} e^{ihα},      φ_h = 2π ND_h/N,

each harmonic h with its own nodal diameter, in cylindrical components. The last frame's successor
is the first, so that the animation has no seam.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from vanelock.common.arrays import Complex, Floats
from vanelock.common.cyclic import phase_factor
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import annulus, gif, offscreen, scene
from vanelock.render.scenes.surface import Surface, bent_edges
from vanelock.render.scenes.window import window
from vanelock.render.shapes.shapes import (
    DRAWN,
    DeformedSkin,
    all_sectors,
    mode_size,
    outer_radius,
    ring_and_wave,
    sentences,
    skins_of,
)

FRAMES: Final = 24
MILLISECONDS: Final = 80
TRIANGLES: Final = 1200
"""Of a part's sector: more are smaller than a pixel of the ring."""
_MARGIN: Final = 1.11  # of the picture around the ring at rest: room to move
_INK: Final = (0, 114, 178)  # the bar of time, style.BLUE


@dataclass(frozen=True)
class Wave:
    """One harmonic of a vibration.

    Attributes
    ----------
    harmonic : int
        h, 1 or above.
    nodal_diameter : int
        Of that harmonic.
    shapes : sequence of (n, 3) complex
        Cartesian displacement of each part on sector 0.
    """

    harmonic: int
    nodal_diameter: int
    shapes: Sequence[Complex]


@dataclass(frozen=True)
class _Moving:
    """A part's skin with its waves: harmonic, nodal diameter and shape (m, 3) at its nodes."""

    skin: DeformedSkin
    waves: tuple[tuple[int, int, Complex], ...]

    def displacement(self, sector: int, angle: float) -> Floats:
        """(m, 3) displacement on a sector at a phase angle, in the frame of sector 0."""
        sectors = self.skin.part.sectors
        total = np.zeros(self.skin.points.shape)
        for harmonic, nodal_diameter, shape in self.waves:
            lag = phase_factor(nodal_diameter * sector, sectors)
            total += annulus.at(lag * shape, harmonic * angle)
        return total


@dataclass(frozen=True)
class _ColourBar:
    """Colours of displacement: their label, and where they end in a unit, 1/m."""

    label: str
    unit: float
    top: float

    def colours(self, length: Floats) -> Floats:
        """(m, 3) of lengths in m."""
        return scene.colours(self.unit * length, style.AMPLITUDE_MAP, 0, self.top)


def mode_animation(
    path: style.PathLike,
    parts: Sequence[Part],
    shapes: Sequence[Complex],
    nodal_diameter: int,
    title: str,
    subtitle: str = "",
) -> Path:
    """Animate a mode on the full ring over one period, and return the path of the GIF.

    Drawn as large as in `mode_picture`, whose parameters these are; colours show the displacement
    at the instant over the largest one.
    """
    moving = _moving_parts(parts, [Wave(1, nodal_diameter, shapes)])
    largest, drawn = _largest(moving), mode_size(parts)
    stated = f"Largest displacement drawn as {1e3 * drawn:.3g} mm"
    bar = _ColourBar("displacement / largest displacement (–)", 1 / largest, 1.0)
    heading = ring_and_wave(parts, nodal_diameter)
    texts = title, sentences(subtitle, stated), heading
    return _animate(path, moving, drawn / largest, bar, texts)


def response_animation(
    path: style.PathLike,
    parts: Sequence[Part],
    waves: Sequence[Wave],
    title: str,
    subtitle: str = "",
) -> Path:
    """Animate a vibration on the full ring over one period, and return the path of the GIF.

    Drawn as many times larger as in `response_picture` of its first harmonic; colours show the
    displacement at the instant, µm.

    Parameters
    ----------
    path : path
        GIF file to write.
    parts : sequence of Part
        Usually all parts of a sector, of one ring.
    waves : sequence of Wave
        The harmonics, the first one first, m.
    title, subtitle : str
        Heading, and a line before the statement of the scale.

    Raises
    ------
    InputError
        If the shape is zero, or this machine cannot draw.
    """
    moving = _moving_parts(parts, waves)
    amplitude = max(float(annulus.peak(shape).max()) for shape in waves[0].shapes)
    scale = annulus.round_scale(amplitude, DRAWN * outer_radius(parts))
    stated = f"Deformation drawn {scale:,.10g} times as large"
    bar = _ColourBar("displacement at the instant (µm)", 1e6, 1e6 * _largest(moving))
    heading = ring_and_wave(parts, waves[0].nodal_diameter)
    texts = title, sentences(subtitle, stated), heading
    return _animate(path, moving, scale, bar, texts)


def _moving_parts(parts: Sequence[Part], waves: Sequence[Wave]) -> list[_Moving]:
    """Parts with their waves, on skins of few triangles."""
    found = []
    for i, skin in enumerate(skins_of(parts, waves[0].shapes, corners_only=True)):
        thin = _thinned(skin)
        of_skin = [np.asarray(wave.shapes[i])[thin.surface.nodes] for wave in waves]
        each = zip(waves, of_skin, strict=True)
        found.append(
            _Moving(thin, tuple((w.harmonic, w.nodal_diameter, shape) for w, shape in each))
        )
    return found


def _thinned(skin: DeformedSkin, triangles: int = TRIANGLES) -> DeformedSkin:
    """A skin of about so many of the triangles that a ring shows, between nodes that it has.

    The edges at which sectors meet stay; nodes that are not needed go.
    """
    whole = skin.surface
    shown = whole.triangles if skin.part.sectors == 1 else whole.triangles[~whole.cyclic]
    if len(shown) > triangles:
        mesh = offscreen.pyvista().PolyData.from_regular_faces(skin.points, shown)
        mesh.point_data["place"] = np.arange(len(skin.points))
        thinner = mesh.decimate_pro(
            1 - triangles / len(shown),
            feature_angle=20.0,
            splitting=False,
            preserve_topology=True,
            boundary_vertex_deletion=False,
        )
        shown = np.asarray(thinner.point_data["place"])[thinner.regular_faces]
    used, numbers = np.unique(shown, return_inverse=True)
    points, fewer = skin.points[used], numbers.reshape(-1, 3)
    edges = bent_edges(points, fewer)
    rim = np.isin(used, whole.outline)  # a flat face of few triangles bends where it is none
    thin = Surface(
        nodes=whole.nodes[used],
        triangles=fewer,
        outline=edges[rim[edges].all(axis=1)],
        mesh_edges=np.empty((0, 2), np.int64),
        cyclic=np.zeros(len(fewer), bool),
    )
    split, triangles_of_split = scene.smooth_surface(points, thin)
    return DeformedSkin(skin.part, thin, skin.shape[used], split, triangles_of_split)


def _ring_at(
    moving: Sequence[_Moving], angle: float, scale: float, bar: _ColourBar
) -> scene.DrawnScene:
    """Scene of all sectors at a phase angle α in rad, coloured by the length of displacement."""

    def moved(i: int, j: int) -> tuple[Floats, Floats]:
        u = moving[i].displacement(j, angle)
        return moving[i].skin.points + scale * u, bar.colours(np.linalg.norm(u, axis=1))

    skins = [each.skin for each in moving]
    fit = np.concatenate([scene.ring(skin.points, skin.part.sectors) for skin in skins])
    camera = replace(scene.ring_camera(skins[0].part.points, fit), margin=_MARGIN)
    return all_sectors(skins, moved, camera)


def _largest(moving: Sequence[_Moving]) -> float:
    """Largest displacement in a period, which is the same in every sector, m."""
    angles = 2 * np.pi * np.arange(72) / 72
    return max(
        float(np.linalg.norm(each.displacement(0, angle), axis=1).max())
        for each in moving
        for angle in angles
    )


def _animate(
    path: style.PathLike,
    moving: Sequence[_Moving],
    scale: float,
    bar: _ColourBar,
    texts: tuple[str, str, str],
) -> Path:
    title, subtitle, heading = texts
    with style.applied():
        figure = style.figure(6.4, title, subtitle, width=7.2)
        style.heading(figure, 0.35, 5.34, heading)
        style.colour_bar(
            style.axes(figure, 6.25, 1.3, 0.15, 3.4), style.AMPLITUDE_MAP, 0, bar.top, bar.label
        )
        time = style.axes(figure, 0.6, 0.66, 5.2, 0.06)
        time.set(
            xlim=(0, 1), ylim=(0, 1), xticks=(0, 0.5, 1), yticks=(), xlabel="time / period (–)"
        )
        time.grid(False)
        still = gif.canvas(figure)
        track = time.get_window_extent().extents
    height = len(still)
    size = round(5.8 * gif.DPI), round(4.55 * gif.DPI)
    left, top = round(0.2 * gif.DPI), round(1.14 * gif.DPI)
    shots = []
    angles = 2 * np.pi * np.arange(FRAMES) / FRAMES
    with window(_ring_at(moving, 0.0, scale, bar), size) as opened:
        for angle in angles:
            opened.move(_ring_at(moving, angle, scale, bar))
            shot = still.copy()
            shot[top : top + size[1], left : left + size[0]] = opened.picture()
            end = track[0] + (track[2] - track[0]) * angle / (2 * np.pi)
            rows = slice(height - round(track[3]), height - round(track[1]))
            shot[rows, round(track[0]) : round(end) + 1] = _INK
            shots.append(shot)
    return gif.write_gif(path, shots, MILLISECONDS)
