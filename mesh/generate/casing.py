"""The casing sector: shell, two end flanges, two rails whose grooves hold the vane's feet.

Strut bosses are cylinders that stand radially on the outside of the shell.

Both cyclic faces get the same number of quadratic nodes. A face without holes, with V corner nodes
of which B lie on its boundary, has 3V - 3 - B edges of triangles and so F = 4V - 3 - B quadratic
nodes: B = 1 - F modulo 4. One more interval on an edge adds a boundary node, mostly with no other
one, and so 3 nodes. The counts of intervals of the face's edges are searched, meshing the face
alone, from those of evenly coarser and finer meshes.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.mesh.cells import valid
from vanelock.mesh.checks import check_casing, check_meshable, check_resolved
from vanelock.mesh.contact_patches import hook_averages, hook_overlap
from vanelock.mesh.element_size import LARGEST, SMALLEST, checked_stretch, drawn_out, element_size
from vanelock.mesh.generate import occ_solids
from vanelock.mesh.generate.mesher import along, generate, matching, nodes_on, place
from vanelock.mesh.generate.occ_solids import TOLERANCE, Entity
from vanelock.mesh.geometry import contact_places
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.geometry.revolved import casing_outline
from vanelock.mesh.gmsh_session import session
from vanelock.mesh.part import Part


def casing_sector(
    dimensions: CasingDimensions | None = None,
    hook: HookDimensions | None = None,
    sectors: int = 16,
    size: str | float = "medium",
    overlap: tuple[float, float] | None = None,
    face_nodes: int | None = None,
    stretch: int | None = None,
) -> Part:
    """Mesh one casing sector with curved quadratic tetrahedra.

    Parameters
    ----------
    dimensions : CasingDimensions, optional
        The scene's by default.
    hook : HookDimensions, optional
        What the groove shares with the vane's foot, `VaneDimensions.hook`.
    sectors : int
        Sectors in the ring.
    size : {"coarse", "medium", "paper", "fine"} or float
        Largest element edge, by name or in m.
    overlap : (front, rear) float, optional
        Axial range in which the front foot lies in its groove, m, which bounds the hooks' contact
        patches: `hook_overlap(vane, casing)`. The scene's foot unless given.
    face_nodes : int, optional
        Nodes of each cyclic face, exactly; whatever the size gives unless given. The elements on
        the faces' edges then differ from the size, by a quarter at most but for the rounding of
        their numbers.
    stretch : int, optional
        Elements are so many times longer around the ring than `size`, 1 to 8; more than 1 only
        without bosses. 3 unless given, 1 with bosses: a mesh of as many degrees of freedom has half
        the error with 3.

    Returns
    -------
    Part
        "casing", with the sets `hook_front`, `hook_rear` and `key` (in the order of the vane's,
        at the same places), `left` and `right` (matched), `fixed` (both end faces), `force` (by
        ascending angle) and `output` (3 outside, above the front rail). Frames and contact
        patches for both hooks.

    Raises
    ------
    InputError
        If the dimensions contradict one another, cannot be meshed, do not allow `face_nodes` at
        this size, or the system lacks a library that gmsh needs.
    """
    dimensions = dimensions or CasingDimensions()
    hook = hook or HookDimensions()
    check_casing(dimensions, hook, sectors)
    length = element_size(size, "casing")
    check_resolved("casing.fillet", dimensions.fillet, length)
    check_meshable(dimensions, length)
    stretch = checked_stretch(stretch, dimensions)
    narrow = sectors * stretch  # a sector of so many is meshed, and then drawn out
    step = contact_places.band_pieces(hook, narrow, length)
    bands = contact_places.hook_bands(hook, narrow, step)
    force = contact_places.force_points(dimensions, narrow)
    output = contact_places.casing_output_points(dimensions, narrow)
    outline = casing_outline(dimensions, hook)
    with session("casing") as gmsh:
        band_tags, point_tags = occ_solids.imprint(
            gmsh,
            _add_bosses(
                gmsh, dimensions, narrow, occ_solids.revolve(gmsh, outline, np.pi / narrow)
            ),
            [occ_solids.arc(gmsh, band[0], band[-1]) for band in bands],
            [occ_solids.point(gmsh, position) for position in np.concatenate([force, output])],
        )
        left_tag, right_tag = _end_faces(gmsh, np.pi / narrow)
        for tag in band_tags:
            gmsh.model.mesh.setTransfiniteCurve(tag, bands.shape[1] // 2 + 1)
        occ_solids.grade_fillets(gmsh, dimensions.fillet, length, stretch)
        _divide_bosses(gmsh, dimensions, length)
        affine = np.eye(4)
        affine[:3, :3] = turn(narrow)
        gmsh.model.mesh.setPeriodic(2, [right_tag], [left_tag], affine.ravel().tolist())
        if face_nodes is not None:
            _divide_face(gmsh, left_tag, length, face_nodes)
        mesh = generate(gmsh, length, None, stretch, face_nodes is not None)
        on = [nodes_on(gmsh, mesh, 1, tag) for tag in band_tags]
        at = np.concatenate([nodes_on(gmsh, mesh, 0, tag) for tag in point_tags])
        left, right = (nodes_on(gmsh, mesh, 2, tag) for tag in (left_tag, right_tag))
        fixed = np.unique(
            np.concatenate(
                [
                    nodes_on(gmsh, mesh, 2, tag)
                    for z in (0.0, dimensions.length)
                    for tag in _faces_at(gmsh, z)
                ]
            )
        )
    names = ("front roof", "front lip", "rear roof", "rear lip")
    rows = [
        along(mesh.points, nodes, band, f"casing hook {name}")
        for name, nodes, band in zip(names, on, bands, strict=True)
    ]
    loaded = matching(mesh.points, at[: len(force)], force, "casing force")
    outputs = matching(mesh.points, at[len(force) :], output, "casing output")
    if face_nodes is not None and len(left) != face_nodes:
        raise InputError(
            f"mesh.face_nodes = {face_nodes}: the casing got {len(left)}: choose another mesh.size"
        )
    turned = mesh.points[left] @ turn(narrow).T
    right = matching(mesh.points, right, turned, "casing right")
    points = place(
        mesh,
        np.concatenate([*rows, loaded, outputs]),
        np.concatenate([*bands, force, output]),
        images=(left, right, turn(narrow)),
    )
    if stretch > 1:
        points = drawn_out(points, stretch)
        for nodes, places in (
            (np.concatenate(rows), np.concatenate(contact_places.hook_bands(hook, sectors, step))),
            (loaded, contact_places.force_points(dimensions, sectors)),
            (outputs, contact_places.casing_output_points(dimensions, sectors)),
            (right, points[left] @ turn(sectors).T),
        ):
            points[nodes] = places
    rows = [row[::step] for row in rows]
    frames = contact_places.hook_frames(contact_places.hook_bands(hook, sectors), -1.0)
    part = Part(
        name="casing",
        points=points,
        cells=mesh.cells,
        cell_type="tetra10",
        node_sets={
            "hook_front": np.concatenate(rows[:2]),
            "hook_rear": np.concatenate(rows[2:]),
            "key": np.array([row[len(row) // 2] for row in rows]),
            "left": left,
            "right": right,
            "fixed": fixed,
            "force": loaded,
            "output": outputs,
        },
        frames={"hook_front": np.concatenate(frames[:2]), "hook_rear": np.concatenate(frames[2:])},
        sectors=sectors,
        cad_volume=stretch * mesh.volume,
    )
    overlap = overlap or hook_overlap(VaneDimensions(), dimensions)
    return replace(valid(part), patches=hook_averages(part, hook, overlap))


_SIDES = 8  # fewest elements around a boss


def _add_bosses(gmsh: Any, casing: CasingDimensions, sectors: int, shell: Entity) -> Entity:
    """The shell with its bosses; each begins within the wall, so that no faces coincide."""
    if not casing.bosses:
        return shell
    kernel, radius = gmsh.model.occ, casing.boss_diameter / 2
    start = 0.5 * (casing.inner_radius + np.sqrt(casing.outer_radius**2 - radius**2))
    deep = casing.outer_radius + casing.boss_height - start
    cylinders = []
    for angle in contact_places.boss_angles(casing, sectors):
        c, s = np.cos(angle), np.sin(angle)
        at = (start * c, start * s, casing.boss_position)
        cylinders.append((3, kernel.addCylinder(*at, deep * c, deep * s, 0.0, radius)))
    fused, _ = kernel.fuse([shell], cylinders)
    if len(fused) != 1:
        raise InputError(f"casing: shell and bosses make {len(fused)} bodies instead of one")
    entity: Entity = fused[0]
    return entity


def _divide_bosses(gmsh: Any, casing: CasingDimensions, size: float) -> None:
    """Divide the bosses' round edges evenly, in no fewer than `_SIDES` elements."""
    if not casing.bosses:
        return
    for _, edge in gmsh.model.getEntities(1):
        ends = gmsh.model.getBoundary([(1, edge)], combined=True)
        if not ends:  # closed: no other edge of the casing is
            length = gmsh.model.occ.getMass(1, edge)
            intervals = max(_SIDES, int(np.ceil(length / size)))
            gmsh.model.mesh.setTransfiniteCurve(edge, intervals + 1)


