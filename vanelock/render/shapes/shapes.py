"""Deformed shapes of sector and ring: modes, response at resonance, its stress."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from vanelock.common.arrays import Complex, Floats, Integers
from vanelock.common.cyclic import COMPONENTS, phase_factor
from vanelock.common.errors import InputError
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import annulus, scene, window
from vanelock.render.scenes.surface import Surface

# (m, 3) points and shape of one sector -> (m, 3) colours
Paint = Callable[[Floats, Complex], Floats]

DRAWN: Final = 0.05
"""Largest displacement in a picture, as a share of the ring's outer radius."""
_FAINT: Final = 0.02  # below this share of the largest a phase means nothing


@dataclass(frozen=True)
class DeformedSkin:
    """What one part needs to be drawn.

    Attributes
    ----------
    part : Part
        The part.
    surface : Surface
        Its skin.
    shape : (m, 3) complex
        The shape on sector 0 at the skin's nodes.
    split : (p,) int
        Into those nodes: they are doubled along sharp edges.
    triangles : (t, 3) int
        Into `split`.
    """

    part: Part
    surface: Surface
    shape: Complex
    split: Integers
    triangles: Integers

    @property
    def points(self) -> Floats:
        """(m, 3) undeformed coordinates of the skin's nodes, m."""
        points: Floats = self.part.points[self.surface.nodes]
        return points


def mode_picture(
    path: style.PathLike,
    parts: Sequence[Part],
    shapes: Sequence[Complex],
    nodal_diameter: int,
    title: str,
    subtitle: str = "",
) -> Path:
    """Draw a mode on its sector and on the full ring, and return the path.

    Both are deformed at the instant at which the sector deflects most, and coloured by the length
    of the displacement at that instant over the largest length in a cycle.

    Parameters
    ----------
    path : path
        PNG file to write.
    parts : sequence of Part
        Usually all parts of a sector, of one ring.
    shapes : sequence of (n, 3) complex
        Cartesian shape of each part on sector 0, in any one scale.
    nodal_diameter : int
        ND of the shape: sector j has the phase -j 2π ND/N.
    title : str
        Heading, such as "Mode 2 of nodal diameter 1: 250.9 Hz".
    subtitle : str
        A line before the statement of the scale.

    Raises
    ------
    InputError
        If the shape is zero, or this machine cannot draw.
    """
    skins = skins_of(parts, shapes)
    largest = max(float(annulus.peak(shape).max()) for shape in shapes)
    drawn = mode_size(parts)
    scale = drawn / largest
    angle = annulus.largest_instant(*shapes)

    def paint(_: Floats, shape: Complex) -> Floats:
        length = np.linalg.norm(annulus.at(shape, angle), axis=1) / largest
        return scene.colours(length, style.AMPLITUDE_MAP, 0, 1)

    stated = f"Drawn at its largest deflection; largest displacement drawn as {1e3 * drawn:.3g} mm"
    with style.applied():
        figure = style.figure(6.9, title, sentences(subtitle, stated))
        sector = _sector_scene(skins, angle, scale, paint)
        window.panel(figure, sector, 0.3, 5.0, "One sector (undeformed in grey)")
        # Each sector of the ring is small: its elements' corners are enough.
        coarse = skins_of(parts, shapes, corners_only=True)
        ring = _ring_scene(coarse, nodal_diameter, angle, scale, paint)
        heading = f"Full ring, {ring_and_wave(parts, nodal_diameter)}"
        window.panel(figure, ring, 5.3, 5.4, heading)
        bar = style.axes(figure, 10.95, 1.4, 0.16, 3.6)
        label = "displacement / largest displacement (–)"
        style.colour_bar(bar, style.AMPLITUDE_MAP, 0, 1, label)
        return style.write(figure, path)


