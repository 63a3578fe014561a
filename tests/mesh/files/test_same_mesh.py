"""The program's own meshes through files of every format: the same sets, frames."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vanelock.mesh import (
    HookDimensions,
    VaneDimensions,
    casing_sector,
    pair,
    read_mesh,
    vane_segment,
)
from vanelock.mesh.matching.side import own_part


def through_files(folder, small, write_mesh, *endings):
    """Both meshes written, read and paired again."""
    read = []
    for part, ending in zip(small, endings, strict=True):
        path = folder / f"{part.name}{ending}"
        called = write_mesh(path, part)
        read.append(own_part(read_mesh(path, "mm"), part.name, called))
    return pair(*read, small[0].sectors)


@pytest.mark.parametrize(
    ("vane", "casing"), [(".bdf", ".inp"), (".gmsh.msh", ".cdb"), (".inp", ".msh")]
)
def test_elements_sets_and_frames_come_back(tmp_path, small, write_mesh, vane, casing):
    both = through_files(tmp_path, small, write_mesh, vane, casing)
    for made, found in zip(small, (both.vane, both.casing), strict=True):
        apart, same = cKDTree(made.points).query(found.points)
        assert apart.max() < 1e-13
        own, other = (np.sort(cells, axis=1) for cells in (made.cells, same[found.cells]))
        np.testing.assert_array_equal(own[np.lexsort(own.T)], other[np.lexsort(other.T)])
        for name, nodes in made.node_sets.items():
            own, other = made.points[nodes], found.points[found.node_sets[name]]
            place = np.linalg.norm(own[:, None] - other, axis=2)
            assert place.min(axis=1).max() < 1e-13
            assert len(own) == len(other)
            if name in made.frames:
                ordered = found.frames[name][place.argmin(axis=1)]
                assert np.abs(ordered - made.frames[name]).max() < 1e-9


@pytest.fixture(scope="module")
def small():
    """Vane of one aerofoil and casing."""
    hook = HookDimensions(band_nodes=3)
    dimensions = VaneDimensions(aerofoils=1, root_fillet=0.0, interlock_nodes=3, hook=hook)
    return vane_segment(dimensions, size=0.04), casing_sector(hook=hook, size=0.04)