_RATIO = 1.25  # elements of the face's edges may be so much longer or shorter than the element size

_STEPS = 8  # even meshes on either side of the element size
_BASES = 6  # of them perturbed
_TRIALS = 40  # of each
_ENOUGH = 3  # of them that lead to the number


def _divide_face(gmsh: Any, face: int, size: float, nodes: int) -> None:
    """Prescribe counts of intervals on a face's edges that give it a number of nodes.

    The same search finds the same counts; of those found the ones closest to an even mesh of the
    element size are taken. No mesh is left behind.
    """
    alone = _Alone.of(gmsh, face)
    try:
        bases = [alone.even(size * _RATIO ** (k / _STEPS), size) for k in _outwards(_STEPS)]
        reached = [count for count, _ in bases]
        if not min(reached) <= nodes <= max(reached):
            raise InputError(_out_of_reach(alone, reached, nodes, size))
        natural = bases[0][1]
        bases.sort(key=lambda even: abs(even[0] - nodes))
        found: list[tuple[float, Integers]] = []
        for count, intervals in bases[:_BASES]:
            for trial in _near(intervals, alone.straight, count, nodes):
                got = alone.nodes(trial, size)
                reached.append(got)
                if got == nodes:
                    found.append((alone.unevenness(trial, natural), trial))
                    break
            if len(found) == _ENOUGH:
                break
        if not found:
            near = sorted(set(reached), key=lambda count: abs(count - nodes))[:2]
            raise InputError(
                f"mesh.face_nodes = {nodes}: not found with elements of {size * 1e3:g} mm: "
                f"allowed are {' and '.join(map(str, sorted(near)))}, or another mesh.size"
            )
    finally:
        alone.leave()
    alone.prescribe(min(found, key=lambda pair: pair[0])[1])


