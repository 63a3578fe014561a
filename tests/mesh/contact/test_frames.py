"""Directions of the faces around nodes, and the frames that follow from them."""

import numpy as np
import pytest

from vanelock.mesh.cells import exterior, solid
from vanelock.mesh.matching.side import _candidates, frames, opposed


def test_normals_of_a_cube(lattice):
    """Three directions at a corner, two on a side, one on a face, none inside."""
    part = lattice((2, 2, 2), lambda p: np.array([3, 0, 0]) + p, "hexahedron27")
    faces = exterior(part.cells, solid(part.cell_type))
    assert len(faces) == 24
    places = np.array([[3, 0, 0], [3.5, 0, 0], [3.5, 0.5, 0], [3.5, 0.5, 0.5]])
    nodes = np.array([np.abs(part.points - p).max(axis=1).argmin() for p in places])
    found = _candidates(part.points, faces, nodes)
    assert [len(directions) for directions in found] == [3, 2, 1, 0]
    assert np.abs(np.sort(found[0], axis=0) - np.sort(-np.eye(3), axis=0)).max() < 1e-15
    below = faces[np.abs(part.points[faces, 2]).max(axis=1) < 1e-12]
    only = _candidates(part.points, below, nodes[:1])  # the faces of a set of faces
    assert np.abs(only[0] - [[0, 0, -1]]).max() < 1e-15


def test_opposed_pairs():
    x, y, z = np.eye(3)
    normal, off, several = opposed(np.array([x, y]), np.array([-y, z]))
    assert np.array_equal(normal, y)
    assert (off, several) == (0.0, False)
    assert opposed(np.array([x, y]), np.array([-y, -x]))[2]
    tilt = np.array([np.cos(0.1), np.sin(0.1), 0])
    normal, off, _ = opposed(np.array([x]), np.array([-tilt]))
    assert off == pytest.approx(np.degrees(0.1))
    assert normal @ x == pytest.approx(np.cos(0.05), rel=1e-14)
    assert opposed(np.empty((0, 3)), np.array([x]))[1] == 180.0


def test_frames_are_right_handed():
    random = np.random.default_rng(0).normal(size=(50, 3))
    normal = random / np.linalg.norm(random, axis=1)[:, None]
    x, y = (np.broadcast_to(axis, normal.shape) for axis in np.eye(3)[:2])
    found = frames(normal, x, y)
    assert np.abs(found @ found.transpose(0, 2, 1) - np.eye(3)).max() < 1e-14
    assert np.abs(np.linalg.det(found) - 1).max() < 1e-14
    near = np.abs(normal[:, 0]) > np.cos(np.pi / 4)
    assert 0 < near.sum() < 50
    assert np.abs(found[~near, 1] @ np.eye(3)[0] - np.sqrt(1 - normal[~near, 0] ** 2)).max() < 1e-14
    assert (found[near, 1, 1] > 0).all()
