"""The mesh: node sets, hook and ring; where it has its error; `.vtu` files for ParaView."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from vanelock.common.arrays import Complex, Floats, Integers
from vanelock.common.files.files import placed
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import annulus, offscreen, scene, window

# Sets that belong together share a colour; an entry without nodes in any part is left out.
SETS: Final[tuple[tuple[str, tuple[str, ...], str, str], ...]] = (
    ("hook bands", ("hook_front", "hook_rear"), style.VERMILION, "o"),
    ("key nodes, merged", ("key",), style.BLACK, "o"),
    ("interlock faces", ("interlock_left", "interlock_right"), style.GREEN, "o"),
    ("loaded nodes", ("force",), style.BLUE, "o"),
    ("output nodes", ("output",), style.PURPLE, "o"),
)

# The tetrahedra that make up a quadratic one: at its corners, and around a diagonal between.
_CORNERS: Final = ((0, 4, 6, 7), (1, 5, 4, 8), (2, 6, 5, 9), (3, 7, 8, 9))
_EIGHTHS: Final = np.array((*_CORNERS, (6, 8, 4, 5), (6, 8, 5, 9), (6, 8, 9, 7), (6, 8, 7, 4)))


def mesh_picture(path: style.PathLike, vane: Part, casing: Part, title: str = "Mesh") -> Path:
    """Draw vane segment and casing sector with their node sets, and return the path.

    Left: the sector, the casing translucent, nodes of the sets as balls (pale where hidden).
    Right: the meridional section through the front hook, in mm, and the full ring.

    Parameters
    ----------
    path : path
        PNG file to write.
    vane, casing : Part
        The two parts; any of the sets of `Part` may be absent.
    title : str
        Heading of the figure.

    Raises
    ------
    InputError
        If this machine cannot draw, or the file cannot be written.
    """
    parts = (vane, casing)
    with style.applied():
        figure = style.figure(8.4, title, _counts(parts))
        window.image(figure, _sector(parts), 0.3, 1.25, 6.6, 6.1)
        cut = style.axes(figure, 7.75, 4.75, 3.9, 2.4)
        _section(cut, parts)
        window.image(figure, _ring(parts), 7.1, 0.25, 4.75, 3.75)
        style.heading(figure, 7.1, 4.02, f"Full ring of {vane.sectors} sectors")
        _legend(figure, parts)
        return style.write(figure, path)


def _counts(parts: Sequence[Part]) -> str:
    one = (f"{p.name}: {len(p.points):,} nodes, {len(p.cells):,} {p.cell_type}" for p in parts)
    return f"{';  '.join(one)};  {3 * sum(len(p.points) for p in parts):,} degrees of freedom"


def _sector(parts: Sequence[Part]) -> scene.DrawnScene:
    bodies, lines = [], []
    for part in parts:
        skin, place, triangles = scene.smooth_skin(part)
        points = part.points[skin.nodes]
        solid = part is parts[0]
        bodies.append(
            scene.SceneBody(
                points[place], triangles, style.part_colour(part.name), 1 if solid else 0.3
            )
        )
        opacity = 0.45 if solid else 0.14
        lines.append(scene.SceneLines(points, skin.mesh_edges, width=1, opacity=opacity))
        lines.append(
            scene.SceneLines(points, skin.outline, width=1.6, opacity=0.9 if solid else 0.5)
        )
    marks = []
    for _, names, colour, _ in SETS:
        for part in parts:
            nodes = _nodes(part, names)
            if len(nodes):
                marks.append(scene.Marks(part.points[nodes], colour, 13 if "key" in names else 10))
    every = np.concatenate([part.points for part in parts])
    return scene.DrawnScene(scene.sector_camera(parts[0].points, every), bodies, lines, marks)


def _nodes(part: Part, names: Sequence[str]) -> Integers:
    found = [part.node_sets[name] for name in names if name in part.node_sets]
    return np.unique(np.concatenate(found)) if found else np.empty(0, np.int64)


def _ring(parts: Sequence[Part]) -> scene.DrawnScene:
    """The ring in pale colours, the meshed sector in its own."""
    bodies, lines = [], []
    for part in parts:
        skin, place, triangles = scene.smooth_skin(part, corners_only=True)
        points = part.points[skin.nodes]
        colour = style.part_colour(part.name)
        bodies.append(scene.SceneBody(points[place], triangles, colour))
        copies = range(1, part.sectors)
        if not copies:
            continue
        others = [annulus.sector_points(points[place], j, part.sectors) for j in copies]
        pale = scene.SceneBody(
            np.concatenate(others),
            scene.repeat(triangles[~skin.cyclic], len(place), len(copies)),
            "#eceef0",
        )
        bodies.append(pale)
        whole = scene.ring(points, part.sectors)
        edges = scene.repeat(skin.outline, len(points), part.sectors)
        lines.append(scene.SceneLines(whole, edges, style.GREY, 0.7, 0.5))
    return scene.DrawnScene(scene.ring_camera(parts[0].points), bodies, lines)


def _section(axes: Axes, parts: Sequence[Part]) -> None:
    """Meridional section through the middle of the front hook, in mm, its elements drawn."""
    vane, casing = parts
    hook = vane.node_sets.get("hook_front")
    points = vane.points[hook] if hook is not None else vane.points
    angle = float(np.arctan2(points[:, 1].mean(), points[:, 0].mean()))
    if hook is not None:
        # Just beside a node, so that the cut does not run along element faces.
        angle += 1e-3
    for part in (casing, vane):
        pieces, edges = _meridional_section(part, angle)
        colour = style.part_colour(part.name)
        # Thin lines of the same colour close the seams between the pieces.
        axes.add_collection(
            PolyCollection([1e3 * piece for piece in pieces], color=colour, linewidths=0.3)
        )
        axes.add_collection(
            LineCollection([1e3 * edge for edge in edges], colors=style.BLACK, linewidths=0.5)
        )
    if hook is not None:
        radius = np.hypot(points[:, 0], points[:, 1])
        axes.plot(1e3 * points[:, 2], 1e3 * radius, "o", color=style.VERMILION, ms=7, zorder=3)
        z, r = 1e3 * points[:, 2].mean(), 1e3 * radius.mean()
        span = max(1e3 * np.ptp(radius), 1.0)
        axes.set(xlim=(z - 3.4 * span, z + 4.4 * span), ylim=(r - 2.7 * span, r + 2.2 * span))
    else:
        axes.autoscale()
    axes.set_aspect("equal", adjustable="box", anchor="W")
    axes.set(
        xlabel="axial position z (mm)",
        ylabel="radius r (mm)",
        title="Section through the front hook" if hook is not None else "Section",
    )
    axes.grid(False)


def _meridional_section(part: Part, angle: float) -> tuple[list[Floats], Floats]:
    """Cut of a part's elements by the half plane at `angle` radians about z.

    Quadratic tetrahedra are cut in eight pieces each, so that their curved sides show.
    """
    pv = offscreen.pyvista()
    if part.cell_type == "tetra10":
        cells = part.cells[:, _EIGHTHS].reshape(-1, 4)
    else:
        cells = part.cells[:, : 4 if part.cell_type == "tetra" else 8]
    kind = pv.CellType.TETRA if cells.shape[1] == 4 else pv.CellType.HEXAHEDRON
    grid = pv.UnstructuredGrid({kind: cells}, part.points)
    grid.cell_data["element"] = np.arange(len(cells)) // (len(cells) // len(part.cells))
    normal = (-np.sin(angle), np.cos(angle), 0.0)
    cut = grid.slice(normal=normal, origin=(0.0, 0.0, 0.0), generate_triangles=False)
    if not cut.n_cells:
        return [], np.empty((0, 2, 2))
    flat = np.column_stack([cut.points[:, 2], cut.points @ [np.cos(angle), np.sin(angle), 0.0]])
    pieces, sides = [], []
    for face, element in zip(
        cut.irregular_faces, np.asarray(cut.cell_data["element"]), strict=True
    ):
        if flat[face, 1].mean() > 0:
            pieces.append(flat[face])
            ends = np.sort(np.column_stack([face, np.roll(face, -1)]), axis=1)
            sides.append(np.column_stack([np.full(len(face), element), ends]))
    if not sides:
        return [], np.empty((0, 2, 2))
    unique, count = np.unique(np.concatenate(sides), axis=0, return_counts=True)
    return pieces, flat[unique[count == 1, 1:]]  # not between two pieces of one element


def _legend(figure: Figure, parts: Sequence[Part]) -> None:
    handles: list[Line2D | Patch] = [
        Patch(facecolor=style.part_colour(part.name), edgecolor=style.GREY, label=part.name)
        for part in parts
    ]
    for label, names, colour, marker in SETS:
        counts = [f"{len(_nodes(p, names))} {p.name}" for p in parts if len(_nodes(p, names))]
        if counts:
            handles.append(
                Line2D(
                    [],
                    [],
                    color=colour,
                    marker=marker,
                    ls="",
                    ms=8,
                    label=f"{label}: {', '.join(counts)}",
                )
            )
    faces = [f"{len(p.node_sets['left'])} {p.name}" for p in parts if "left" in p.node_sets]
    note = [f"cyclic faces: {', '.join(faces)} nodes each"] if faces else []
    clamped = [f"{len(p.node_sets['fixed'])} {p.name}" for p in parts if "fixed" in p.node_sets]
    note += [f"clamped: {', '.join(clamped)} nodes"] if clamped else []
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.3 / style.WIDTH, 0.3 / 8.4),
        ncols=2,
        columnspacing=1.5,
        handletextpad=0.5,
        borderpad=0,
        fontsize=10.5,
    )
    if note:
        figure.text(
            0.35 / style.WIDTH,
            0.14 / 8.4,
            "Pale balls: hidden nodes. Not marked: " + "; ".join(note),
            fontsize=9.5,
            color=style.GREY,
        )


LOW, HIGH = -2.0, 2.0
"""Powers of ten of the mean between which colours lie."""


def mesh_error_picture(
    path: style.PathLike,
    parts: Sequence[Part],
    densities: Sequence[Floats],
    title: str,
    subtitle: str = "",
) -> Path:
    """Draw what meshes add to a mode's stiffness, and return the path.

    Parameters
    ----------
    path : path
        PNG file to write.
    parts : sequence of Part
        Vane and casing.
    densities : sequence of (n,) float
        At each node, energy per volume over the mean of both.
    title, subtitle : str
        Heading, and the line under it.

    Raises
    ------
    InputError
        If this machine cannot draw.
    """
    with style.applied():
        figure = style.figure(6.9, title, subtitle)
        for left, part, values in zip((0.3, 5.7), parts, densities, strict=True):
            skin, split, triangles = scene.smooth_skin(part, corners_only=True)
            points = part.points[skin.nodes]
            powers = np.log10(np.maximum(values[skin.nodes], 10**LOW)).clip(LOW, HIGH)
            colour = scene.colours(powers, style.AMPLITUDE_MAP, LOW, HIGH)
            sides = np.sort(skin.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
            lines = [scene.SceneLines(points, np.unique(sides, axis=0), style.BLACK, 0.5, 0.35)]
            body = scene.SceneBody(points[split], triangles, colour[split])
            drawn = scene.DrawnScene(scene.sector_camera(part.points), [body], lines)
            window.panel(figure, drawn, left, 5.1, f"The {part.name}'s elements")
        bar = style.axes(figure, 10.95, 1.6, 0.15, 3.2)
        label = "error per volume, over its mean"
        shown = style.colour_bar(bar, style.AMPLITUDE_MAP, LOW, HIGH, label)
        ticks = np.arange(LOW, HIGH + 1)
        shown.set_ticks(ticks, labels=[f"{10.0**tick:g}" for tick in ticks])
        return style.write(figure, path)


def write_vtu(
    path: style.PathLike,
    part: Part,
    shape: Complex | None = None,
    fields: Mapping[str, Floats] | None = None,
    unit: str = "m",
) -> Path:
    """Write a part with its node sets and, if given, a shape or fields, and return the path.

    Parameters
    ----------
    path : path
        File to write, named `.vtu`.
    part : Part
        Becomes points (m) and elements; each node set becomes point data of its name, the place 1,
        2, ... in the set at its nodes and 0 elsewhere, from which `mesh.read_mesh` reads it back.
    shape : (n, 3) complex, optional
        Becomes the point data `displacement_real (m)`, `displacement_imag (m)` (Cartesian),
        `amplitude (m)` (largest length in a cycle) and `phase_radial (deg)`. ParaView's "Warp By
        Vector" on the first two deforms the part at the instants 0 and a quarter period before.
    fields : mapping of str to (n,) or (n, k) float, optional
        Point data by their names, which have the unit.
    unit : str
        Of the shape.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    import meshio

    data: dict[str, NDArray[Any]] = dict(fields or {})
    if shape is not None:
        data |= _moving(part.points, shape, unit)
    for name, nodes in part.node_sets.items():
        place = np.zeros(len(part.points), np.int32)
        place[nodes] = np.arange(1, len(nodes) + 1)
        data[name] = place
    mesh = meshio.Mesh(part.points, [(part.cell_type, part.cells)], point_data=data)
    target = Path(path)
    with placed(target) as temporary:
        mesh.write(temporary, file_format="vtu")
    return target


def _moving(points: Floats, shape: Complex, unit: str) -> dict[str, Floats]:
    """Point data of a shape."""
    radial = annulus.cylindrical(points, shape)[:, 0]
    return {
        f"displacement_real ({unit})": shape.real,
        f"displacement_imag ({unit})": shape.imag,
        f"amplitude ({unit})": annulus.peak(shape),
        "phase_radial (deg)": np.degrees(np.angle(radial)),
    }
