"""Cylinders, modelled as one sector, against exact elasticity at every nodal diameter."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial import KDTree

from tests.conftest import FULL
from tests.verification.conftest import (
    lowest_frequencies,
    merged,
    seen_by_a_sector,
    waves_between_diaphragms,
)
from vanelock.fem import Material

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)

THICK = {"walls": (0.35, 0.5), "length": 0.6, "sectors": 8}


def between_diaphragms(nodal_diameter, top, walls, length, sectors):
    """Exact frequencies [Hz] below `top` that a sector sees as one nodal diameter."""
    return seen_by_a_sector(
        nodal_diameter,
        sectors,
        lambda n: waves_between_diaphragms(walls, n, length, top, STEEL),
    )


def record_spectrum(record, found, reference):
    """Figures of a comparison, and the relative errors of the elastic frequencies."""
    assert len(reference) >= 6
    elastic = reference > 0
    np.testing.assert_allclose(found[~elastic], 0, atol=1e-2)
    error = found[elastic] / reference[elastic] - 1
    record("frequencies", len(reference))
    record("from", f"{reference[elastic].min():.2f} Hz")
    record("to", f"{reference.max():.2f} Hz")
    record("error", f"{error.min():.1e} to {error.max():.1e}")
    return error


@pytest.mark.parametrize("nodal_diameter", range(5) if FULL else (0, 4))
def test_spectrum_of_a_thick_cylinder(hollow_cylinder, record, nodal_diameter):
    reference = between_diaphragms(nodal_diameter, 6000, **THICK)
    part = hollow_cylinder((3, 6, 10), **THICK)
    found = lowest_frequencies(part, STEEL, len(reference), nodal_diameter, ends="xy")
    error = record_spectrum(record, found, reference)
    assert np.all(error > 0)  # a conforming mesh is too stiff
    assert error.max() < 3e-3


def quarter_of_a_solid_cylinder(lattice, n, layers, radius, length):
    """One sector of four of a solid cylinder, in three blocks."""
    middle = np.array([[0.5, 0.0], [0.38, 0.38], [0.0, 0.5]]) * radius

    def core(p):
        x, y, z = p.T[:, :, None]
        flat = x * (1 - y) * middle[0] + x * y * middle[1] + (1 - x) * y * middle[2]
        return np.hstack([flat, length * z])

    def rim(p, i):
        x, y, z = p.T[:, :, None]
        angle = np.pi / 4 * (y + i)
        wall = radius * np.hstack([np.cos(angle), np.sin(angle)])
        flat = (1 - x) * ((1 - y) * middle[i] + y * middle[i + 1]) + x * wall
        return np.hstack([flat, length * z])

    blocks = [
        lattice((n, n, layers), place, "hexahedron27", curved=True, sectors=4)
        for place in (core, lambda p: rim(p, 0), lambda p: rim(p, 1))
    ]
    points = np.concatenate([block.points for block in blocks])
    first, number = merged(points)
    starts = np.cumsum([0] + [len(block.points) for block in blocks[:-1]])
    cells = [number[block.cells + start] for block, start in zip(blocks, starts, strict=True)]
    points = points[first]
    left = np.flatnonzero(np.abs(points[:, 1]) < 1e-9 * radius)
    right = KDTree(points).query(points[left] @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]])[1]
    sets = {
        "left": left,
        "right": right,
        "ends": np.flatnonzero((points[:, 2] == 0) | (points[:, 2] == length)),
    }
    return dataclasses.replace(
        blocks[0], points=points, cells=np.concatenate(cells), node_sets=sets
    )


@pytest.mark.parametrize("nodal_diameter", range(3))
def test_spectrum_of_a_solid_cylinder(lattice, record, nodal_diameter):
    # Its quarter reaches the axis, whose nodes keep what the wave allows there: u_z at ND 0, one
    # turning motion across the axis at ND 1, nothing at ND 2.
    radius, length = 0.3, 0.5
    reference = between_diaphragms(nodal_diameter, 8000, (radius,), length, 4)
    part = quarter_of_a_solid_cylinder(lattice, 3, 6, radius, length)
    assert np.count_nonzero(part.node_sets["left"] == part.node_sets["right"]) == 13
    found = lowest_frequencies(part, STEEL, len(reference), nodal_diameter, ends="xy")
    error = record_spectrum(record, found, reference)
    assert np.all(error > 0)
    assert error.max() < 5e-3


@pytest.mark.parametrize(("cell_type", "walls", "order"), [
    ("tetra", "straight", 2), ("hexahedron", "straight", 2), ("tetra10", "straight", 2),
    ("tetra10", "curved", 4), ("hexahedron20", "straight", 2), ("hexahedron20", "curved", 4),
    ("hexahedron27", "straight", 2), ("hexahedron27", "curved", 4),
])  # fmt: skip
def test_frequencies_converge_at_the_order_of_elements_and_walls(
    hollow_cylinder, record, cell_type, walls, order
):
    # At ND 2, the bending of the wall and the axial shear. Chords of the walls leave an error of
    # second order however high that of the element. In the shear it has the sign of the element's
    # own; in bending they pass through zero together, which makes no rate.
    reference = between_diaphragms(2, 3000, **THICK)
    assert len(reference) == 2
    linear = cell_type in ("tetra", "hexahedron")
    levels = ((3, 4, 5) if linear else (1, 1.5, 2))[: 3 if FULL else 2]
    errors = []
    for level in levels:
        counts = [int(level * n) for n in (2, 4, 4)]
        part = hollow_cylinder(counts, cell_type=cell_type, curved=walls == "curved", **THICK)
        found = lowest_frequencies(part, STEEL, 2, nodal_diameter=2, ends="xy")
        errors.append(found / reference - 1)
    steps = np.log(np.divide(levels[1:], levels[:-1]))
    rates = np.log(np.abs(np.divide(errors[:-1], errors[1:]))) / steps[:, None]
    for i, name in ((0, "bending"), (1, "shear")):
        record(f"{name}: errors", ", ".join(f"{e[i]:.2e}" for e in errors))
        record(f"{name}: order", ", ".join(f"{rate:.2f}" for rate in rates[:, i]))
    np.testing.assert_allclose(rates[:, 1], order, atol=0.2)
    if linear or walls == "curved":
        np.testing.assert_allclose(rates[:, 0], order, atol=0.3)
