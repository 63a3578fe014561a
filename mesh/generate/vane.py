"""The vane segment: outer shroud and hooks, aerofoils, inner shroud with slanted interlocks.

The kernel finds nodes in the middle of sides that run around an aerofoil's rounded edge by
iteration on the surface, and not always half-way. There they must be for a quadratic element's side
to be the parabola that rounds the edge.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from vanelock.common.arrays import Floats, Integers
from vanelock.common.cyclic import rotation, turn
from vanelock.common.errors import InputError
from vanelock.mesh.cells import valid
from vanelock.mesh.checks import check_resolved, check_vane
from vanelock.mesh.contact_patches import hook_averages, hook_overlap, interlock_averages
from vanelock.mesh.element_size import HOOKS, element_size, of_vane
from vanelock.mesh.generate import occ_solids
from vanelock.mesh.generate.aerofoils import aerofoil_solids, divide_aerofoils
from vanelock.mesh.generate.mesher import MeshArrays, along, generate, nearest, nodes_on, place
from vanelock.mesh.generate.occ_solids import Entity
from vanelock.mesh.geometry import aerofoil, contact_places, root_fillet
from vanelock.mesh.geometry.contact_places import pieces
from vanelock.mesh.geometry.dimensions import CasingDimensions, VaneDimensions
from vanelock.mesh.geometry.revolved import hooks_outline, inner_shroud_outline
from vanelock.mesh.geometry.root_fillet import filleted
from vanelock.mesh.gmsh_session import session
from vanelock.mesh.part import Part

_TRIANGLE6 = 9  # gmsh's number of the element type
_SIDES = [(0, 1), (1, 2), (2, 0)]


def _half_way(gmsh: Any, mesh: MeshArrays, vane: VaneDimensions, sectors: int) -> MeshArrays:
    """The mesh with those nodes half-way around."""
    points = mesh.points.copy()
    for _, tag in gmsh.model.getEntities(2):
        _, tags = gmsh.model.mesh.getElementsByType(_TRIANGLE6, tag)
        triangles = mesh.number(tags).reshape(-1, 6)
        for angle in aerofoil.angles(vane, sectors):
            found = _on_edge(mesh, vane, triangles, rotation(angle))
            if found is not None:
                points[triangles[:, 3:].ravel()] = found
    return replace(mesh, points=points)


def _on_edge(
    mesh: MeshArrays, vane: VaneDimensions, triangles: Integers, turn: Floats
) -> Floats | None:
    """Middles (3t, 3) of the triangles' sides, if they cover a rounded edge of this aerofoil."""
    axis = np.array([0.0, 0.0, vane.hook.mid_plane])
    corners = (mesh.points[triangles[:, :3]].reshape(-1, 3) - axis) @ turn
    for number in (0, 1):
        aside = aerofoil.on_rounding(vane, corners, number)
        if aside is not None:
            along, round_ = (
                v.reshape(-1, 3)[:, _SIDES].mean(axis=2) for v in (corners[:, 0], aside)
            )
            middles = aerofoil.rounding(vane, along.ravel(), round_.ravel(), number)
            return np.asarray(middles @ turn.T + axis)
    return None


