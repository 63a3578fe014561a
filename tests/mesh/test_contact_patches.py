"""Contact patches and the weights of their means against closed forms."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.mesh import HookDimensions, Part, VaneDimensions, casing_sector
from vanelock.mesh import contact_patches as module
from vanelock.mesh.contact_patches import (
    _averages,
    _cylinder,
    _Facets,
    _Patch,
    _plane,
    hook_patches,
    interlock_patches,
)
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
    points, weights = np.polynomial.legendre.leggauss(30)

    def arcs(x: NDArray[np.float64]) -> NDArray[np.float64]:
        squares = np.array([[0.410], [0.432]]) ** 2 - (np.sin(np.radians(slant)) * x) ** 2
        return np.asarray(np.sqrt(squares))

    for i, ends in enumerate(pairwise(limits)):
        x = np.mean(ends) + np.ptp(ends) / 2 * points
        half = np.interp(x, ends, arcs(np.array(ends)).mean(axis=0))
        for arc, patch in zip(arcs(x), (left[i], left[i + count]), strict=True):
            share = weights * np.abs(arc - half) * np.ptp(ends) / 2
            assert patch.area == pytest.approx(share.sum(), rel=1e-12)
            centre = patch.centroid - [0, 0, 0.1]
            assert centre @ across == pytest.approx(share @ x / share.sum(), rel=1e-11, abs=1e-13)
            middle = share @ (arc + half) / 2 / share.sum()
            assert centre @ radial == pytest.approx(middle, rel=1e-11)
            outside = patch.planes[:, :3] @ patch.centroid - patch.planes[:, 3]
            assert np.all(outside < 0)
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
            nodes = part.points[part.node_sets[name]]  # in their order
            apart = np.linalg.norm(centres[:, None] - nodes, axis=2)
            assert np.array_equal(apart.argmin(axis=1), np.arange(len(nodes)))
            for row, centre in zip(weights.toarray(), centres, strict=True):
                assert np.linalg.norm(part.points[row != 0] - centre, axis=1).max() < 0.05


def test_a_band_outside_the_overlap_has_no_patches() -> None:
    part = casing_sector(size="coarse", overlap=(0.075, 0.082))
    assert part.patches == {}


Lattice = Callable[..., Part]


Points = NDArray[np.float64]


RADIUS = 0.592


ENDS = np.radians([-6.3, 7.1])


FRONT, REAR = 0.067, 0.083


def tetrahedron() -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    corners = np.vstack([np.zeros(3), np.eye(3)])
    edges = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
    return np.vstack([corners, corners[edges].mean(axis=1)]), np.arange(10)[None]


def square(side: float) -> _Patch:
    """0 to `side` in x and y."""
    planes = np.array([[-1, 0, 0, 0], [0, -1, 0, 0], [1, 0, 0, side], [0, 1, 0, side]], float)
    return _Patch(planes, side**2, np.array([side / 2, side / 2, 0]))


def test_mean_over_a_square_in_one_triangle() -> None:
    points, cells = tetrahedron()
    facets = _plane(points, cells, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    weights = _averages("one", points, cells, facets, [square(0.4)])
    x, y = points[:, 0], points[:, 1]
    mean = weights @ np.column_stack([x, y, x**2, x * y, y**2])
    assert mean[0] == pytest.approx([0.2, 0.2, 0.16 / 3, 0.04, 0.16 / 3], rel=1e-13)
    assert weights.toarray()[0, [3, 7, 8, 9]] == pytest.approx(np.zeros(4))  # off the plane


def test_a_patch_that_faces_do_not_cover_is_refused() -> None:
    points, cells = tetrahedron()
    facets = _plane(points, cells, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    with pytest.raises(InputError, match=r"one: element faces cover 92.0 % of contact patch 1: "):
        # x + y < 1 cuts a corner with legs of 0.25 off the square of 0.625: 2/25 of it.
        _averages("one", points, cells, facets, [square(0.5), square(0.625)])
    nothing = _Facets(facets.element[:0], facets.corner[:0])
    with pytest.raises(InputError, match=r"one: element faces cover 0.0 % of contact patch 0"):
        _averages("one", points, cells, nothing, [square(0.5)])


def ring(lattice: Lattice, count: int, wave: float, curved: bool = True) -> Part:
    """A piece of a ring inside the cylinder of the front roof; its elements' sides wave on it."""

    def place(p: Points) -> Points:
        x, y, depth = p.T
        angle = np.radians(22) * (y - 0.47 + wave * np.sin(2 * np.pi * x) * np.sin(np.pi * y))
        z = 0.060 + 0.031 * (x + wave * np.sin(np.pi * x) * np.sin(2 * np.pi * y))
        r = RADIUS - 0.012 * depth
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])

    return lattice((count, 2 * count, 1), place, curved=curved)


def over_ring(part: Part, patch: _Patch) -> NDArray[np.float64]:
    """Weights (n,)."""
    facets = _cylinder(part.points, part.cells, RADIUS)
    return np.asarray(_averages("ring", part.points, part.cells, facets, [patch]).toarray()[0])


def middle_patch() -> _Patch:
    """A piece of the cylinder that no element's side bounds."""
    (s, t), (c, d) = np.sin(ENDS), np.cos(ENDS)
    planes = [[s, -c, 0, 0], [-t, d, 0, 0], [0, 0, -1, -FRONT], [0, 0, 1, REAR]]
    width = np.ptp(ENDS)
    centroid = np.array([RADIUS * (t - s) / width, RADIUS * (c - d) / width, (FRONT + REAR) / 2])
    return _Patch(np.array(planes), RADIUS * width * (REAR - FRONT), centroid)


def test_curved_faces_have_the_patch_s_area_and_centroid(
    lattice: Lattice, monkeypatch: pytest.MonkeyPatch
) -> None:
    """5.6° of arc to an element: straight-sided ones miss the patch by 9e-5."""
    monkeypatch.setattr(module, "_COVERED", 4e-6)
    part = ring(lattice, 4, 0.0)
    assert over_ring(part, middle_patch()) @ part.points == pytest.approx(middle_patch().centroid)
    monkeypatch.setattr(module, "_COVERED", 8e-5)
    with pytest.raises(InputError, match="ring: element faces cover 100.0 %"):
        over_ring(ring(lattice, 4, 0.0, curved=False), middle_patch())


def test_means_over_curved_faces_converge(lattice: Lattice) -> None:
    """Those of cos 4θ, z² and their product: in third order and better.

    Elements whose sides wave on the cylinder are cut as if their pieces' sides did not: second.
    """
    half = (REAR - FRONT) / 2
    exact = np.array([np.ptp(np.sin(4 * ENDS)) / (4 * np.ptp(ENDS)), 1 / 3])

    def errors(part: Part) -> NDArray[np.float64]:
        angle = np.arctan2(part.points[:, 1], part.points[:, 0])
        square = ((part.points[:, 2] - (FRONT + REAR) / 2) / half) ** 2
        fields = np.column_stack([np.cos(4 * angle), square, np.cos(4 * angle) * square])
        found = over_ring(part, middle_patch()) @ fields
        return np.asarray(np.abs(found - [*exact, exact.prod()]))

    coarse, fine = (errors(ring(lattice, count, 0.0)) for count in (4, 12))
    assert fine == pytest.approx(np.zeros(3), abs=4e-6)
    assert np.all(coarse / fine > 3**3)
    coarse, fine = (errors(ring(lattice, count, 0.03)) for count in (4, 12))
    assert fine == pytest.approx(np.zeros(3), abs=1e-4)
    assert coarse.max() / fine.max() > 3**2