def _outwards(steps: int) -> list[int]:
    """0, 1, -1, 2, -2, ..."""
    return sorted(range(-steps, steps + 1), key=lambda k: (abs(k), -k))


def _near(intervals: Integers, straight: Booleans, count: int, nodes: int) -> Iterator[Integers]:
    """Counts of intervals near those given whose total allows the wanted number of nodes.

    Changes go to straight edges, more often to those with many intervals, which they disturb less.
    """
    random = np.random.default_rng(nodes)
    total = int(intervals.sum())
    need = round((nodes - count) / 3.3)
    # The nearest change of the total with B = 1 - F modulo 4.
    off = (1 - nodes - total - need + 2) % 4 - 2
    if need + off == 0:
        yield intervals
    for trial in range(_TRIALS):
        change = need + off + 4 * (0, 0, 0, -np.sign(off) or 1, np.sign(off) or -1)[trial % 5]
        swaps = trial // 5
        steps = np.concatenate(
            [np.full(abs(change), np.sign(change)), np.tile([1, -1], swaps)]
        ).astype(np.int64)
        changed = intervals.copy()
        for step in steps:
            free = straight & (changed + step >= 1)
            if not free.any():
                break
            weight = np.where(free, changed, 0) / changed[free].sum()
            changed[random.choice(len(changed), p=weight)] += step
        else:
            yield changed


