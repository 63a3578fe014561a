"""The casing: fillets, strut bosses, stretched elements, exact numbers of nodes on cut faces."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from tests.mesh.conftest import refusal, sound
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.mesh import (
    CasingDimensions,
    HookDimensions,
    Part,
    VaneDimensions,
    casing_sector,
    hook_overlap,
    quality,
    vane_segment,
)
from vanelock.mesh.generate import occ_solids
from vanelock.mesh.generate.casing import _add_bosses
from vanelock.mesh.geometry.contact_places import boss_angles
from vanelock.mesh.geometry.revolved import Corner
from vanelock.mesh.gmsh_session import session
from vanelock.mesh.refinement import _casing_plates, check_size

FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])  # of a tetrahedron


WIDE = CasingDimensions(length=0.23, outer_radius=0.6052, flange_thickness=0.0127, rail_front=0.055)


def check_faces(part: Part, wanted: int) -> None:
    """The number of nodes, the match, and that they are corners and middles of triangles' sides."""
    left, right = part.node_sets["left"], part.node_sets["right"]
    assert len(np.unique(left)) == len(np.unique(right)) == wanted
    apart = part.points[left] @ turn(part.sectors).T - part.points[right]
    assert np.abs(apart).max() < 1e-12 * np.hypot(*part.points[left].T[:2]).max()
    triangles = part.cells[:, FACES].reshape(-1, 3)
    triangles = triangles[np.isin(triangles, left).all(axis=1)]
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert len(np.unique(triangles)) + len(np.unique(sides, axis=0)) == wanted


@pytest.mark.parametrize(("size", "wanted", "changes", "sectors"), [
    (0.010, 326, CasingDimensions(), 16), (0.0125, 300, CasingDimensions(), 18),
    (0.0095, 400, WIDE, 12), (0.0125, 301, CasingDimensions(fillet=0.0015), 16),
    (0.0125, 326, CasingDimensions(fillet=0.0015, bosses=2), 16),
])  # fmt: skip
def test_cyclic_faces_have_the_number_of_nodes_asked_for(
    size: float, wanted: int, changes: CasingDimensions, sectors: int
) -> None:
    part = casing_sector(changes, HookDimensions(), sectors, size, face_nodes=wanted)
    check_faces(part, wanted)
    sound(part)


def test_every_number_in_reach_is_found_and_is_the_same_mesh_again() -> None:
    """One of each remainder of division by four, which the boundary's count must answer."""
    parts = [casing_sector(size=0.020, face_nodes=wanted) for wanted in (150, 151, 152, 153, 150)]
    for part, wanted in zip(parts, (150, 151, 152, 153), strict=False):
        check_faces(part, wanted)
    assert np.array_equal(parts[0].points, parts[-1].points)
    assert np.array_equal(parts[0].cells, parts[-1].cells)


@pytest.mark.parametrize(("size", "wanted", "text"), [
    (0.025, 326, r"elements of 25 mm .* has about 1\d\d nodes: allowed are \d+ to 1\d\d; 3"),
    (0.010, 2000, r"elements of 10 mm .* has about 3\d\d nodes: .*; 2000 suits mesh.size = 2."),
    (0.010, 50, r"elements of 10 mm .* has about 3\d\d nodes: .*; with other mesh.size \d\d "),
    (0.050, 50_000, r"elements of 50 mm .*; with other mesh.size \d\d to about 1\d{4}$"),
])  # fmt: skip
def test_numbers_out_of_reach_are_refused_with_the_sizes_that_suit(
    size: str | float, wanted: int, text: str
) -> None:
    with pytest.raises(InputError, match=rf"^mesh\.face_nodes = {wanted}: with {text}") as caught:
        casing_sector(size=size, face_nodes=wanted)
    assert "\n" not in str(caught.value)


