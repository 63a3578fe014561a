"""Means over faces of straight and curved elements against closed forms."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.mesh import Part, VaneDimensions
from vanelock.mesh import contact_patches as module
from vanelock.mesh.contact_patches import (
    _averages,
    _cylinder,
    _Facets,
    _Patch,
    _plane,
    interlock_patches,
)
from vanelock.mesh.geometry import contact_places

Lattice = Callable[..., Part]
Points = NDArray[np.float64]

RADIUS = 0.592
ENDS = np.radians([-6.3, 7.1])
FRONT, REAR = 0.067, 0.083


def tetrahedron() -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    corners = np.vstack([np.zeros(3), np.eye(3)])
    edges = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
    return np.vstack([corners, corners[edges].mean(axis=1)]), np.arange(10)[None]


def square(side: float) -> _Patch:
    """0 to `side` in x and y."""
    planes = np.array([[-1, 0, 0, 0], [0, -1, 0, 0], [1, 0, 0, side], [0, 1, 0, side]], float)
    return _Patch(planes, side**2, np.array([side / 2, side / 2, 0]))


def test_mean_over_a_square_in_one_triangle() -> None:
    points, cells = tetrahedron()
    facets = _plane(points, cells, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    weights = _averages("one", points, cells, facets, [square(0.4)])
    x, y = points[:, 0], points[:, 1]
    mean = weights @ np.column_stack([x, y, x**2, x * y, y**2])
    assert mean[0] == pytest.approx([0.2, 0.2, 0.16 / 3, 0.04, 0.16 / 3], rel=1e-13)
    assert weights.toarray()[0, [3, 7, 8, 9]] == pytest.approx(np.zeros(4))  # off the plane


def test_a_patch_that_faces_do_not_cover_is_refused() -> None:
    points, cells = tetrahedron()
    facets = _plane(points, cells, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    with pytest.raises(InputError, match=r"one: element faces cover 92.0 % of contact patch 1: "):
        # x + y < 1 cuts a corner with legs of 0.25 off the square of 0.625: 2/25 of it.
        _averages("one", points, cells, facets, [square(0.5), square(0.625)])
    nothing = _Facets(facets.element[:0], facets.corner[:0])
    with pytest.raises(InputError, match=r"one: element faces cover 0.0 % of contact patch 0"):
        _averages("one", points, cells, nothing, [square(0.5)])


def ring(lattice: Lattice, count: int, wave: float, curved: bool = True) -> Part:
    """A piece of a ring inside the cylinder of the front roof; its elements' sides wave on it."""

    def place(p: Points) -> Points:
        x, y, depth = p.T
        angle = np.radians(22) * (y - 0.47 + wave * np.sin(2 * np.pi * x) * np.sin(np.pi * y))
        z = 0.060 + 0.031 * (x + wave * np.sin(np.pi * x) * np.sin(2 * np.pi * y))
        r = RADIUS - 0.012 * depth
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])

    return lattice((count, 2 * count, 1), place, curved=curved)


def over_ring(part: Part, patch: _Patch) -> NDArray[np.float64]:
    """Weights (n,)."""
    facets = _cylinder(part.points, part.cells, RADIUS)
    return np.asarray(_averages("ring", part.points, part.cells, facets, [patch]).toarray()[0])


def middle_patch() -> _Patch:
    """A piece of the cylinder that no element's side bounds."""
    (s, t), (c, d) = np.sin(ENDS), np.cos(ENDS)
    planes = [[s, -c, 0, 0], [-t, d, 0, 0], [0, 0, -1, -FRONT], [0, 0, 1, REAR]]
    width = np.ptp(ENDS)
    centroid = np.array([RADIUS * (t - s) / width, RADIUS * (c - d) / width, (FRONT + REAR) / 2])
    return _Patch(np.array(planes), RADIUS * width * (REAR - FRONT), centroid)


def test_curved_faces_have_the_patch_s_area_and_centroid(
    lattice: Lattice, monkeypatch: pytest.MonkeyPatch
) -> None:
    """5.6° of arc to an element: straight-sided ones miss the patch by 9e-5."""
    monkeypatch.setattr(module, "_COVERED", 4e-6)
    part = ring(lattice, 4, 0.0)
    assert over_ring(part, middle_patch()) @ part.points == pytest.approx(middle_patch().centroid)
    monkeypatch.setattr(module, "_COVERED", 8e-5)
    with pytest.raises(InputError, match="ring: element faces cover 100.0 %"):
        over_ring(ring(lattice, 4, 0.0, curved=False), middle_patch())


