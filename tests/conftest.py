"""Small structured meshes built without a mesher, and the scene of the vane."""

import os
from collections.abc import Callable
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest

from vanelock import fem, mesh, rom
from vanelock.mesh import Part
from vanelock.rom.joining import joined_dofs

Place = Callable[[np.ndarray], np.ndarray]

# The six tetrahedra of a box (Kuhn): paths along the axes from its lowest to its highest corner.
# Neighbouring boxes, and the two faces of a mapped sector, are cut along the same diagonals.
_PATHS = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]
_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
_HEXA = np.array(
    [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]]
)
_HEXA_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
_HEXA_EDGES += [(0, 4), (1, 5), (2, 6), (3, 7)]
_HEXA_REST = np.array([[0, 1, 1], [2, 1, 1], [1, 0, 1], [1, 2, 1], [1, 1, 0], [1, 1, 2], [1, 1, 1]])


def _tetrahedra() -> np.ndarray:
    """(6, 10, 3) nodes of a box's tetrahedra in half steps, positively oriented."""
    cells = []
    for path in _PATHS:
        corners = [np.zeros(3, int)]
        for axis in path:
            corners.append(corners[-1] + 2 * np.eye(3, dtype=int)[axis])
        if np.linalg.det(np.diff(corners, axis=0)) < 0:
            corners[1], corners[2] = corners[2], corners[1]
        cells.append(corners + [(corners[a] + corners[b]) // 2 for a, b in _EDGES])
    return np.array(cells)


def _hexahedron() -> np.ndarray:
    middles = [(_HEXA[a] + _HEXA[b]) // 2 for a, b in _HEXA_EDGES]
    return np.vstack([_HEXA, middles, _HEXA_REST])[None]


_NODES = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron20": 20, "hexahedron27": 27}


@pytest.fixture(scope="session")
def lattice() -> Callable[..., Part]:
    """Function that meshes the unit cube, mapped by `place`, with `counts` boxes a side.

    Its parts have the node sets x0, x1, y0, y1, z0, z1: the faces of the unit cube, each in the
    order of the other two coordinates. Straight-sided unless `curved`.
    """

    def build(
        counts: tuple[int, int, int],
        place: Place = lambda p: p,
        cell_type: str = "tetra10",
        curved: bool = False,
        sectors: int = 1,
    ) -> Part:
        tetra = cell_type.startswith("tetra")
        local = (_tetrahedra() if tetra else _hexahedron())[:, : _NODES[cell_type]]
        boxes = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), -1).reshape(-1, 3)
        index = 2 * boxes[:, None, None] + local  # (boxes, cells, nodes, 3)
        index = index.reshape(-1, *local.shape[1:])
        used, cells = np.unique(index.reshape(-1, 3), axis=0, return_inverse=True)
        cells = cells.reshape(index.shape[:2])
        steps = used / (2 * np.array(counts))
        points = place(steps)
        if not curved:
            if tetra:
                for m, (a, b) in enumerate(_EDGES[: cells.shape[1] - 4]):
                    points[cells[:, 4 + m]] = (points[cells[:, a]] + points[cells[:, b]]) / 2
            else:  # a straight-sided hexahedron is the trilinear image of its corners
                r = (local[0] / 2)[:, None]
                corner = np.prod(np.where(_HEXA / 2 == 1, r, 1 - r), axis=2)
                points[cells] = np.einsum("ac,eci->eai", corner, points[cells[:, :8]])
        sets = {
            f"{axis}{side}": np.flatnonzero(used[:, i] == side * 2 * counts[i])
            for i, axis in enumerate("xyz")
            for side in (0, 1)
        }
        return Part(cell_type, points, cells, cell_type, sets, {}, sectors)

    return build


JOINTS = (
    rom.Joint("hook", kn=1.67e7, kt=1.67e7, mu=0.3, interference=20e-6),
    rom.Joint("interlock", kn=1e6, kt=1e6, mu=0.15, interference=2e-6),
)
VANE_MASTERS = (
    "hook_front",
    "hook_rear",
    "interlock_left",
    "interlock_right",
    "key",
    "accessory",
)
CASING_MASTERS = ("hook_front", "hook_rear", "key", "force", "accessory")


@pytest.fixture(scope="session")
def scene():
    """Models, components and system of the scene: coarse, or medium at full count."""
    size = "medium" if os.environ.get("VANELOCK_VERIFY") == "full" else "coarse"
    steel = fem.Material(E=170e9, nu=0.3, rho=8200)
    vane_model = fem.assemble(mesh.vane_segment(size=size), steel)
    casing_model = fem.assemble(mesh.casing_sector(size=size), steel)
    vane = rom.reduce(vane_model, VANE_MASTERS)
    casing = rom.reduce(
        casing_model, CASING_MASTERS, nodal_diameters=[0, 1, 2, 3, 8], band=vane.band
    )
    system = rom.join(vane, casing, JOINTS, rom.Excitation(1, force=30.0), damping_ratio=0.003)

    @lru_cache
    def truth(k, interlock):
        """Six frequencies, Hz, and vectors of the unreduced sector."""
        joints = JOINTS if interlock == "closed" else JOINTS[:1]
        omega2, vectors = fem.eigenpairs(*rom.unreduced(vane_model, casing_model, joints, k), 6)
        return np.sqrt(omega2) / (2 * np.pi), vectors

    return SimpleNamespace(
        truth=truth,
        vane_model=vane_model,
        casing_model=casing_model,
        vane=vane,
        casing=casing,
        system=system,
        joints=JOINTS,
        joined_dofs=joined_dofs(vane, casing),
        interlock=np.array([name == "interlock" for name in system.contacts.joint]),
    )
