"""Which of several meshes is kept, and which elements go."""

import numpy as np
import pytest

from vanelock.mesh import CasingDimensions, VaneDimensions, casing_sector, quality, vane_segment
from vanelock.mesh.generate import mesher
from vanelock.mesh.generate.mesher import _level
from vanelock.mesh.gmsh_session import session

ALL = [(finer, split) for split in (False, True) for finer in (1.0, 0.98, 0.96, 0.93, 0.9, 0.86)]


@pytest.mark.parametrize(
    ("qualities", "expected"),
    [
        ([0.2], [(1.0, False)]),  # the size asked for, where it serves
        ([0.01, 0.2], [(1.0, False), (0.98, False)]),
        # None at all, then an element without height.
        ([-1.0, 0.0, 0.051], [(1.0, False), (0.98, False), (0.96, False)]),
        ([0.01] * 6 + [0.051], [*ALL[:6], (1.0, True)]),  # elements are split only then
        ([0.01, 0.031, *[0.0] * 4], [*ALL[:6], (0.98, False)]),  # or not, and the best made again
        ([0.01, 0.029, *[0.0] * 10], [*ALL, (0.98, False)]),
        ([0.01] * 11 + [0.015], ALL),  # it is there already
    ],
)
def test_sizes_are_tried_until_one_serves(monkeypatch, qualities, expected):
    tried = []

    def attempt(gmsh, size, local, stretch, same_faces, finer, split):
        tried.append((size * finer, split))
        quality = qualities[(len(tried) - 1) % len(qualities)]
        if quality < 0:
            raise Exception("no mesh")  # as gmsh does
        return quality

    monkeypatch.setattr(mesher, "_attempt", attempt)
    mesher._tetrahedra(None, 1.0)
    assert tried == expected


def test_what_cannot_be_meshed_at_any_size_says_why(monkeypatch):
    def attempt(gmsh, size, local, stretch, same_faces, finer, split):
        raise Exception(f"no mesh at {finer * size}")

    monkeypatch.setattr(mesher, "_attempt", attempt)
    with pytest.raises(Exception, match="no mesh at 1.0"):
        mesher._tetrahedra(None, 1.0)


def test_a_vane_is_meshed_once(monkeypatch):
    """The elements that span its rounded edges are sound, though two sides lie on one face."""
    sizes = []
    attempt = mesher._attempt

    def counted(gmsh, size, local, stretch, same_faces, finer, split):
        sizes.append(finer * size)
        return attempt(gmsh, size, local, stretch, same_faces, finer, split)

    monkeypatch.setattr(mesher, "_attempt", counted)
    vane_segment(VaneDimensions(aerofoils=1, root_fillet=0), size=0.025)
    assert sizes == [0.025]


def test_a_mesh_is_judged_as_it_is_drawn_out(monkeypatch):
    found = []
    attempt = mesher._attempt

    def kept(*given):
        found.append(attempt(*given))
        return found[-1]

    monkeypatch.setattr(mesher, "_attempt", kept)
    part = casing_sector(CasingDimensions(fillet=0.0015), size=0.02)
    assert found[-1] == pytest.approx(quality(part).smallest_sicn, rel=1e-3)
    assert found[-1] > mesher._BAD


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
