"""Contact patches and the weights of their means against closed forms."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.mesh import (
    CasingDimensions,
    HookDimensions,
    Part,
    VaneDimensions,
    casing_sector,
    hook_overlap,
    vane_segment,
)
from vanelock.mesh.averages import Facets, averages, plane
from vanelock.mesh.patches import Patch, hook_patches, interlock_patches

OVERLAP = (0.068, 0.082)  # the foot's front to the groove's mouth
RADII = (0.592, 0.584, 0.592, 0.584)
SETS = ("hook_front", "hook_rear", "interlock_left", "interlock_right")


@pytest.fixture(scope="module")
def vane() -> Part:
    return vane_segment(size="coarse")


@pytest.fixture(scope="module")
def casing() -> Part:
    return casing_sector(size=0.015)  # so that the two parts' facets differ


def centroids(name: str) -> NDArray[np.float64]:
    bands = hook_patches(HookDimensions(), OVERLAP, 16)
    left, right = interlock_patches(VaneDimensions(), 16)
    patches = {
        "hook_front": bands[0] + bands[1],
        "hook_rear": bands[2] + bands[3],
        "interlock_left": left,
        "interlock_right": right,
    }
    return np.array([patch.centroid for patch in patches[name]])


def test_overlap_is_the_foot_s_front_to_the_groove_s_mouth() -> None:
    assert hook_overlap(VaneDimensions(), CasingDimensions()) == OVERLAP
    moved = VaneDimensions(foot_front=0.065, leg_front=0.080)
    assert hook_overlap(moved, CasingDimensions()) == (0.066, 0.080)


def test_hook_patches_share_out_the_bands() -> None:
    pitch = 2 * np.pi / 16
    for radius, band in zip(RADII, hook_patches(HookDimensions(), OVERLAP, 16), strict=True):
        area = np.array([patch.area for patch in band])
        assert area.sum() == pytest.approx(0.9 * pitch * radius * 0.014, rel=1e-13)
        assert area[1:-1] == pytest.approx(np.full(13, area.sum() / 14), rel=1e-12)
        assert area[[0, -1]] == pytest.approx(np.full(2, area.sum() / 28), rel=1e-12)


def test_hook_centroids_are_those_of_a_cylinder_s_piece() -> None:
    """Means over many points of equal shares of the patch, which its planes accept."""
    for k, band in enumerate(hook_patches(HookDimensions(), OVERLAP, 16)):
        step = 0.9 * 2 * np.pi / 16 / 14
        for i, patch in enumerate(band):
            ends = np.clip((i - 7 + np.array([-0.5, 0.5])) * step, -7 * step, 7 * step)
            angle = ends[0] + (np.arange(2000) + 0.5) / 2000 * np.ptp(ends)
            z = 0.075 if k < 2 else 0.125
            on = RADII[k] * np.array([np.cos(angle), np.sin(angle)])
            assert patch.centroid == pytest.approx([*on.mean(axis=1), z], abs=1e-11)
            for end in (z - 0.007, z + 0.007):
                points = np.column_stack([*on, np.full(2000, end)])
                assert (points @ patch.planes[:, :3].T - patch.planes[:, 3]).max() < 1e-15


@pytest.mark.parametrize("slant", [0.0, 35.0, -20.0])
def test_interlock_patches_share_out_the_face(slant: float) -> None:
    left, right = interlock_patches(VaneDimensions(interlock_slant=slant), 16)
    lean = np.array([-0.03, 0.0, 0.03]) * np.tan(np.radians(slant))
    low, high = (np.sqrt(r**2 - lean**2) for r in (0.410, 0.432))
    length = 0.06 / np.cos(np.radians(slant))
    inner = np.sum([patch.area for patch in left[:5]])
    outer = np.sum([patch.area for patch in left[5:]])
    assert inner + outer == pytest.approx(
        length * np.array([1, 2, 1]) / 4 @ (high - low), rel=1e-12
    )
    # The line at half height cuts the kink off, a triangle over the middle quarter.
    kink = length / 8 * (np.diff((low + high) / 2)[0] / 4)
    half = length * np.array([1, 2, 1]) / 8 @ (high - low)
    assert inner == pytest.approx(half - kink, rel=1e-12)
    # Seen along the face the middle patches are twice as long as those at the ends.
    assert left[6].area / left[5].area == pytest.approx(2, rel=0.04)
    for a, b in zip(left, right, strict=True):
        assert a.area == b.area
        assert np.hypot(*b.centroid[:2]) == pytest.approx(np.hypot(*a.centroid[:2]), rel=1e-14)
        turned = np.subtract(*(np.arctan2(p.centroid[1], p.centroid[0]) for p in (b, a)))
        assert turned == pytest.approx(2 * np.pi / 16, abs=1e-14)


def test_weights_sum_to_one_at_the_centroid(vane: Part, casing: Part) -> None:
    for part, sets in ((vane, SETS), (casing, SETS[:2])):
        assert set(part.patches) == set(sets)
        for name in sets:
            weights = part.patches[name]
            assert weights.shape == (len(part.node_sets[name]), len(part.points))
            assert np.abs(weights.sum(axis=1) - 1).max() < 1e-14
            assert np.abs(weights @ part.points - centroids(name)).max() < 1e-14


def test_both_parts_means_agree_in_rigid_motion(vane: Part, casing: Part) -> None:
    """And in a uniform strain, although the parts' facets differ."""
    rng = np.random.default_rng(1)
    spin = np.cross(np.eye(3), rng.standard_normal(3))
    strain = rng.standard_normal((3, 3))
    for name in SETS[:2]:
        for gradient in (spin, strain):
            means = [p.patches[name] @ (p.points @ gradient + 1.0) for p in (vane, casing)]
            assert np.abs(means[0] - means[1]).max() < 2e-14
    turn = 2 * np.pi / 16
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    left, right = (vane.patches[f"interlock_{side}"] @ vane.points for side in ("left", "right"))
    assert np.abs(left @ R.T - right).max() < 2e-14