def response_picture(
    path: style.PathLike,
    parts: Sequence[Part],
    shapes: Sequence[Complex],
    nodal_diameter: int,
    title: str,
    subtitle: str = "",
) -> Path:
    """Draw amplitude and phase of a response on the full ring, and return the path.

    Left: amplitude, the largest displacement that each point reaches in a cycle, in µm. Right: the
    phase of the cylindrical component that moves most in degrees, positive where it leads the
    excitation of sector 0; grey where that component stays below 2 % of its largest.

    Parameters
    ----------
    path : path
        PNG file to write.
    parts : sequence of Part
        Usually all parts of a sector, of one ring.
    shapes : sequence of (n, 3) complex
        Cartesian displacement of each part on sector 0, one-sided amplitude of a harmonic, m.
    nodal_diameter : int
        ND of that harmonic.
    title, subtitle : str
        Heading, and a line before the statement of the scale.

    Raises
    ------
    InputError
        If the shape is zero, or this machine cannot draw.
    """
    skins = skins_of(parts, shapes, corners_only=True)
    amplitude = max(float(annulus.peak(shape).max()) for shape in shapes)
    scale = annulus.round_scale(amplitude, DRAWN * outer_radius(parts))
    angle = annulus.largest_instant(*shapes)
    moved = [annulus.cylindrical(p.points, shape) for p, shape in zip(parts, shapes, strict=True)]
    size = np.abs(np.concatenate(moved))
    component = int(np.argmax(np.sum(size**2, axis=0)))
    strongest = float(size[:, component].max())

    def by_amplitude(_: Floats, shape: Complex) -> Floats:
        return scene.colours(1e6 * annulus.peak(shape), style.AMPLITUDE_MAP, 0, 1e6 * amplitude)

    def by_phase(points: Floats, shape: Complex) -> Floats:
        moved = annulus.cylindrical(points, shape)[:, component]
        degrees = np.degrees(np.angle(moved))
        degrees[np.abs(moved) < _FAINT * strongest] = np.nan
        return scene.colours(degrees, style.PHASE_MAP, -180, 180)

    stated = (
        f"Largest amplitude {style.number(1e6 * amplitude)} µm; "
        f"deformation drawn {scale:,.10g} times as large"
    )
    name = COMPONENTS[component]
    with style.applied():
        figure = style.figure(6.9, title, sentences(subtitle, stated))
        left = _ring_scene(skins, nodal_diameter, angle, scale, by_amplitude)
        heading = f"Amplitude, {ring_and_wave(parts, nodal_diameter)}"
        window.panel(figure, left, 0.3, 4.75, heading)
        bar = style.axes(figure, 5.1, 1.6, 0.15, 3.2)
        style.colour_bar(bar, style.AMPLITUDE_MAP, 0, 1e6 * amplitude, "amplitude (µm)")
        right = _ring_scene(skins, nodal_diameter, angle, scale, by_phase)
        window.panel(figure, right, 6.1, 4.75, f"Phase of the {name} motion")
        bar = style.axes(figure, 10.9, 1.6, 0.15, 3.2)
        phase = style.colour_bar(bar, style.PHASE_MAP, -180, 180, "phase (degrees)")
        phase.set_ticks(range(-180, 181, 60))
        across, up = figure.get_size_inches()
        figure.text(
            6.1 / across,
            0.22 / up,
            f"Grey: {name} motion below {100 * _FAINT:.0f} % of its largest",
            fontsize=10.5,
            color=style.GREY,
        )
        return style.write(figure, path)


def skins_of(
    parts: Sequence[Part], shapes: Sequence[Complex], corners_only: bool = False
) -> list[DeformedSkin]:
    """What is drawn of each part with its shape."""
    if not any(np.any(shape) for shape in shapes):
        raise InputError("shapes: zero everywhere: there is nothing to draw")
    skins = []
    for part, shape in zip(parts, shapes, strict=True):
        skin, split, triangles = scene.smooth_skin(part, corners_only)
        skins.append(DeformedSkin(part, skin, np.asarray(shape)[skin.nodes], split, triangles))
    return skins


def mode_size(parts: Sequence[Part]) -> float:
    """Length as which the largest displacement of a mode is drawn, whole mm of the parts."""
    drawn = DRAWN * outer_radius(parts)
    return 1e-3 * max(round(1e3 * drawn), 1) if drawn > 1e-3 else drawn


def outer_radius(parts: Sequence[Part]) -> float:
    """Largest distance of a node from the axis, m."""
    return max(float(np.hypot(part.points[:, 0], part.points[:, 1]).max()) for part in parts)


def _sector_scene(
    skins: Sequence[DeformedSkin], angle: float, scale: float, paint: Paint
) -> scene.DrawnScene:
    """Scene of sector 0, with the undeformed outline."""
    bodies, lines, seen = [], [], []
    for skin in skins:
        moved = skin.points + scale * annulus.at(skin.shape, angle)
        colour = paint(skin.points, skin.shape)
        bodies.append(scene.SceneBody(moved[skin.split], skin.triangles, colour[skin.split]))
        lines.append(scene.SceneLines(moved, skin.surface.outline, style.BLACK, 1.2, 0.7))
        lines.append(scene.SceneLines(skin.points, skin.surface.outline, style.GREY, 1.0, 0.5))
        seen += [moved, skin.points]
    camera = scene.sector_camera(skins[0].part.points, np.concatenate(seen))
    return scene.DrawnScene(camera, bodies, lines)