def vane_segment(
    dimensions: VaneDimensions | None = None,
    sectors: int = 16,
    size: str | float = "medium",
    overlap: tuple[float, float] | None = None,
) -> Part:
    """Mesh one vane segment with curved quadratic tetrahedra.

    Parameters
    ----------
    dimensions : VaneDimensions, optional
        The scene's by default.
    sectors : int
        Segments in the ring.
    size : {"coarse", "medium", "paper", "fine"} or float
        Largest element edge, by name or in m.
    overlap : (front, rear) float, optional
        Axial range in which the front foot lies in its groove, m, which bounds the hooks' contact
        patches: `hook_overlap(vane, casing)`. The scene's groove unless given.

    Returns
    -------
    Part
        "vane", with the sets `hook_front` and `hook_rear` (30 nodes each: roof, then lip, each by
        ascending angle), `key` (4: the middle nodes of front roof, front lip, rear roof, rear
        lip), `interlock_left` and `interlock_right` (10 each: the row at the inner radius, then
        at the outer, each by ascending z) and `output` (3 on the middle aerofoil, from the
        inner shroud outwards). Frames and contact patches for all of them but `key` and
        `output`.

    Raises
    ------
    InputError
        If the dimensions contradict one another, cannot be meshed, or the system lacks a library
        that gmsh needs.
    """
    dimensions = dimensions or VaneDimensions()
    check_vane(dimensions, sectors)
    dimensions = filleted(dimensions, sectors)
    length = element_size(size, "vane")
    check_resolved("vane.fillet", dimensions.fillet, length, HOOKS)
    check_resolved("vane.root_fillet", dimensions.root_fillet or 0.0, length)
    steps = (
        contact_places.band_pieces(dimensions.hook, sectors, HOOKS * length),
        _interlock_pieces(dimensions, length),
    )
    bands = contact_places.hook_bands(dimensions.hook, sectors, steps[0])
    left = contact_places.interlock_rows(dimensions, sectors, steps[1])
    right = left @ turn(sectors).T
    output = aerofoil.output_points(dimensions, sectors)
    with session("vane") as gmsh:
        solid, volume = _vane_solid(gmsh, dimensions, sectors)
        (band_tags,) = occ_solids.imprint(
            gmsh, solid, [occ_solids.arc(gmsh, band[0], band[-1]) for band in bands]
        )
        row_tags = [_edge(gmsh, row) for side in (left, right) for row in side]
        occ_solids.grade_fillets(gmsh, dimensions.fillet, HOOKS * length)
        for tag, nodes in zip(band_tags + row_tags, [*bands, *left, *right], strict=True):
            gmsh.model.mesh.setTransfiniteCurve(tag, len(nodes) // 2 + 1)
        sides = divide_aerofoils(gmsh, dimensions, sectors, length)
        mesh = generate(gmsh, length, of_vane(dimensions, sectors, length))
        mesh = _half_way(gmsh, mesh, dimensions, sectors)
        mesh = mesh if volume is None else replace(mesh, volume=volume)
        on = [nodes_on(gmsh, mesh, 1, tag) for tag in band_tags + row_tags]
        skin = np.concatenate([nodes_on(gmsh, mesh, 2, tag) for tag in sides])
    part = _part(dimensions, sectors, mesh, on, skin, (bands, left, right, output), steps)
    overlap = overlap or hook_overlap(dimensions, CasingDimensions())
    patches = {
        **hook_averages(part, dimensions.hook, overlap),
        **interlock_averages(part, dimensions),
    }
    return replace(part, patches=patches)


def _part(
    dimensions: VaneDimensions,
    sectors: int,
    mesh: MeshArrays,
    on: list[Integers],
    skin: Integers,
    places: tuple[Floats, ...],
    steps: tuple[int, int],
) -> Part:
    bands, left, right, output = places
    names = ["hook_front roof", "hook_front lip", "hook_rear roof", "hook_rear lip"]
    names += [f"interlock_{side}" for side in ("left", "left", "right", "right")]
    curves = [*bands, *left, *right]
    rows = [
        along(mesh.points, nodes, row, f"vane {name}")
        for name, nodes, row in zip(names, on, curves, strict=True)
    ]
    corners = np.intersect1d(skin, mesh.cells[:, :4])
    tips = nearest(mesh.points, corners, output, "vane output")
    points = place(mesh, np.concatenate([*rows, tips]), np.concatenate([*curves, output]))
    rows = [row[:: steps[0]] for row in rows[:4]] + [row[:: steps[1]] for row in rows[4:]]
    hook = contact_places.hook_frames(contact_places.hook_bands(dimensions.hook, sectors), 1.0)
    interlock = np.repeat(
        contact_places.interlock_frame(dimensions, sectors)[None],
        2 * dimensions.interlock_nodes,
        axis=0,
    )
    part = Part(
        name="vane",
        points=points,
        cells=mesh.cells,
        cell_type="tetra10",
        node_sets={
            "hook_front": np.concatenate(rows[0:2]),
            "hook_rear": np.concatenate(rows[2:4]),
            "key": np.array([row[len(row) // 2] for row in rows[:4]]),
            "interlock_left": np.concatenate(rows[4:6]),
            "interlock_right": np.concatenate(rows[6:8]),
            "output": tips,
        },
        frames={
            "hook_front": np.concatenate(hook[:2]),
            "hook_rear": np.concatenate(hook[2:]),
            "interlock_left": interlock,
            "interlock_right": contact_places.opposite(interlock, sectors),
        },
        sectors=sectors,
        cad_volume=mesh.volume,
    )
    return valid(part)


def _vane_solid(
    gmsh: Any, vane: VaneDimensions, sectors: int
) -> tuple[occ_solids.Entity, float | None]:
    """The segment as one body of the open session.

    And, where aerofoils have fillets, its volume, m³, which the kernel's integration over faces
    that were cut misses by 0.06 %.
    """
    kernel = gmsh.model.occ
    hooks = _hooks(gmsh, vane, sectors)
    shroud = _inner_shroud(gmsh, vane, sectors)
    volume = None
    if vane.root_fillet:
        volume = kernel.getMass(*hooks) + kernel.getMass(*shroud)
        volume += vane.aerofoils * root_fillet.volume(vane)
    blades = aerofoil_solids(gmsh, vane, sectors)
    fused, _ = kernel.fuse([hooks], [shroud, *blades])
    if len(fused) != 1:
        raise InputError(f"vane: shrouds and aerofoils make {len(fused)} bodies instead of one")
    if volume is not None:
        _remove_strays(gmsh, fused[0])
    return fused[0], volume


def _hooks(gmsh: Any, vane: VaneDimensions, sectors: int) -> occ_solids.Entity:
    """Outer shroud with both hooks, revolved from one outline."""
    half = vane.outer_shroud_extent * np.pi / sectors
    return occ_solids.revolve(gmsh, hooks_outline(vane), half)


def _inner_shroud(gmsh: Any, vane: VaneDimensions, sectors: int) -> occ_solids.Entity:
    """A ring piece longer than the pitch, cut by the two slanted interlock planes."""
    kernel = gmsh.model.occ
    inner, outer = vane.inner_shroud_inner_radius, vane.inner_shroud_outer_radius
    front, middle = vane.inner_shroud_front, vane.hook.mid_plane
    half = np.pi / sectors
    lean = abs((middle - front) * np.tan(np.radians(vane.interlock_slant)))
    margin = 1.1 * np.arcsin(lean / inner) + 0.02
    ring = occ_solids.revolve(gmsh, inner_shroud_outline(vane), half + margin)
    # In the frame (normal, radial, across) of a face the waste is a box on its outer side.
    left = contact_places.interlock_frame(vane, sectors)
    deep = 2 * (margin * outer + lean)
    wide = 4 * (lean + middle - front)
    waste = []
    for frame in (left, contact_places.opposite(left, sectors)):
        box = kernel.addBox(0, 0.5 * inner, -0.5 * wide, deep, outer, wide)
        turn = Rotation.from_matrix(frame.T).as_rotvec()
        kernel.rotate([(3, box)], 0, 0, 0, *turn, np.linalg.norm(turn))
        kernel.translate([(3, box)], 0, 0, middle)
        waste.append((3, box))
    cut, _ = kernel.cut([ring], waste)
    if len(cut) != 1:
        raise InputError(f"vane: the interlock planes leave {len(cut)} inner shrouds")
    entity: occ_solids.Entity = cut[0]
    return entity


def _edge(gmsh: Any, row: Floats) -> int:
    """The edge of the solid that ends in the first and last point of an interlock row."""
    ends = row[[0, -1]]
    found = []
    for _, tag in gmsh.model.getEntities(1):
        corners = gmsh.model.getBoundary([(1, tag)], combined=False)
        if len(corners) != 2:
            continue
        positions = np.array([gmsh.model.getValue(0, corner, []) for _, corner in corners])
        if any(np.allclose(positions, order, rtol=0, atol=1e-6) for order in (ends, ends[::-1])):
            found.append(tag)
    if len(found) != 1:
        raise InputError(f"vane: {len(found)} edges of the interlock face instead of one")
    return int(found[0])


def _remove_strays(gmsh: Any, solid: Entity) -> None:
    """Remove what is left of faces that were sewn: all that does not bound the solid."""
    kernel = gmsh.model.occ
    kernel.synchronize()
    bounding = [solid]
    for dimension in (2, 1, 0):
        bounding = gmsh.model.getBoundary(bounding, combined=False, oriented=False)
        bounding = list(dict.fromkeys(bounding))
        kept = set(bounding)
        kernel.remove([each for each in kernel.getEntities(dimension) if each not in kept])
    kernel.synchronize()


def _interlock_pieces(vane: VaneDimensions, size: float) -> int:
    """Mesh nodes from one contact node of an interlock row to the next, see `pieces`."""
    width = 2 * (vane.hook.mid_plane - vane.inner_shroud_front)
    length = width / np.cos(np.radians(vane.interlock_slant))
    return pieces(length, vane.interlock_nodes, size)
