"""Mesh figures against closed forms and against gmsh's own."""

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.mesh import Part, quality
from vanelock.mesh.kernel import session
from vanelock.mesh.tetrahedra import valid

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])


def one(points: NDArray[np.float64], cell_type: str = "tetra") -> Part:
    return Part("one", points, np.arange(len(points))[None], cell_type, {}, {}, 1)


def test_regular_tetrahedron_is_perfect() -> None:
    points = np.array([[1.0, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]])
    figures = quality(one(points))
    assert figures.smallest_sicn == pytest.approx(1, rel=1e-14)
    assert figures.volume == pytest.approx(8 / 3, rel=1e-14)
    assert figures.smallest_jacobian == pytest.approx(16, rel=1e-14)
    assert quality(one(points[[1, 0, 2, 3]])).smallest_sicn == pytest.approx(-1, rel=1e-14)


def test_flat_tetrahedron_is_worthless_and_refused() -> None:
    part = one(CORNERS * [1, 1, 0])
    assert quality(part).smallest_sicn == 0
    with pytest.raises(InputError, match="^one: an element is inverted"):
        valid(part)
    with pytest.raises(InputError, match="^one: an element is inverted"):
        valid(one(CORNERS[[1, 0, 2, 3]]))
    assert valid(one(CORNERS)).name == "one"


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
    reference = np.concatenate([CORNERS, CORNERS[EDGES].mean(axis=1)])
    xi, eta, zeta = reference.T
    points = np.stack([xi * (1 + a * eta), eta * (1 + b * zeta), zeta * (1 + c * xi)], axis=1)
    # det = (1 + aη)(1 + bζ)(1 + cξ) + abcξηζ; mean values over the tetrahedron 1/24, 1/120, 1/720.
    exact = 1 / 6 + (a + b + c) / 24 + (a * b + b * c + c * a) / 120 + 2 * a * b * c / 720
    figures = quality(one(points, "tetra10"))
    assert figures.volume == pytest.approx(exact, rel=1e-13)
    determinants = (1 + a * eta) * (1 + b * zeta) * (1 + c * xi) + a * b * c * xi * eta * zeta
    assert figures.smallest_jacobian == pytest.approx(determinants.min(), rel=1e-13)


def test_other_elements_are_refused() -> None:
    with pytest.raises(InputError, match="^one: quality needs tetrahedra, not wedge$"):
        quality(one(np.zeros((6, 3)), "wedge"))
