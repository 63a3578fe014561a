"""Small structured meshes, built without a mesher: a lattice of boxes mapped into space."""

from collections.abc import Callable

import numpy as np
import pytest

from vanelock.mesh import Part

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
