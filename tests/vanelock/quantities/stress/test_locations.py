"""Places of nodes in words, sharp corners, and the contacts' areas."""

import numpy as np
import pytest

from vanelock import mesh, parse_study
from vanelock.mesh import VaneDimensions
from vanelock.mesh.geometry.aerofoil import output_points
from vanelock.quantities.stress.locations import _reentrant_edges, _within, locations_of
from vanelock.stages.parts.outputs import _places_on


@pytest.fixture(scope="module")
def study():
    return parse_study('[vane]\nroot_fillet = 0\n[mesh]\nsize = "coarse"')


@pytest.fixture(scope="module")
def vane(study):
    return mesh.vane_segment(study.vane, size="coarse")


@pytest.fixture(scope="module")
def found(study, vane):
    return locations_of(study, vane)


def test_bent_bar_has_the_edge_inside_its_bend_and_a_cube_none(lattice):
    assert len(_reentrant_edges(lattice((2, 2, 2)))) == 0
    part = lattice((4, 2, 4), place=lambda p: p * [2, 1, 2], cell_type="hexahedron")
    middle = part.points[part.cells].mean(axis=1)
    kept = ~((middle[:, 0] > 1) & (middle[:, 2] > 1))
    edges = _reentrant_edges(type(part)(**{**vars(part), "cells": part.cells[kept]}))
    assert edges[..., [0, 2]] == pytest.approx(1.0)
    assert np.abs(np.diff(edges[..., 1], axis=1)).sum() == pytest.approx(1.0)


def test_sharp_corners_are_where_the_drawing_has_them_and_fillets_leave_only_the_roots(vane):
    edges = _reentrant_edges(vane)
    radius = np.unique(np.hypot(*edges[..., :2].reshape(-1, 2).T).round(4))
    # Roots of the aerofoils, and the leg's corners at the shroud and the foot.
    assert radius.tolist() == [0.432, 0.567, 0.573, 0.584]
    dimensions = VaneDimensions(fillet=0.002, root_fillet=0.0)
    edges = _reentrant_edges(mesh.vane_segment(dimensions, size="coarse"))
    radius = np.hypot(*edges[..., :2].reshape(-1, 2).T)
    assert radius.max() < 0.568


def test_fillets_of_hooks_and_roots_leave_none(study):
    """The roots are judged: their nodes belong to an aerofoil, and none lies beside a corner."""
    dimensions = VaneDimensions(fillet=0.002, root_fillet=0.0025, lean=4.0, twist=6.0, aerofoils=2)
    part = mesh.vane_segment(dimensions, size="coarse")
    assert len(_reentrant_edges(part)) == 0
    found = locations_of(study.model_copy(update={"vane": dimensions}), part)
    assert not found.corner.any()
    radius = np.hypot(*part.points[:, :2].T)
    fillet = (radius > 0.4321) & (radius < 0.434) | (radius > 0.565) & (radius < 0.5669)
    assert fillet.sum() > 500
    assert all(name.startswith("aerofoil") for name in found.feature[fillet])
    words = {found.words(int(node)).split(",")[1] for node in np.flatnonzero(fillet)}
    assert words == {" root at the inner shroud", " root at the outer shroud"}


def test_distance_is_to_the_segment_and_not_to_its_ends():
    edges = np.array([[[0.0, 0, 0], [10, 0, 0]]])
    points = np.array([[5.0, 1, 0], [5, 1.01, 0], [-0.6, 0.8, 0], [10.8, 0.7, 0]])
    assert _within(points, edges, 1.0 + 1e-12).tolist() == [True, False, True, False]


def test_output_nodes_are_named_as_they_were_placed(study, vane, found):
    # By construction at mid-chord of the suction side of the middle aerofoil, at quarters.
    nodes = vane.node_sets["output"]
    placed = output_points(study.vane, 16)
    for node, point, share in zip(nodes, placed, (25, 50, 75), strict=True):
        assert vane.points[node] == pytest.approx(point)
        place = found.words(int(node))
        assert place == f"aerofoil 2, {share} % of the span, suction side, 50 % of the chord"


def test_features_are_where_the_dimensions_put_them(vane, found):
    x, y, z = vane.points.T
    radius = np.hypot(x, y)
    assert set(found.feature[radius < 0.4319]) == {"inner shroud"}
    assert set(found.feature[(radius > 0.5671) & (radius < 0.5729)]) == {"outer shroud"}
    legs = (radius > 0.5731) & (radius < 0.5839)
    assert set(found.feature[legs & (z < 0.1)]) == {"front hook, leg"}
    assert set(found.feature[legs & (z > 0.1)]) == {"rear hook, leg"}
    between = (radius > 0.4325) & (radius < 0.5665)
    assert set(found.feature[between]) == {f"aerofoil {k}" for k in (1, 2, 3, 4)}
    angle = np.degrees(np.arctan2(y, x))[between]
    means = [angle[found.feature[between] == f"aerofoil {k}"].mean() for k in (1, 2, 3, 4)]
    assert means == sorted(means)


def test_root_is_described_with_its_end_and_its_doubt(vane, found):
    radius = np.hypot(*vane.points[:, :2].T)
    aerofoil = np.char.startswith(found.feature, "aerofoil")
    root = np.flatnonzero(found.corner & aerofoil & (np.abs(radius - 0.567) < 1e-6))
    assert len(root) > 40
    place = [found.words(int(node)) for node in root]
    assert all("root at the outer shroud" in each for each in place)
    assert all("sharp" in found.doubt(int(node)) for node in root)
    assert not found.clear[root].any()


def test_contact_nodes_carry_point_forces(vane, found):
    assert found.loaded[vane.node_sets["hook_front"]].all()
    assert found.loaded[vane.node_sets["interlock_left"]].all()


def test_areas_tile_the_contact_faces(study, vane):
    at = _places_on(study, vane)
    joint = np.array(at.joint)
    assert at.names[0] == "front hook 1"
    assert at.names[-1] == "interlock 10"
    # Hooks: arcs of 0.9 pitch at r 592 and 584, axially where foot and leg front leave room,
    # z 68 to 82 mm; less the areas of the four tied nodes, one at each band's end or middle.
    whole = 2 * 0.9 * 2 * np.pi / 16 * (0.592 + 0.584) * 0.014
    share = at.area[joint == "hook"].sum() / whole
    assert share == pytest.approx(1 - 4 / (4 * 14), abs=0.03)
    # Interlock: height 22 mm, length 60 mm over the cosine of the slant.
    face = 0.022 * 0.060 / np.cos(np.radians(35))
    assert at.area[joint == "interlock"].sum() == pytest.approx(face, rel=0.01)
    assert np.isnan(at.coefficient).all()