def test_means_over_curved_faces_converge(lattice: Lattice) -> None:
    """Those of cos 4θ, z² and their product: in third order and better.

    Elements whose sides wave on the cylinder are cut as if their pieces' sides did not: second.
    """
    half = (REAR - FRONT) / 2
    exact = np.array([np.ptp(np.sin(4 * ENDS)) / (4 * np.ptp(ENDS)), 1 / 3])

    def errors(part: Part) -> NDArray[np.float64]:
        angle = np.arctan2(part.points[:, 1], part.points[:, 0])
        square = ((part.points[:, 2] - (FRONT + REAR) / 2) / half) ** 2
        fields = np.column_stack([np.cos(4 * angle), square, np.cos(4 * angle) * square])
        found = over_ring(part, middle_patch()) @ fields
        return np.asarray(np.abs(found - [*exact, exact.prod()]))

    coarse, fine = (errors(ring(lattice, count, 0.0)) for count in (4, 12))
    assert fine == pytest.approx(np.zeros(3), abs=4e-6)
    assert np.all(coarse / fine > 3**3)
    coarse, fine = (errors(ring(lattice, count, 0.03)) for count in (4, 12))
    assert fine == pytest.approx(np.zeros(3), abs=1e-4)
    assert coarse.max() / fine.max() > 3**2


def test_means_over_a_plane_face_reach_to_its_arcs(lattice: Lattice) -> None:
    """Against Gauss points between half height and the true arcs of a steep interlock face."""
    vane = VaneDimensions(interlock_slant=50.0)
    frame, slope = contact_places.interlock_frame(vane, 16), np.sin(np.radians(50.0))
    origin = np.array([0.0, 0.0, 0.1])
    along = (contact_places.interlock_rows(vane, 16)[0] - origin) @ frame[2]
    limits = np.concatenate([along[:1], (along[1:] + along[:-1]) / 2, along[-1:]])

    def arcs(x: Points) -> Points:
        squares = np.array([0.410, 0.432])[:, None] ** 2 - (slope * x) ** 2
        return np.asarray(np.sqrt(squares))

    def place(p: Points) -> Points:
        x = along[0] + np.ptp(along) * p[:, 0]
        low, high = arcs(x)
        local = np.column_stack([-0.01 * p[:, 2], low + (high - low) * p[:, 1], x])
        return np.asarray(origin + local @ frame)

    def fields(x: Points, y: Points) -> Points:
        y = y - 0.42
        return np.stack([x**2, x * y, y**2], axis=-1)

    nodes, scale = np.polynomial.legendre.leggauss(12)
    exact = []
    for side in (0, 1):
        for ends in pairwise(limits):
            x = (ends[0] + ends[1]) / 2 + np.ptp(ends) / 2 * nodes
            half = np.interp(x, ends, arcs(np.array(ends)).mean(axis=0))
            edge = arcs(x)[side]
            y = (half + edge)[:, None] / 2 + (edge - half)[:, None] / 2 * nodes
            weight = np.outer(scale * np.abs(edge - half), scale)
            at = fields(np.broadcast_to(x[:, None], y.shape), y)
            exact.append(np.einsum("ab,abk->k", weight, at) / weight.sum())
    left = interlock_patches(vane, 16)[0]
    errors = []
    for count in (1, 2, 4):
        part = lattice((3 * count, count, 1), place, curved=True)
        facets = _plane(part.points, part.cells, origin, frame[0])
        weights = _averages("face", part.points, part.cells, facets, left)
        assert weights @ part.points == pytest.approx(np.array([p.centroid for p in left]))
        local = (part.points - origin) @ frame.T
        error = np.abs(weights @ fields(local[:, 2], local[:, 1]) - exact)
        errors.append(error.max(axis=0))
    assert np.all(errors[0] < 1e-6)  # of 1.8e-4 m² for y², the least of them
    assert np.all(errors[0] / errors[2] > 4**2.5)
