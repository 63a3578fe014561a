"""A ring of which one sector of the vane's and the casing's mesh is written and read back."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.refusals import refused
from vanelock.common.errors import InputError
from vanelock.mesh import quality, read_mesh
from vanelock.mesh.matching.side import own_part

SECTORS = 12
RADIUS = 1.0


def complaints(build):
    """Lines with which an input is refused."""
    with pytest.raises(InputError) as caught:
        build()
    return str(caught.value).splitlines()


def refusal(build):
    """The same of one line."""
    return refused(".", build)


def sound(part):
    """Figures of a mesh, none of whose elements is bad."""
    figures = quality(part)
    assert figures.smallest_jacobian > 0
    assert figures.smallest_sicn > 0.02
    return figures


def ring_sectors(lattice):
    """Function that meshes a sector: the vane's inside the casing's, which meet at a cylinder."""

    def build(name, cell_type="tetra10", counts=(1, 3, 4), sectors=SECTORS):
        inner = {"vane": RADIUS - 0.1, "casing": RADIUS}[name]

        def place(p):
            r, angle = inner + 0.1 * p[:, 0], 2 * np.pi / sectors * (p[:, 1] - 0.5)
            return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.2 * p[:, 2]])

        part = lattice(counts, place, cell_type, curved=True, sectors=sectors)
        sets = part.node_sets
        edge = np.concatenate([sets[side] for side in ("y0", "y1", "z0", "z1")])
        contact = np.setdiff1d(sets["x1" if name == "vane" else "x0"], edge)
        front = part.points[contact, 2] < 0.099
        away = np.setdiff1d(sets["x0" if name == "vane" else "x1"], edge)
        found = {
            "hook_front": contact[front],
            "hook_rear": contact[~front],
            "key": np.array([contact[front][0], contact[~front][-1]]),
            "output": away[:2],
        }
        if name == "vane":
            found |= {"interlock_left": sets["y0"], "interlock_right": sets["y1"]}
        else:
            found |= {
                "left": sets["y0"],
                "right": sets["y1"],
                "fixed": sets["z0"],
                "force": away[2:],
            }
        return replace(part, name=name, node_sets=found)

    return build


@pytest.fixture
def ring(lattice):
    """As `ring_sectors`."""
    return ring_sectors(lattice)


@pytest.fixture
def given(tmp_path, ring, write_mesh):
    """Function that writes both sectors, changed as asked for, and reads them as a user's."""

    def build(cell_type="tetra10", ending=".vtu", change=None, only=("vane", "casing")):
        found = SimpleNamespace()
        for name in ("vane", "casing"):
            part = ring(name, cell_type)
            setattr(found, f"made_{name}", part)
            if change is not None:
                part = change(part)
            path = tmp_path / f"{name}{ending}"
            called = write_mesh(path, part)
            setattr(
                found, name, lambda p=path, n=name, c=called: own_part(read_mesh(p, "mm"), n, c)
            )
        return found

    return build
