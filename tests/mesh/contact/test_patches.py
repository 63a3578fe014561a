"""Contact patches and the weights of their means against closed forms."""

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.mesh import HookDimensions, Part, VaneDimensions, casing_sector, vane_segment
from vanelock.mesh.contact_patches import hook_patches, interlock_patches
from vanelock.mesh.geometry import contact_places as places

OVERLAP = (0.068, 0.082)  # the foot's front to the groove's mouth
RADII = (0.592, 0.584, 0.592, 0.584)
SETS = ("hook_front", "hook_rear", "interlock_left", "interlock_right")


@pytest.fixture(scope="module")
def vane(coarse: tuple[Part, Part]) -> Part:
    return coarse[0]


@pytest.fixture(scope="module")
def casing() -> Part:
    return casing_sector(size=0.015, stretch=1)  # so that the two parts' faces differ


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


@pytest.mark.parametrize("count", [15, 9, 3])
def test_hook_patches_share_out_the_bands(count: int) -> None:
    pitch = 2 * np.pi / 16
    bands = hook_patches(HookDimensions(band_nodes=count), OVERLAP, 16)
    for radius, band in zip(RADII, bands, strict=True):
        area = np.array([patch.area for patch in band])
        assert len(area) == count
        assert area.sum() == pytest.approx(0.9 * pitch * radius * 0.014, rel=1e-13)
        share = np.concatenate([[0.5], np.ones(count - 2), [0.5]]) / (count - 1)
        assert area == pytest.approx(share * area.sum(), rel=1e-12)


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