def test_the_size_suggested_gives_the_number() -> None:
    with pytest.raises(InputError) as caught:
        casing_sector(size=0.025, face_nodes=326)
    size = 1e-3 * float(str(caught.value).rpartition("mesh.size = ")[2].removesuffix(" mm"))
    check_faces(casing_sector(size=size, face_nodes=326), 326)


SETS = ("hook_front", "hook_rear", "key", "force", "output")


@pytest.fixture(scope="module")
def drawn() -> Part:
    return casing_sector(size=0.02, stretch=3)


def test_named_nodes_and_patches_lie_where_they_do_without(drawn, coarse) -> None:
    _, usual = coarse
    for name in SETS:
        assert np.array_equal(
            drawn.points[drawn.node_sets[name]], usual.points[usual.node_sets[name]]
        )
    for name, frames in usual.frames.items():
        assert np.array_equal(drawn.frames[name], frames)
    for name, weights in usual.patches.items():
        assert np.abs(weights @ usual.points - drawn.patches[name] @ drawn.points).max() < 1e-9


def test_what_is_refused() -> None:
    said = refusal(lambda: casing_sector(size="coarse", stretch=9))
    assert said.startswith("mesh.stretch = 9: must be a whole number from 1 to 8")
    bosses = CasingDimensions(bosses=2)
    said = refusal(lambda: check_size("coarse", None, bosses, 16, HookDimensions(), 2))
    assert said.startswith("mesh.stretch = 2: only 1 is allowed where casing.bosses")


def outside(radius: float, height: float, shell: float) -> float:
    """Volume between a cylinder about z and the end of a radial cylinder, by slices along z."""
    gap = quad(
        lambda s: 2 * np.sqrt(radius**2 - s**2) * (shell + height - np.sqrt(shell**2 - s**2)),
        -radius,
        radius,
        epsabs=1e-15,
    )
    return float(gap[0])


@pytest.mark.parametrize(("count", "changes"), [
    (1, {}), (3, {"boss_height": 0.02}), (2, {"boss_diameter": 0.06, "boss_position": 0.05})
])  # fmt: skip
def test_bosses_add_the_cylinders_outside_the_shell(count: int, changes: dict[str, Any]) -> None:
    casing = CasingDimensions(bosses=count, **changes)
    tube = [
        Corner(radius, z) for radius, z in ((0.600, 0.0), (0.604, 0.0), (0.604, 0.2), (0.600, 0.2))
    ]
    with session("casing") as gmsh:
        shell = occ_solids.revolve(gmsh, tube, np.pi / 16)
        before = gmsh.model.occ.getMass(*shell)
        after = gmsh.model.occ.getMass(*_add_bosses(gmsh, casing, 16, shell))
    assert before == pytest.approx(np.pi * (0.604**2 - 0.600**2) * 0.2 / 16, rel=1e-9)
    each = outside(casing.boss_diameter / 2, casing.boss_height, 0.604)
    # The kernel integrates faces with curved borders to some 1e-5; a flat shell would be 3e-3 off.
    assert after - before == pytest.approx(count * each, rel=1e-4)


def test_bosses_stand_evenly_over_the_whole_ring() -> None:
    angles = boss_angles(CasingDimensions(bosses=3), 16)
    ring = np.concatenate([angles + 2 * np.pi / 16 * k for k in range(16)])
    assert np.diff(ring) == pytest.approx(np.full(47, 2 * np.pi / 48))
    assert angles[1] == 0
    assert len(boss_angles(CasingDimensions(), 16)) == 0