def test_weights_stay_near_their_patch(vane: Part, casing: Part) -> None:
    """On nodes of the elements beneath, and none so large that another would have to undo it."""
    for part in (vane, casing):
        for weights in part.patches.values():
            assert np.abs(weights).sum(axis=1).max() < 1.5
            for row, centre in zip(weights.toarray(), weights @ part.points, strict=True):
                touched = part.points[row != 0]
                assert np.linalg.norm(touched - centre, axis=1).max() < 0.05


def test_means_of_quadratic_fields_on_the_plane_are_exact(vane: Part) -> None:
    """Against Gauss points of the trapezia between half height and the edge's chords."""
    frame = vane.frames["interlock_left"][0]
    weights = vane.patches["interlock_left"]
    local = (vane.points - [0, 0, 0.1]) @ frame.T
    nodes, scale = np.polynomial.legendre.leggauss(4)
    rows = local[vane.node_sets["interlock_left"]].reshape(2, 5, 3)
    middle = rows[..., 1].mean(axis=0)  # half height at the nodes
    for i in range(10):
        radius, along = rows[i // 5, :, 1], rows[i // 5, :, 2]
        step = along[1] - along[0]
        ends = [max(along[0], along[i % 5] - step / 2), min(along[4], along[i % 5] + step / 2)]
        cuts = [ends[0], 0.0, ends[1]] if ends[0] < 0 < ends[1] else ends
        moments = np.zeros(4)  # of 1, a^2, a b, b^2
        for start, end in pairwise(cuts):
            a = (start + end) / 2 + (end - start) / 2 * nodes[:, None]
            edge = np.interp(a, along, radius)
            half = np.interp(a, ends, np.interp(ends, along, middle))
            b = (half + edge) / 2 + (edge - half) / 2 * nodes
            w = (end - start) / 2 * scale[:, None] * np.abs(edge - half) / 2 * scale
            moments += [np.sum(w * f) for f in (1 + 0 * b, a**2 + 0 * b, a * b, b**2)]
        field = np.column_stack([local[:, 2] ** 2, local[:, 1] * local[:, 2], local[:, 1] ** 2])
        mean = (weights @ field)[i]
        assert mean == pytest.approx(moments[1:] / moments[0], rel=1e-12, abs=1e-17)


def test_means_of_quadratic_fields_on_a_cylinder_miss_the_facets_only(casing: Part) -> None:
    """z² within what unequal facets do to its spread; a circle's field by the sagitta squared."""
    z, x = casing.points[:, 2], casing.points[:, 0]
    for name, centre in (("hook_front", 0.075), ("hook_rear", 0.125)):
        spread = casing.patches[name] @ (z - centre) ** 2
        assert spread == pytest.approx(np.full(30, 0.014**2 / 12), rel=2e-3)
    half = 0.9 * np.pi / 16 / 14
    exact = 0.5 * 0.592**2 * (1 + np.sin(2 * half) / (2 * half))  # mean of (r cos θ)² about θ = 0
    assert (casing.patches["hook_front"] @ x**2)[7] == pytest.approx(exact, rel=2e-6)


def tetrahedron() -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    corners = np.vstack([np.zeros(3), np.eye(3)])
    edges = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
    return np.vstack([corners, corners[edges].mean(axis=1)]), np.arange(10)[None]


def square(side: float) -> Patch:
    """0 to `side` in x and y."""
    planes = np.array([[-1, 0, 0, 0], [0, -1, 0, 0], [1, 0, 0, side], [0, 1, 0, side]], float)
    return Patch(planes, side**2, np.array([side / 2, side / 2, 0]))


def test_mean_over_a_square_in_one_triangle() -> None:
    points, cells = tetrahedron()
    facets = plane(points, cells, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    weights = averages("one", points, cells, facets, [square(0.4)])
    x, y = points[:, 0], points[:, 1]
    mean = weights @ np.column_stack([x, y, x**2, x * y, y**2])
    assert mean[0] == pytest.approx([0.2, 0.2, 0.16 / 3, 0.04, 0.16 / 3], rel=1e-13)
    assert weights.toarray()[0, [3, 7, 8, 9]] == pytest.approx(np.zeros(4))  # off the plane


def test_a_patch_that_faces_do_not_cover_is_refused() -> None:
    points, cells = tetrahedron()
    facets = plane(points, cells, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    with pytest.raises(InputError, match=r"one: element faces cover 92.0 % of contact patch 1: "):
        # x + y < 1 cuts a corner with legs of 0.25 off the square of 0.625: 2/25 of it.
        averages("one", points, cells, facets, [square(0.5), square(0.625)])
    nothing = Facets(facets.element[:0], facets.corner[:0])
    with pytest.raises(InputError, match=r"one: element faces cover 0.0 % of contact patch 0"):
        averages("one", points, cells, nothing, [square(0.5)])


def test_a_band_outside_the_overlap_has_no_patches() -> None:
    part = casing_sector(size="coarse", overlap=(0.075, 0.082))
    assert part.patches == {}


def test_patches_survive_their_file(tmp_path: Path, casing: Part) -> None:
    casing.save(tmp_path / "casing.h5")
    again = Part.load(tmp_path / "casing.h5")
    assert set(again.patches) == {"hook_front", "hook_rear"}
    for name, weights in casing.patches.items():
        assert np.array_equal(again.patches[name].toarray(), weights.toarray())