def _ring_scene(
    skins: Sequence[DeformedSkin], nodal_diameter: int, angle: float, scale: float, paint: Paint
) -> scene.DrawnScene:
    """Scene of all sectors of a wave, each deformed and painted by the shape on it."""

    def moved(i: int, j: int) -> tuple[Floats, Floats]:
        skin = skins[i]
        shape = skin.shape * phase_factor(nodal_diameter * j, skin.part.sectors)
        return skin.points + scale * annulus.at(shape, angle), paint(skin.points, shape)

    return all_sectors(skins, moved, scene.ring_camera(skins[0].part.points))


def all_sectors(
    skins: Sequence[DeformedSkin],
    moved: Callable[[int, int], tuple[Floats, Floats]],
    camera: scene.Camera,
) -> scene.DrawnScene:
    """Scene of a ring: `moved` gives points and colours of skin i on sector j, in 0's frame."""
    bodies, lines = [], []
    for i, skin in enumerate(skins):
        sectors = skin.part.sectors
        placed, colours = [], []
        for j in range(sectors):
            points, colour = moved(i, j)
            placed.append(annulus.sector_points(points, j, sectors))
            colours.append(colour[skin.split])
        triangles = skin.triangles if sectors == 1 else skin.triangles[~skin.surface.cyclic]
        bodies.append(
            scene.SceneBody(
                np.concatenate([points[skin.split] for points in placed]),
                scene.repeat(triangles, len(skin.split), sectors),
                np.concatenate(colours),
            )
        )
        edges = scene.repeat(skin.surface.outline, len(skin.points), sectors)
        lines.append(scene.SceneLines(np.concatenate(placed), edges, style.BLACK, 0.8, 0.45))
    return scene.DrawnScene(camera, bodies, lines)


def ring_and_wave(parts: Sequence[Part], nodal_diameter: int) -> str:
    """Words for the ring and the wave on it."""
    sectors = parts[0].sectors
    return f"{sectors} sectors, {annulus.wave_name(nodal_diameter, sectors)}"


def sentences(*texts: str) -> str:
    """Texts as sentences, empty ones left out."""
    return ". ".join(text.rstrip(". ") for text in texts if text) + "."


_SHOWN: Final = 0.995
"""Share of the surface's nodes within the colours: what stands out there are point forces."""


def stress_picture(
    path: style.PathLike,
    part: Part,
    total: Floats,
    vibration: Floats,
    title: str,
    subtitle: str = "",
    gauges: Sequence[Sequence[float]] | Floats = (),
) -> Path:
    """Draw stresses on a part, and return the path.

    Left: with what acts at rest; right: of the vibration alone. Colours end where 99.5 % of the
    surface's nodes lie below: the stress at a node that carries a contact's force has no meaning.

    Parameters
    ----------
    path : path
        PNG file to write.
    part : Part
    total, vibration : (n,) float
        Largest von Mises stress over a period at each node, Pa.
    title, subtitle : str
        Heading, and a line before the statement of the scales.
    gauges : (g, 3), optional
        Positions to mark, m.

    Raises
    ------
    InputError
        If this machine cannot draw.
    """
    skin, split, triangles = scene.smooth_skin(part)
    points = part.points[skin.nodes]
    camera = scene.sector_camera(part.points)
    lines = [scene.SceneLines(points, skin.outline, style.BLACK, 1.2, 0.7)]
    gauge_places = np.asarray(gauges, float).reshape(-1, 3)
    marks = [scene.Marks(gauge_places, style.VERMILION, 7.0)] if len(gauge_places) else []
    panels = (("With the preload at rest", total), ("Of the vibration alone", vibration))
    with style.applied():
        stated = "Colours end where 99.5 % of the surface lies below"
        marked = ". Balls: strain gauges, pale where hidden" if len(gauge_places) else ""
        figure = style.figure(6.9, title, sentences(subtitle, stated + marked))
        for left, (heading, values) in zip((0.3, 6.1), panels, strict=True):
            shown = 1e-6 * values[skin.nodes]
            top = float(np.quantile(shown, _SHOWN)) or 1.0
            colour = scene.colours(np.minimum(shown, top), style.AMPLITUDE_MAP, 0, top)
            body = scene.SceneBody(points[split], triangles, colour[split])
            drawn = scene.DrawnScene(camera, [body], lines, marks)
            window.panel(figure, drawn, left, 4.75, heading)
            bar = style.axes(figure, left + 4.8, 1.6, 0.15, 3.2)
            style.colour_bar(bar, style.AMPLITUDE_MAP, 0, top, "von Mises stress (MPa)")
        return style.write(figure, path)
