"""The meridional section of a mesh."""

import numpy as np
import pytest

from vanelock.render.shapes.meshes import meridional_section


def area(polygon):
    x, y = polygon.T
    return abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def pipe(p):
    """Unit cube to an eighth of a pipe of 1 to 2 m, 3 m long."""
    r, a = 1 + p[:, 0], np.pi / 4 * p[:, 1]
    return np.column_stack([r * np.cos(a), r * np.sin(a), 3 * p[:, 2]])


@pytest.mark.parametrize("cell_type", ["tetra", "tetra10", "hexahedron", "hexahedron20"])
def test_a_rectangle_is_covered_once(lattice, cell_type):
    part = lattice((2, 3, 2), pipe, cell_type, curved=True)
    pieces, edges = meridional_section(part, 0.3)
    # Of straight elements the section lies inside the arc by their sagitta at most.
    linear = cell_type in ("tetra", "hexahedron", "hexahedron20")
    sagitta = 1 - np.cos(np.pi / 24)
    tolerance = 2 * sagitta if linear else 2 * (1 - np.cos(np.pi / 48))
    assert sum(map(area, pieces)) == pytest.approx(3, rel=tolerance)
    every = np.concatenate(pieces)
    np.testing.assert_allclose(every.min(axis=0), [0, 1], atol=tolerance)
    np.testing.assert_allclose(every.max(axis=0), [3, 2], atol=2 * tolerance)
    # The outline's edges belong to one element, all others to two.
    length = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    on_axis = np.isclose(edges[:, :, 0], 0).all(axis=1) | np.isclose(edges[:, :, 0], 3).all(axis=1)
    assert length[on_axis].sum() == pytest.approx(2, rel=2 * tolerance)


def test_a_plane_beside_the_part_cuts_nothing(lattice):
    pieces, edges = meridional_section(lattice((1, 1, 1), pipe), -0.5)
    assert (len(pieces), len(edges)) == (0, 0)
