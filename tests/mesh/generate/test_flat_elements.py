"""An element without height goes, and its face keeps its nodes and its rim."""

import numpy as np
import pytest

from vanelock.mesh.generate.mesher import _level
from vanelock.mesh.gmsh_session import session

A, B, C, D, E = range(1, 6)
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def pyramid(gmsh, height, diagonal_held=False):
    """Two tetrahedra under a square, over which a third one lies, whose sides are the face's."""
    model = gmsh.model
    curve = model.addDiscreteEntity(1)
    face, *walls = (model.addDiscreteEntity(2) for _ in range(5))
    body = model.addDiscreteEntity(3)
    places = np.array([*SQUARE, (0.5, 0.5, -1)], float)
    places[[0, 2], 2] = height
    model.mesh.addNodes(3, body, [A, B, C, D, E], places.ravel())
    if diagonal_held:
        model.mesh.addElementsByType(curve, 1, [], [A, C])
    model.mesh.addElementsByType(face, 2, [], [A, B, C, A, C, D])
    for wall, ends in zip(walls, [(A, B), (B, C), (C, D), (D, A)], strict=True):
        model.mesh.addElementsByType(wall, 2, [], [*ends, E])
    model.mesh.addElementsByType(body, 4, [], [A, B, C, D, A, B, D, E, B, C, D, E])
    return face, body


def sets_of(gmsh, kind, count, entity):
    _, nodes = gmsh.model.mesh.getElementsByType(kind, entity)
    return {frozenset(row) for row in np.reshape(nodes, (-1, count)).tolist()}


FLAT = [(A, B, D, E), (B, C, D, E)]


@pytest.mark.parametrize(
    ("height", "held", "counted", "left", "face_left"),
    [
        (1e-9, False, 0, FLAT, [(A, B, D), (B, C, D)]),  # the other diagonal
        (-0.01, False, 1, [*FLAT, (A, B, C, D)], [(A, B, C), (A, C, D)]),
        (1e-9, True, 1, [*FLAT, (A, B, C, D)], [(A, B, C), (A, C, D)]),
        # As on the ridge of a rounded edge: sound.
        (-0.2, False, 0, [*FLAT, (A, B, C, D)], [(A, B, C), (A, C, D)]),
    ],
)
def test_an_element_goes_unless_it_has_height_or_a_curve_runs_along_it(
    height, held, counted, left, face_left
):
    with session("pyramid") as gmsh:
        face, body = pyramid(gmsh, height, held)
        assert _level(gmsh) == counted
        assert sets_of(gmsh, 4, 4, body) == set(map(frozenset, left))
        assert sets_of(gmsh, 2, 3, face) == set(map(frozenset, face_left))