def test_bosses_are_meshed() -> None:
    plain, part = (
        casing_sector(CasingDimensions(bosses=count, boss_height=0.012), size=0.0245, stretch=1)
        for count in (0, 2)
    )
    added = sound(part).volume - quality(plain).volume
    # Sixteen quadratic sides at least: inscribed in the circle, and 5 % below it if straight.
    assert added == pytest.approx(2 * outside(0.0125, 0.012, 0.604), rel=0.12)
    # The tops are planes, 616 mm from the axis at both angles, and hold the cylinders' round edges.
    for angle in np.pi / 16 * np.array([-0.5, 0.5]):
        along = part.points @ [np.cos(angle), np.sin(angle), 0]
        across = part.points @ [-np.sin(angle), np.cos(angle), 0]
        off = np.hypot(across, part.points[:, 2] - 0.035)
        near = off < 0.0125 + 1e-9
        assert along[near].max() == pytest.approx(0.616, abs=1e-9)
        top = np.abs(along - 0.616) < 1e-9
        assert np.sum(top & near & (off > 0.0125 - 1e-9)) >= 8


def test_bosses_are_among_the_plates_of_the_estimate() -> None:
    plates = _casing_plates(CasingDimensions(bosses=3), HookDimensions(), 16)
    area, thickness = plates[-1]
    assert area * thickness == pytest.approx(3 * outside(0.0125, 0.010, 0.604), rel=0.01)


FILLET = 0.0015


@pytest.mark.parametrize("name", ["casing", "vane"])
def test_fillets_fill_their_corners(name: str) -> None:
    """Nodes in the corner's square lie on or behind the arc, which has its own on every piece."""
    part = vane_segment(VaneDimensions(fillet=FILLET, aerofoils=1, root_fillet=0), size=0.025)
    if name == "casing":
        part = casing_sector(CasingDimensions(fillet=FILLET), size=0.025)
    sound(part)
    r, z = np.hypot(*part.points.T[:2]), part.points[:, 2]
    centres = {
        "casing": [(0.600, 0.058, -1, -1), (0.600, 0.082, -1, 1), (0.592, 0.066, -1, 1),
                   (0.584, 0.066, 1, 1)],
        "vane": [(0.573, 0.0885, 1, 1), (0.573, 0.084, 1, -1), (0.584, 0.084, -1, -1)],
    }[name]  # fmt: skip
    both = [*centres, *((radius, 0.2 - at, out, -along) for radius, at, out, along in centres)]
    for radius, at, out, along in both:
        across, deep = out * (r - radius) / FILLET, along * (z - at) / FILLET
        inside = (across > -1e-6) & (deep > -1e-6) & (across < 1 + 1e-6) & (deep < 1 + 1e-6)
        distance = np.hypot(1 - across[inside], 1 - deep[inside])
        assert distance.min() > 0.85  # 0.92 on a chord of 45 degrees, 0.71 on one of 90
        on = np.abs(distance - 1) < 1e-3
        angle = np.degrees(np.arctan2(1 - across[inside][on], 1 - deep[inside][on]))
        for expected in (0, 45, 90):
            assert np.sum(np.abs(angle - expected) < 0.1) > 10, (radius, at, expected)


def test_contact_patches_end_where_the_fillets_begin() -> None:
    """A groove rounded as far as the foot reaches into it, and a foot whose fillet is as large."""
    vane, casing = VaneDimensions(fillet=0.0015), CasingDimensions(fillet=0.003)
    assert hook_overlap(VaneDimensions(), CasingDimensions()) == (0.068, 0.082)
    moved = VaneDimensions(foot_front=0.065, leg_front=0.080)
    assert hook_overlap(moved, CasingDimensions()) == (0.066, 0.080)
    assert hook_overlap(vane, casing) == pytest.approx((0.069, 0.082))
    assert hook_overlap(VaneDimensions(fillet=0.004), casing) == pytest.approx((0.069, 0.080))
    part = casing_sector(casing, size=0.025)
    for name in ("hook_front", "hook_rear"):
        weights = part.patches[name]
        assert weights.shape == (30, len(part.points))
        assert np.abs(weights.sum(axis=1) - 1).max() < 1e-12
        means = weights @ part.points
        at = np.abs(means[:, 2] - 0.1)
        assert at == pytest.approx(np.full(30, 0.1 - 0.0755), abs=1e-12)