def under_arc(radius: float, slope: float, ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Moments of 1, x and y between y = 0 and the arc y² + (slope x)² = radius², end to end."""
    x, y = ends, np.sqrt(radius**2 - (slope * ends) ** 2)
    if slope == 0:
        return np.diff([radius * x, radius * x**2 / 2, radius**2 * x / 2], axis=1)[:, 0]
    sector = radius**2 / slope * np.arcsin(slope * x / radius)
    moments = [
        (x * y + sector) / 2,
        -(y**3) / (3 * slope**2),
        (radius**2 * x - slope**2 * x**3 / 3) / 2,
    ]
    return np.diff(moments, axis=1)[:, 0]


def under_line(ends: NDArray[np.float64], heights: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same for a straight line between two heights."""
    (a, b), (low, high) = ends, heights
    x, y, square = (low + high) / 2, (a * (2 * low + high) + b * (low + 2 * high)) / 6, low * high
    return np.asarray((b - a) * np.array([x, y, (low**2 + square + high**2) / 6]))


@pytest.mark.parametrize(("slant", "nodes"), [(0.0, 5), (35.0, 5), (35.0, 7), (-20.0, 3)])
def test_interlock_patches_reach_from_half_height_to_the_arcs(slant: float, nodes: int) -> None:
    """Area and centroid in closed form, and neighbours that share their sides."""
    vane = VaneDimensions(interlock_slant=slant, interlock_nodes=nodes)
    left, right = interlock_patches(vane, 16)
    _, radial, across = places.interlock_frame(vane, 16)
    along = (places.interlock_rows(vane, 16)[0] - [0, 0, 0.1]) @ across
    count = nodes
    assert len(left) == len(right) == 2 * count
    limits = np.concatenate([along[:1], (along[1:] + along[:-1]) / 2, along[-1:]])
    slope = np.sin(np.radians(slant))
    total = 0.0
    for i in range(count):
        ends = limits[i : i + 2]
        inner, outer = (np.sqrt(r**2 - (slope * ends) ** 2) for r in (0.410, 0.432))
        half = under_line(ends, (inner + outer) / 2)
        for radius, patch in ((0.410, left[i]), (0.432, left[i + count])):
            exact = under_arc(radius, slope, ends) - half
            exact *= np.sign(exact[0])
            total += exact[0]
            assert patch.area == pytest.approx(exact[0], rel=1e-12)
            centre = patch.centroid - [0, 0, 0.1]
            assert centre @ across * exact[0] == pytest.approx(exact[1], rel=1e-11, abs=5e-16)
            assert centre @ radial * exact[0] == pytest.approx(exact[2], rel=1e-11)
            outside = patch.planes[:, :3] @ patch.centroid - patch.planes[:, 3]
            assert np.all(outside < 0)
    ends = along[[0, -1]]
    whole = under_arc(0.432, slope, ends)[0] - under_arc(0.410, slope, ends)[0]
    assert total == pytest.approx(whole, rel=1e-11)
    for a, b in zip(left[:count], left[count:], strict=True):
        assert a.planes[2] == pytest.approx(-b.planes[2], abs=1e-15)
        assert a.planes[:2] == pytest.approx(b.planes[:2], abs=1e-15)
    for a, b in zip(left, right, strict=True):
        assert a.area == b.area
        assert np.hypot(*b.centroid[:2]) == pytest.approx(np.hypot(*a.centroid[:2]), rel=1e-14)
        turned = np.subtract(*(np.arctan2(p.centroid[1], p.centroid[0]) for p in (b, a)))
        assert turned == pytest.approx(2 * np.pi / 16, abs=1e-14)


def test_weights_sum_to_one_at_the_centroid_and_stay_near(vane: Part, casing: Part) -> None:
    """On nodes of the elements beneath, and none so large that another would have to undo it."""
    for part, sets in ((vane, SETS), (casing, SETS[:2])):
        assert set(part.patches) == set(sets)
        for name in sets:
            weights = part.patches[name]
            assert weights.shape == (len(part.node_sets[name]), len(part.points))
            assert np.abs(weights.sum(axis=1) - 1).max() < 1e-14
            centres = weights @ part.points
            assert np.abs(centres - centroids(name)).max() < 1e-14
            assert np.abs(weights).sum(axis=1).max() < 1.5
            for row, centre in zip(weights.toarray(), centres, strict=True):
                assert np.linalg.norm(part.points[row != 0] - centre, axis=1).max() < 0.05


def test_counts_of_contact_nodes_reach_the_parts_patches() -> None:
    hook = HookDimensions(band_nodes=9)
    one = VaneDimensions(aerofoils=1, root_fillet=0, interlock_nodes=7, hook=hook)
    vane = vane_segment(one, size="coarse")
    casing = casing_sector(hook=hook, size="coarse")
    for name in SETS[:2]:
        centres = [part.patches[name] @ part.points for part in (vane, casing)]
        assert len(centres[0]) == 18
        assert np.abs(centres[0] - centres[1]).max() < 1e-14
        nodes = vane.points[vane.node_sets[name]]
        apart = np.linalg.norm(centres[0][:, None] - nodes, axis=2)
        assert np.array_equal(apart.argmin(axis=1), np.arange(18))
    left = vane.patches["interlock_left"] @ vane.points
    nodes = vane.points[vane.node_sets["interlock_left"]]
    assert np.array_equal(
        np.linalg.norm(left[:, None] - nodes, axis=2).argmin(axis=1), np.arange(14)
    )


def test_means_of_quadratic_fields_on_a_cylinder_are_those_of_the_patch(casing: Part) -> None:
    """Of z² about the patch's middle, and of x²."""
    z, x = casing.points[:, 2], casing.points[:, 0]
    for name, centre in (("hook_front", 0.075), ("hook_rear", 0.125)):
        spread = casing.patches[name] @ (z - centre) ** 2
        assert spread == pytest.approx(np.full(30, 0.014**2 / 12), rel=1e-5)
    half = 0.9 * np.pi / 16 / 14
    exact = 0.5 * 0.592**2 * (1 + np.sin(2 * half) / (2 * half))  # mean of (r cos θ)² about θ = 0
    assert (casing.patches["hook_front"] @ x**2)[7] == pytest.approx(exact, rel=1e-8)


def test_a_band_outside_the_overlap_has_no_patches() -> None:
    part = casing_sector(size="coarse", overlap=(0.075, 0.082))
    assert part.patches == {}
