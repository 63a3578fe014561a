"""A bent cube to write and read back, and what is said of a file that cannot be read."""

import numpy as np
import pytest

from tests.mesh.conftest import refusal
from vanelock.mesh import read_mesh

GRIDS = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"


def bent(p):
    """The unit cube as a curved piece of a ring, so that no two of its sides are alike."""
    r, angle = 0.5 + 0.1 * p[:, 0], 0.4 * p[:, 1]
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.2 * p[:, 2] + 0.02 * p[:, 1]])


@pytest.fixture
def ring(lattice):
    """Function that meshes it."""
    return lambda cell_type="tetra10", counts=(2, 2, 2): lattice(
        counts, bent, cell_type, curved=True
    )


def complaint(path, unit="m"):
    """The line with which a file is refused, the folder left out."""
    line = refusal(lambda: read_mesh(path, unit))
    assert str(path) in line
    return line.replace(str(path), path.name)


def same(part, found, called, within):
    """The same nodes, elements and sets, whatever nodes and sets are called."""
    own, other = (np.lexsort(np.round(points, 9).T) for points in (part.points, found.points))
    assert np.abs(part.points[own] - found.points[other]).max() < within
    rank, known = np.argsort(own), np.argsort(other)
    wanted = {tuple(row) for row in rank[part.cells].tolist()}
    assert {tuple(row) for row in known[found.cells].tolist()} == wanted
    read = {name.casefold(): nodes for name, nodes in found.node_sets.items()}
    for name, nodes in part.node_sets.items():
        assert sorted(known[read[called.get(name, name)]].tolist()) == sorted(rank[nodes].tolist())
