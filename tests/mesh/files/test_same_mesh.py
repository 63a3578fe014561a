"""The program's own meshes through files of every format: the same sets, frames, frequencies."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from benchmarks.unreduced import unreduced_segment as unreduced
from vanelock import fem
from vanelock.mesh import (
    HookDimensions,
    VaneDimensions,
    casing_sector,
    pair,
    read_mesh,
    vane_segment,
)
from vanelock.mesh.matching.own_part import own_part
from vanelock.stages.parts.segment import Joint


def through_files(folder, small, write_mesh, *endings):
    """Both meshes written, read and paired again."""
    read = []
    for part, ending in zip(small, endings, strict=True):
        path = folder / f"{part.name}{ending}"
        called = write_mesh(path, part)
        read.append(own_part(read_mesh(path, "mm"), part.name, called))
    return pair(*read, small[0].sectors)


@pytest.mark.parametrize(
    ("vane", "casing"),
    [(".bdf", ".inp"), (".gmsh.msh", ".cdb"), (".inp", ".msh")],
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


def test_same_frequencies_from_files(tmp_path, small, write_mesh):
    both = through_files(tmp_path, small, write_mesh, ".bdf", ".inp")
    assert np.abs(frequencies(both.vane, both.casing) / frequencies(*small) - 1).max() < 1e-10


STEEL = fem.Material(E=170e9, nu=0.3, rho=8200)
JOINTS = (
    Joint("hook", kn=1.67e7, kt=0.7e7, mu=0.3, interference=20e-6),
    Joint("interlock", kn=1e6, kt=0.4e6, mu=0.15, interference=2e-6),
)


def frequencies(vane, casing):
    """First six of the joined sector at one nodal diameter, Hz, nothing reduced."""
    models = (fem.assemble(part, STEEL) for part in (vane, casing))
    omega2, _ = fem.eigenpairs(*unreduced(*models, JOINTS, 1), 6)
    return np.sqrt(omega2) / (2 * np.pi)


@pytest.fixture(scope="module")
def small():
    """Vane of one aerofoil and casing."""
    hook = HookDimensions(band_nodes=3)
    dimensions = VaneDimensions(aerofoils=1, root_fillet=0.0, interlock_nodes=3, hook=hook)
    return vane_segment(dimensions, size=0.04), casing_sector(hook=hook, size=0.04)
