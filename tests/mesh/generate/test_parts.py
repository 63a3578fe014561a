"""Vane and casing against closed forms: volumes, areas, topology, node sets, frames."""

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.common.cyclic import rotation
from vanelock.mesh import (
    Part,
    VaneDimensions,
    casing_sector,
    vane_segment,
)

THREE = {"aerofoils": 3, "chord": 0.054, "thickness": 0.0048, "root_fillet": 0.0}
DESIGNS = {
    "scene": (16, {}),
    "45 deg, one aerofoil": (16, {"interlock_slant": 45.0, "aerofoils": 1}),
    "three aerofoils, straight": (18, {**THREE, "interlock_slant": 0.0}),
}
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])  # normals outwards
OPPOSED = np.array([-1.0, 1.0, -1.0])[:, None]


Both = tuple[Part, VaneDimensions, Part]


@pytest.fixture(scope="module", params=DESIGNS)
def both(request: pytest.FixtureRequest, coarse: tuple[Part, Part]) -> Both:
    """A coarse vane, its dimensions and its casing."""
    sectors, changes = DESIGNS[request.param]
    dimensions = VaneDimensions(**changes)
    vane = vane_segment(dimensions, sectors, "coarse") if changes else coarse[0]
    return vane, dimensions, coarse_casing(sectors)


@cache
def coarse_casing(sectors: int) -> Part:
    return casing_sector(sectors=sectors, size=0.025, stretch=1)


def boundary(part: Part) -> NDArray[np.int64]:
    """Corners (t, 3) of the triangles that belong to one element only."""
    triangles = part.cells[:, FACES].reshape(-1, 3)
    _, index, count = np.unique(
        np.sort(triangles, axis=1), axis=0, return_index=True, return_counts=True
    )
    assert count.max() == 2  # an inner triangle has an element on either side
    return np.asarray(triangles[index[count == 1]])


