"""The casing sector: shell, two end flanges, two rails whose grooves hold the vane's feet."""

from dataclasses import replace

import numpy as np

from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.mesh.checks.dimensions import check_casing
from vanelock.mesh.checks.fillets import check_resolved
from vanelock.mesh.checks.tetrahedra import valid
from vanelock.mesh.contact.patch_means import hook_averages
from vanelock.mesh.contact.patches import hook_overlap
from vanelock.mesh.generate import occ_solids
from vanelock.mesh.generate.bosses import add_bosses, check_meshable, divide_bosses
from vanelock.mesh.generate.cyclic_face import divide_face
from vanelock.mesh.generate.extract import along, generate, matching, nodes_on, place
from vanelock.mesh.generate.stretch import checked_stretch, drawn_out
from vanelock.mesh.geometry import contact_places
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.geometry.element_size import element_size
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
            add_bosses(gmsh, dimensions, narrow, occ_solids.revolve(gmsh, outline, np.pi / narrow)),
            [occ_solids.arc(gmsh, band[0], band[-1]) for band in bands],
            [occ_solids.point(gmsh, position) for position in np.concatenate([force, output])],
        )
        left_tag, right_tag = occ_solids.end_faces(gmsh, np.pi / narrow)
        for tag in band_tags:
            gmsh.model.mesh.setTransfiniteCurve(tag, bands.shape[1] // 2 + 1)
        occ_solids.grade_fillets(gmsh, dimensions.fillet, length, stretch)
        divide_bosses(gmsh, dimensions, length)
        affine = np.eye(4)
        affine[:3, :3] = turn(narrow)
        gmsh.model.mesh.setPeriodic(2, [right_tag], [left_tag], affine.ravel().tolist())
        if face_nodes is not None:
            divide_face(gmsh, left_tag, length, face_nodes)
        mesh = generate(gmsh, length, None, stretch, face_nodes is not None)
        on = [nodes_on(gmsh, mesh, 1, tag) for tag in band_tags]
        at = np.concatenate([nodes_on(gmsh, mesh, 0, tag) for tag in point_tags])
        left, right = (nodes_on(gmsh, mesh, 2, tag) for tag in (left_tag, right_tag))
        fixed = np.unique(
            np.concatenate(
                [
                    nodes_on(gmsh, mesh, 2, tag)
                    for z in (0.0, dimensions.length)
                    for tag in occ_solids.faces_at(gmsh, z)
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
        frames={
            "hook_front": np.concatenate(frames[:2]),
            "hook_rear": np.concatenate(frames[2:]),
        },
        sectors=sectors,
        cad_volume=stretch * mesh.volume,
    )
    overlap = overlap or hook_overlap(VaneDimensions(), dimensions)
    return replace(valid(part), patches=hook_averages(part, hook, overlap))