def _out_of_reach(alone: "_Alone", reached: list[int], nodes: int, size: float) -> str:
    low, high = SMALLEST, LARGEST
    most, fewest = (alone.even(limit, limit)[0] for limit in (low, high))
    text = (
        f"mesh.face_nodes = {nodes}: with elements of {size * 1e3:g} mm a cyclic face of the "
        f"casing has about {reached[0]} nodes: allowed are {min(reached)} to {max(reached)}"
    )
    if not fewest <= nodes <= most:
        return f"{text}; with other mesh.size {fewest} to about {most}"
    while high / low > 1.01:
        middle = np.sqrt(low * high)
        low, high = (middle, high) if alone.even(middle, middle)[0] > nodes else (low, middle)
    return f"{text}; {nodes} suits mesh.size = {1e3 * np.sqrt(low * high):.2g} mm"


@dataclass(frozen=True)
class _Alone:
    """One face of a model, meshed without the rest."""

    gmsh: Any
    face: int
    edges: list[int]
    length: Floats
    straight: Booleans

    @classmethod
    def of(cls, gmsh: Any, face: int) -> "_Alone":
        model = gmsh.model
        edges = [tag for _, tag in model.getBoundary([(2, face)], oriented=False)]
        gmsh.option.setNumber("Mesh.MeshOnlyVisible", 1)
        model.setVisibility(model.getEntities(), 0)
        model.setVisibility([(2, face)], 1, recursive=True)
        length = np.array([model.occ.getMass(1, tag) for tag in edges])
        straight = np.array([model.getType(1, tag) == "Line" for tag in edges])
        return cls(gmsh, face, edges, length, straight)

    def leave(self) -> None:
        """Drop the face's mesh and show the rest of the model again."""
        model = self.gmsh.model
        model.mesh.clear()
        self.gmsh.option.setNumber("Mesh.MeshOnlyVisible", 0)
        model.setVisibility(model.getEntities(), 1)

    def even(self, edge: float, size: float) -> tuple[int, Integers]:
        """Nodes of the face with elements of `size` and with edges meshed evenly, and counts."""
        model = self.gmsh.model
        model.mesh.clear()
        model.mesh.removeConstraints([(1, tag) for tag in self.edges])
        self.gmsh.option.setNumber("Mesh.MeshSizeMax", edge)
        model.mesh.generate(1)
        intervals = [len(model.mesh.getElements(1, tag)[1][0]) for tag in self.edges]
        found = np.array(intervals, dtype=np.int64)
        return self.nodes(found, size), found

    def nodes(self, intervals: Integers, size: float) -> int:
        """Quadratic nodes of the face with its edges divided as given."""
        mesh = self.gmsh.model.mesh
        mesh.clear()
        self.prescribe(intervals)
        self.gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        mesh.generate(2)
        corners, _, _ = mesh.getNodes(2, self.face, includeBoundary=True)
        return 4 * len(corners) - 3 - int(intervals.sum())

    def prescribe(self, intervals: Integers) -> None:
        """Set the counts of intervals of the face's edges."""
        for tag, count in zip(self.edges, intervals.tolist(), strict=True):
            self.gmsh.model.mesh.setTransfiniteCurve(tag, count + 1)

    def unevenness(self, intervals: Integers, natural: Integers) -> float:
        """Mean square of the logarithm of the edges' elements against the natural ones."""
        ratio = np.log(intervals / natural)
        return float(ratio**2 @ self.length / self.length.sum())


def _faces_at(gmsh: Any, z: float) -> list[int]:
    """The faces that lie in the plane at z."""
    found = []
    for _, tag in gmsh.model.getEntities(2):
        _, _, low, _, _, high = gmsh.model.getBoundingBox(2, tag)
        if abs(low - z) < TOLERANCE and abs(high - z) < TOLERANCE:
            found.append(tag)
    return found


def _end_faces(gmsh: Any, half_angle: float) -> tuple[int, int]:
    """The two faces of a revolved solid in the planes of its ends, left one first."""
    found = {}
    for _, tag in gmsh.model.getEntities(2):
        corners = gmsh.model.getBoundary([(2, tag)], combined=False, recursive=True)
        x, y, _ = np.transpose([gmsh.model.getValue(0, corner, []) for _, corner in corners])
        for side, angle in (("left", -half_angle), ("right", half_angle)):
            if np.abs(y * np.cos(angle) - x * np.sin(angle)).max() < TOLERANCE:
                found[side] = tag
    return found["left"], found["right"]
