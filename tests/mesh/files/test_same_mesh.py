"""The program's own meshes through files of every format: the same sets, frames and frequencies."""

import numpy as np
import pytest

from vanelock import fem, rom
from vanelock.mesh import pair, read_mesh
from vanelock.mesh.matching.own_part import own_part


@pytest.mark.parametrize(
    ("vane", "casing"),
    [(".bdf", ".inp"), (".gmsh.msh", ".bdf"), (".inp", ".msh"), (".cdb", ".cdb")],
)
def test_same_frequencies_from_files(tmp_path, coarse, reference, write_mesh, vane, casing):
    """The scene's own meshes through files: sets, frames, and ten frequencies at ND 1."""
    read = []
    for part, ending in zip(coarse, (vane, casing), strict=True):
        path = tmp_path / f"{part.name}{ending}"
        called = write_mesh(path, part)
        read.append(own_part(read_mesh(path, "mm"), part.name, called))
    both = pair(*read, coarse[0].sectors)
    for made, found in zip(coarse, (both.vane, both.casing), strict=True):
        for name, nodes in made.node_sets.items():
            own, other = made.points[nodes], found.points[found.node_sets[name]]
            place = np.linalg.norm(own[:, None] - other, axis=2)
            assert place.min(axis=1).max() < 1e-13
            assert len(own) == len(other)
            if name in made.frames:
                ordered = found.frames[name][place.argmin(axis=1)]
                assert np.abs(ordered - made.frames[name]).max() < 1e-9
    assert np.abs(frequencies(both.vane, both.casing) / reference - 1).max() < 1e-10


STEEL = fem.Material(E=170e9, nu=0.3, rho=8200)
JOINTS = (
    rom.Joint("hook", kn=1.67e7, kt=0.7e7, mu=0.3, interference=20e-6),
    rom.Joint("interlock", kn=1e6, kt=0.4e6, mu=0.15, interference=2e-6),
)


def frequencies(vane, casing):
    """First ten of the joined sector at one nodal diameter, Hz, nothing reduced."""
    models = (fem.assemble(part, STEEL) for part in (vane, casing))
    omega2, _ = fem.eigenpairs(*rom.unreduced(*models, JOINTS, 1), 10)
    return np.sqrt(omega2) / (2 * np.pi)


@pytest.fixture(scope="module")
def reference(coarse):
    """Those of the program's own meshes."""
    return frequencies(*coarse)
