"""Volumes, Jacobians and shape functions of cells, areas of their faces, against closed forms."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.mesh.conftest import refusal
from vanelock.mesh import Part, quality
from vanelock.mesh.cells import (
    SOLIDS,
    _jacobians,
    exterior,
    jacobian_bounds,
    nodal_areas,
    solid,
    valid,
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


def test_bounds_are_the_smallest_coefficients_of_the_determinants() -> None:
    """Coefficients that reproduce det J at the 20 points with coordinates in thirds."""
    rng = np.random.default_rng(2)
    points = (NODES + rng.uniform(-0.1, 0.1, size=(300, 10, 3))).reshape(-1, 3)
    cells = np.arange(3000).reshape(300, 10)
    powers = np.array([(i, j, k) for i in range(4) for j in range(4 - i) for k in range(4 - i - j)])
    powers = np.column_stack([powers, 3 - powers.sum(axis=1)])
    factorial = np.array([1, 1, 2, 6])
    places = powers / 3
    basis = 6 / factorial[powers].prod(axis=1) * np.prod(places[:, None] ** powers, axis=2)
    values = np.linalg.det(_jacobians(points, cells, places[:, :3]))
    straight = np.linalg.det(points[cells[:, 1:4]] - points[cells[:, :1]])
    expected = np.linalg.solve(basis, values.T).min(axis=0) / straight
    assert jacobian_bounds(points, cells) == pytest.approx(expected, rel=1e-10, abs=1e-12)
    anywhere = rng.dirichlet(np.ones(4), size=500)[:, 1:]
    sampled = np.linalg.det(_jacobians(points, cells, anywhere)).min(axis=1) / straight
    assert np.all(jacobian_bounds(points, cells) <= sampled)


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
