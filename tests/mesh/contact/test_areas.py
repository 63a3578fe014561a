"""Areas of the nodes of contact faces: their sum, their sign, and simple shapes."""

import numpy as np
import pytest

from vanelock.mesh.cells import SOLIDS, exterior, nodal_areas, solid


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
