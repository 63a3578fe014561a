"""Cells and contact patches: volumes, Jacobians, areas and means against closed forms."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.mesh.conftest import refusal
from vanelock.common.errors import InputError
from vanelock.mesh import HookDimensions, Part, casing_sector, quality
from vanelock.mesh import contact_patches as module
from vanelock.mesh.cells import (
    SOLIDS,
    _jacobians,
    exterior,
    jacobian_bounds,
    nodal_areas,
    solid,
    valid,
)
from vanelock.mesh.contact_patches import (
    _averages,
    _cylinder,
    _Facets,
    _Patch,
    _plane,
    hook_patches,
)
from vanelock.mesh.gmsh_session import session

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])


INVERTED = "one: an element is inverted"


NODES = np.concatenate([CORNERS, CORNERS[EDGES].mean(axis=1)])


def one(points: NDArray[np.float64], cell_type: str = "tetra") -> Part:
    return Part("one", points, np.arange(len(points))[None], cell_type, {}, {}, 1)


def test_regular_tetrahedron_is_perfect_and_a_flat_one_worthless_and_refused() -> None:
    points = np.array([[1.0, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]])
    figures = quality(one(points))
    assert figures.smallest_sicn == pytest.approx(1, rel=1e-14)
    assert figures.volume == pytest.approx(8 / 3, rel=1e-14)
    assert figures.smallest_jacobian == pytest.approx(1, rel=1e-14)
    assert quality(one(points[[1, 0, 2, 3]])).smallest_sicn == pytest.approx(-1, rel=1e-14)
    assert quality(one(CORNERS * [1, 1, 0])).smallest_sicn == 0
    for wrong in (CORNERS * [1, 1, 0], CORNERS[[1, 0, 2, 3]]):
        assert refusal(lambda wrong=wrong: valid(one(wrong))).startswith(INVERTED)
    assert valid(one(CORNERS)).name == "one"
    wedge = one(np.zeros((6, 3)), "wedge")
    assert refusal(lambda: quality(wedge)) == "one: quality needs tetrahedra, not wedge"


def test_quality_equals_gmsh_s_own() -> None:
    rng = np.random.default_rng(1)
    points = CORNERS + rng.uniform(-0.3, 0.3, size=(200, 4, 3))
    with session("random") as gmsh:
        tag = gmsh.model.addDiscreteEntity(3)
        nodes = np.arange(1, 801)
        gmsh.model.mesh.addNodes(3, tag, nodes, points.ravel())
        gmsh.model.mesh.addElementsByType(tag, 4, np.arange(1, 201), nodes)
        expected = gmsh.model.mesh.getElementQualities(np.arange(1, 201), "minSICN")
        volumes = gmsh.model.mesh.getElementQualities(np.arange(1, 201), "volume")
    figures = [quality(one(each)) for each in points]
    assert [f.smallest_sicn for f in figures] == pytest.approx(expected, rel=1e-9)
    assert [f.volume for f in figures] == pytest.approx(np.abs(volumes), rel=1e-9)


def test_curved_element_s_volume_is_exact() -> None:
    """The map x = ξ(1 + aη), y = η(1 + bζ), z = ζ(1 + cξ): its determinant is a cubic."""
    a, b, c = 0.3, -0.2, 0.4
    xi, eta, zeta = NODES.T
    points = np.stack([xi * (1 + a * eta), eta * (1 + b * zeta), zeta * (1 + c * xi)], axis=1)
    # det = (1 + aη)(1 + bζ)(1 + cξ) + abcξηζ; mean values over the tetrahedron 1/24, 1/120, 1/720.
    exact = 1 / 6 + (a + b + c) / 24 + (a * b + b * c + c * a) / 120 + 2 * a * b * c / 720
    figures = quality(one(points, "tetra10"))
    assert figures.volume == pytest.approx(exact, rel=1e-13)
    determinants = (1 + a * eta) * (1 + b * zeta) * (1 + c * xi) + a * b * c * xi * eta * zeta
    assert figures.smallest_jacobian == pytest.approx(determinants.min(), rel=1e-13)  # at (0, 0, 1)


def test_an_element_inverted_between_its_nodes_is_found_and_refused() -> None:
    """The map x = ξ(1 - aξ/2), y = η(1 - bξ): det = (1 - aξ)(1 - bξ), negative for 0.7 < ξ < 0.8.

    Its Bézier coefficients are 1, 1 - (a + b)/2, (1 - a)(1 - b) as a quadratic in ξ.
    """
    a, b = 1 / 0.8, 1 / 0.7
    xi, eta, zeta = NODES.T
    points = np.stack([xi * (1 - a * xi / 2), eta * (1 - b * xi), zeta], axis=1)
    part = one(points, "tetra10")
    assert np.linalg.det(_jacobians(points, part.cells, NODES)).min() > 0.1
    cubic = (2 * (1 - (a + b) / 2) + (1 - a) * (1 - b)) / 3
    bound = jacobian_bounds(points, part.cells)
    assert bound == pytest.approx([cubic / (1 - a / 2)], rel=1e-13)
    assert refusal(lambda: valid(part)).startswith(f"{INVERTED} (Jacobian -0.51 of a")


def round_face(p):
    angle = 0.4 * p[:, 1]
    r = 0.9 + 0.1 * p[:, 0]
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.2 * p[:, 2]])


@pytest.mark.parametrize("cell_type", SOLIDS)
def test_areas_add_up(lattice, cell_type):
    """A piece of a cylinder of radius 1 m, 0.4 rad by 0.2 m; linear elements have its chords."""
    part = lattice((1, 4, 3), round_face, cell_type, curved=True)
    nodes = part.node_sets["x1"]
    normal = part.points[nodes] * [1, 1, 0]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    faces = exterior(part.cells, solid(cell_type))
    found = nodal_areas(part.points, faces, nodes, normal)
    assert found is not None
    linear = cell_type in ("tetra", "hexahedron")
    length = 8 * np.sin(0.05) if linear else 0.4
    assert found.sum() == pytest.approx(0.2 * length, rel=1e-13 if linear else 2e-7)
    assert found.min() > 0
    assert nodal_areas(part.points, faces, nodes, -normal) is None
    assert nodal_areas(part.points, faces, nodes[:3], normal[:3]) is None


def test_shares_of_a_face(lattice):
    """One flat square: quarters at corners; 3/76 and 16/76; and Simpson's rule (Hinton et al.)."""
    shares = {"hexahedron": [1 / 4], "hexahedron20": [3 / 76, 16 / 76]}
    shares["hexahedron27"] = [1 / 36, 4 / 36, 16 / 36]
    for cell_type, wanted in shares.items():
        part = lattice((1, 1, 1), lambda p: p, cell_type)
        nodes = part.node_sets["x1"]
        normal = np.tile([1.0, 0, 0], (len(nodes), 1))
        found = nodal_areas(part.points, exterior(part.cells, solid(cell_type)), nodes, normal)
        assert found is not None
        assert np.unique(np.round(found, 12)) == pytest.approx(wanted, rel=1e-11)


OVERLAP = (0.068, 0.082)  # the foot's front to the groove's mouth


RADII = (0.592, 0.584, 0.592, 0.584)


SETS = ("hook_front", "hook_rear", "interlock_left", "interlock_right")


@pytest.fixture(scope="module")
def vane(coarse: tuple[Part, Part]) -> Part:
    return coarse[0]


@pytest.fixture(scope="module")
def casing() -> Part:
    return casing_sector(size=0.015, stretch=1)  # so that the two parts' faces differ


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
