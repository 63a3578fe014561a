"""Cut faces of a user's sector of which nodes are missing, or of whose mates one is clamped."""

from dataclasses import replace

import numpy as np
import pytest

from tests.mesh.conftest import refusal
from vanelock.common.cyclic import turn
from vanelock.mesh import read_mesh, read_sector


def sector(lattice, sectors=12, inner=0.9):
    """A sector of a ring, or of a disc if the inner radius is zero."""

    def place(p):
        r, angle = inner + 0.1 * p[:, 0], 2 * np.pi / sectors * (p[:, 1] - 0.5)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.2 * p[:, 2]])

    part = lattice((1, 3, 4), place, "tetra10", curved=True, sectors=sectors)
    faces = {"left": part.node_sets["y0"], "right": part.node_sets["y1"]}
    return replace(part, name="sector", node_sets=faces)


@pytest.fixture
def read(tmp_path, write_mesh):
    """Function that writes a sector with the given sets and reads it as a user's."""

    def back(part, **sets):
        path = tmp_path / "sector.inp"
        write_mesh(path, replace(part, node_sets=part.node_sets | sets))
        return read_sector(path, part.sectors, "mm"), read_mesh(path, "mm")

    return back


def test_all_nodes_of_a_face_are_needed(lattice, read, tmp_path):
    """Corner nodes alone, or half a face, are refused with their count and a pair of mates."""
    part = sector(lattice)
    left, right = part.node_sets["left"], part.node_sets["right"]
    corners = np.unique(part.cells[:, :4])
    for kept in (np.isin(left, corners), np.arange(len(left)) < len(left) // 2):
        line = refusal(lambda kept=kept: read(part, left=left[kept], right=right[kept]))
        lost = len(left) - kept.sum()
        assert f", left and right: {lost} nodes of either face are missing, such as node" in line
        assert line.endswith("2π/12: all nodes of the cut faces are needed")
        found = read_mesh(tmp_path / "sector.inp", "mm")
        pair = line.split("such as node ")[1].split(", which meets node ")
        numbers = [int(pair[0]), int(pair[1].split()[0])]
        own, mate = (found.points[found.numbers == number][0] for number in numbers)
        assert np.linalg.norm(turn(12) @ own - mate) < 1e-7
        assert np.arctan2(own[1], own[0]) == pytest.approx(-np.pi / 12, abs=1e-7)
    line = refusal(lambda: read(part, left=left[1:], right=right[1:]))
    assert ": 1 node of either face is missing, such as" in line


def test_two_sectors(lattice, read):
    """In a ring of two, each cut node meets the other face's in both directions."""
    part = sector(lattice, sectors=2)
    found, _ = read(part)
    assert len(found.node_sets["left"]) == len(part.node_sets["left"])
    left, right = part.node_sets["left"], part.node_sets["right"]
    line = refusal(lambda: read(part, left=left[3:], right=right[3:]))
    assert ": 3 nodes of either face are missing" in line


def test_nodes_on_the_axis(lattice, read):
    """A quarter of a disc, whose nodes on the engine axis meet themselves, listed or not."""
    part = lattice((3, 3, 1), lambda p: 0.1 * p, sectors=4)
    axis = np.intersect1d(part.node_sets["x0"], part.node_sets["y0"])
    assert len(axis) == 3
    for without in (axis[:0], axis):
        left = np.setdiff1d(part.node_sets["y0"], without)
        right = np.setdiff1d(part.node_sets["x0"], without)
        found, _ = read(replace(part, node_sets={}), left=left, right=right)
        assert len(found.node_sets["left"]) == len(left)
    off = {"left": np.setdiff1d(left, left[0]), "right": np.setdiff1d(right, right[0])}
    line = refusal(lambda: read(replace(part, node_sets={}), **off))
    assert ": 1 node of either face is missing" in line


def test_clamped_mates(lattice, read, tmp_path):
    """Mates are clamped together; those that are need not be listed."""
    part = sector(lattice)
    left, right = part.node_sets["left"], part.node_sets["right"]
    both = np.concatenate([left[:5], right[:5]])
    found, _ = read(part, left=left[5:], right=right[5:], fixed=both)
    assert len(found.node_sets["left"]) == len(left) - 5
    for fixed, face in ((left[:3], left), (right[:3], right)):
        line = refusal(lambda fixed=fixed: read(part, fixed=fixed))
        assert f", fixed: at 3 of {len(left)} pairs of the cut faces one node is clamped" in line
        mesh = read_mesh(tmp_path / "sector.inp", "mm")
        number = int(line.split("such as node ")[1].split()[0])
        clamped = mesh.points[mesh.numbers == number][0]
        assert np.linalg.norm(part.points[face[:3]] - clamped, axis=1).min() < 1e-7