def vector_areas(part: Part, triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    a, b, c = np.moveaxis(part.points[triangles], 1, 0)
    return np.asarray(0.5 * np.cross(b - a, c - a))


def within(triangles: NDArray[np.int64], nodes: NDArray[np.int64]) -> NDArray[np.int64]:
    return triangles[np.isin(triangles, nodes).all(axis=1)]


def test_masses_a_sector_are_the_scene_s(coarse: tuple[Part, Part]) -> None:
    # The scene's aerofoils were a little shorter: their thickness stood on the chord.
    sharp = vane_segment(VaneDimensions(root_fillet=0.0), size="coarse")
    for part, mass, within in ((sharp, 4.17, 0.025), (coarse[1], 3.90, 0.005)):
        assert part.cad_volume is not None
        assert 8200 * part.cad_volume == pytest.approx(mass, abs=within)


def test_hook_nodes_of_both_parts_coincide_on_the_bands(both: Both) -> None:
    """Keys are the middles of the bands."""
    vane, _, casing = both
    half = 0.9 * np.pi / vane.sectors
    for name, z in (("hook_front", 0.074), ("hook_rear", 0.126)):
        mine = vane.points[vane.node_sets[name]]
        assert np.abs(mine - casing.points[casing.node_sets[name]]).max() < 1e-12
        x, y, _ = np.moveaxis(mine.reshape(2, 15, 3), -1, 0)
        radii = np.array([[0.592], [0.584]]).repeat(15, axis=1)
        assert np.hypot(x, y) == pytest.approx(radii, rel=1e-14)
        angles = np.tile(np.linspace(-half, half, 15), (2, 1))
        assert np.arctan2(y, x) == pytest.approx(angles, abs=1e-14)
        assert np.abs(mine[:, 2] - z).max() < 1e-15
    for part in (vane, casing):
        sets = part.node_sets
        middle = [sets[name][i] for name in ("hook_front", "hook_rear") for i in (7, 22)]
        assert sets["key"].tolist() == middle


def test_hook_frames_point_out_of_the_mesh(both: Both) -> None:
    """Normal, around, axial; at the middle of a band the surface's own normal is that of them."""
    hooks = {"hook_front", "hook_rear"}
    assert set(both[2].frames) == hooks
    assert set(both[0].frames) == hooks | {"interlock_left", "interlock_right"}
    for part, sign in zip(both[::2], (1.0, -1.0), strict=True):
        triangles = boundary(part)
        for name in hooks:
            nodes, outward = part.node_sets[name], np.repeat([sign, -sign], 15)
            radial = part.points[nodes] * [1, 1, 0]
            radial /= np.linalg.norm(radial, axis=1)[:, None]
            axial = outward[:, None] * [0, 0, 1]
            around = np.cross([0, 0, 1], radial)
            frames = np.stack([outward[:, None] * radial, around, axial], axis=1)
            assert part.frames[name] == pytest.approx(frames, abs=1e-14)
            for i in (6, 21):  # a corner of each band, away from its ends
                near = triangles[(triangles == nodes[i]).any(axis=1)]
                area = vector_areas(part, near).sum(axis=0)
                assert frames[i, 0] @ area / np.linalg.norm(area) > 0.99


def test_interlock_nodes_lie_on_the_slanted_plane(both: Both) -> None:
    """The right ones are the left ones of the next sector, frames included."""
    part, dimensions, _ = both
    turn = rotation(2 * np.pi / part.sectors)
    left, right = (part.points[part.node_sets[f"interlock_{side}"]] for side in ("left", "right"))
    assert np.abs(left @ turn.T - right).max() < 1e-12
    mated = part.frames["interlock_left"] @ turn.T * OPPOSED
    assert part.frames["interlock_right"] == pytest.approx(mated, abs=1e-15)
    angle, slant = -np.pi / part.sectors, np.radians(dimensions.interlock_slant)
    radial = np.array([np.cos(angle), np.sin(angle), 0])
    around = np.array([-np.sin(angle), np.cos(angle), 0])
    across = np.sin(slant) * around + np.cos(slant) * np.array([0, 0, 1])
    nodes = left.reshape(2, 5, 3)
    offset = nodes - np.array([0, 0, 0.100])
    assert np.abs(offset @ np.cross(radial, across)).max() < 1e-15
    assert nodes[..., 2] == pytest.approx(np.tile(np.linspace(0.07, 0.13, 5), (2, 1)), abs=1e-15)
    radius = np.hypot(nodes[..., 0], nodes[..., 1])
    assert radius == pytest.approx(np.array([[0.410], [0.432]]).repeat(5, axis=1), rel=1e-14)
    for side in ("left", "right"):
        assert np.abs(np.diff(part.frames[f"interlock_{side}"], axis=0)).max() == 0


def test_interlock_frames_are_the_face_s_own(both: Both) -> None:
    """The surface's triangles in that plane have the frame's normal, and the face's area."""
    part, dimensions, _ = both
    slant, triangles = np.radians(dimensions.interlock_slant), boundary(part)
    for side, sign in (("left", 1), ("right", -1)):
        normal, radial, across = part.frames[f"interlock_{side}"][0]
        origin = part.points[part.node_sets[f"interlock_{side}"][0]]
        near = np.abs((part.points[triangles] - origin) @ normal).max(axis=1) < 1e-9
        area = vector_areas(part, triangles[near]).sum(axis=0)
        assert np.linalg.norm(area) == pytest.approx(area @ normal, rel=1e-9)
        lean = np.linspace(-0.03, 0.03, 2001) * np.tan(slant)
        height = np.sqrt(0.432**2 - lean**2) - np.sqrt(0.410**2 - lean**2)
        # The triangles' corners cut off what lies between the edges' arcs and their chords.
        assert area @ normal == pytest.approx(0.06 / np.cos(slant) * height.mean(), rel=2e-3)
        assert radial[2] == 0
        assert across[2] == pytest.approx(sign * np.cos(slant), abs=1e-14)


def test_cyclic_faces_have_the_section_s_area_and_the_same_triangles(both: Both) -> None:
    casing = both[2]
    left, right = casing.node_sets["left"], casing.node_sets["right"]
    normal = np.array([-np.sin(np.pi / casing.sectors), -np.cos(np.pi / casing.sectors), 0])
    triangles = boundary(casing)
    # Shell 4 x 200, two flanges 21 x 10, two rails 24 x 22 less a groove 16 x 8, in mm.
    section = 1e-6 * (4 * 200 + 2 * 21 * 10 + 2 * (24 * 22 - 16 * 8))
    for nodes, outward in ((left, normal), (right, normal * [1, -1, 1])):
        area = vector_areas(casing, within(triangles, nodes)).sum(axis=0)
        assert area == pytest.approx(section * outward, abs=1e-15)
    mate = dict(zip(left.tolist(), right.tolist(), strict=True))
    turned = {frozenset(mate[n] for n in t) for t in within(triangles, left).tolist()}
    assert turned == {frozenset(t) for t in within(triangles, right).tolist()}


def test_fixed_and_force_nodes(both: Both) -> None:
    """Both end faces are covered; forces are even around the whole ring."""
    casing = both[2]
    z = casing.points[:, 2]
    fixed = casing.node_sets["fixed"]
    assert np.array_equal(np.sort(fixed), np.flatnonzero((z < 1e-12) | (z > 0.2 - 1e-12)))
    points = casing.points[casing.node_sets["force"]]
    assert np.hypot(points[:, 0], points[:, 1]) == pytest.approx(np.full(16, 0.604), rel=1e-14)
    assert points[:, 2] == pytest.approx(np.full(16, 0.1), abs=1e-15)
    angle = np.arctan2(points[:, 1], points[:, 0])
    step = 2 * np.pi / casing.sectors / 16
    assert np.diff(angle) == pytest.approx(np.full(15, step), abs=1e-14)
    assert angle[0] + 2 * np.pi / casing.sectors - angle[-1] == pytest.approx(step, abs=1e-14)
