"""A sector of a plain ring made by hand: what the render tests draw where no mesh is needed."""

from collections.abc import Callable
from itertools import permutations

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.mesh import Part
from vanelock.render import style

Build = Callable[..., Part]


def block_sector(
    name: str = "casing",
    inner: float = 0.5,
    outer: float = 0.6,
    length: float = 0.1,
    sectors: int = 8,
    divisions: tuple[int, int, int] = (2, 4, 2),
) -> Part:
    """Annular sector of straight-sided quadratic tetrahedra, six to a block."""
    nr, nt, nz = divisions
    r = np.linspace(inner, outer, nr + 1)
    t = np.linspace(0, 2 * np.pi / sectors, nt + 1)
    z = np.linspace(0, length, nz + 1)
    R, T, Z = np.meshgrid(r, t, z, indexing="ij")
    points = np.column_stack([(R * np.cos(T)).ravel(), (R * np.sin(T)).ravel(), Z.ravel()])
    number = np.arange(R.size).reshape(R.shape)
    tetrahedra = []
    for order in permutations(range(3)):  # one for each path along the block's edges
        corner = [0, 0, 0]
        path = [tuple(corner)]
        for axis in order:
            corner[axis] = 1
            path.append(tuple(corner))
        four = [number[i : nr + i, j : nt + j, k : nz + k].ravel() for i, j, k in path]
        even = np.linalg.det(np.eye(3)[list(order)]) > 0
        tetrahedra.append(np.column_stack(four if even else [four[0], four[2], four[1], four[3]]))
    points, cells = quadratic(points, np.concatenate(tetrahedra))
    angle = np.arctan2(points[:, 1], points[:, 0])
    radius = np.hypot(points[:, 0], points[:, 1])
    left = np.flatnonzero(np.isclose(angle, 0))
    right = np.flatnonzero(np.isclose(angle, 2 * np.pi / sectors))
    left = left[np.lexsort((points[left, 2], radius[left].round(9)))]
    right = right[np.lexsort((points[right, 2], radius[right].round(9)))]
    sets = {
        "left": left,
        "right": right,
        "fixed": np.flatnonzero(np.isclose(points[:, 2], 0)),
        "hook_front": np.flatnonzero(np.isclose(radius, inner) & np.isclose(points[:, 2], length)),
        "output": np.array([0]),
    }
    return Part(name, points, cells, "tetra10", sets, {}, sectors)


def quadratic(
    points: NDArray[np.float64], cells: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Put a node in the middle of each edge of linear tetrahedra."""
    pairs = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
    edges = np.sort(np.stack([cells[:, pair] for pair in map(list, pairs)], axis=1), axis=2)
    unique, which = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    middle = points[unique].mean(axis=1)
    return np.vstack([points, middle]), np.hstack([cells, len(points) + which.reshape(-1, 6)])


def radial_wave(part: Part, nodal_diameter: int, amplitude: float) -> NDArray[np.complex128]:
    """(m, 3) u_r = a e^{-i ND θ}."""
    angle = np.arctan2(part.points[:, 1], part.points[:, 0])
    radial = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    found: NDArray[np.complex128] = (
        amplitude * radial * np.exp(-1j * nodal_diameter * angle)[:, None]
    )
    return found


@pytest.fixture(scope="session")
def sector() -> Build:
    return block_sector


@pytest.fixture
def bars(monkeypatch):
    """Lower end, upper end and label of each colour bar as it stands in its figure."""
    found = []
    draw = style.colour_bar

    def noted(axes, *given):
        bar = draw(axes, *given)
        found.append((*axes.get_ylim(), axes.get_ylabel()))
        return bar

    monkeypatch.setattr(style, "colour_bar", noted)
    return found


@pytest.fixture
def figures(monkeypatch):
    """Figures that would be written."""
    kept = []
    monkeypatch.setattr(style, "write", lambda figure, path: kept.append(figure))
    return kept
