"""The whole ring, assembled, against one sector with cyclic symmetry, at every nodal diameter."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial import KDTree

from tests.conftest import FULL
from tests.verification.conftest import whole_ring
from vanelock import mesh
from vanelock.common.cyclic import turn
from vanelock.fem import Material, assemble, eigenpairs, modes

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def bladed_sector(lattice, sectors, cell_type, fixed):
    """A sector of a twisted ring with a bump: no symmetry but the rotation, slanted cut faces."""

    def place(p):
        x, y, z = p.T
        angle = 2 * np.pi / sectors * (y + 0.3 * z * z)
        r = 0.3 + 0.15 * x + 0.03 * np.sin(2 * np.pi * y) * (x + 0.5 * z)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.08 * z + 0.03 * x * x])

    part = lattice((3, 4, 2), place, cell_type, curved=True, sectors=sectors)
    sets = {"left": part.node_sets["y0"], "right": part.node_sets["y1"]}
    if fixed:  # the hub, whose clamped nodes lie on both cut faces too
        sets["fixed"] = part.node_sets["x0"]
    return dataclasses.replace(part, node_sets=sets)


def wheel_sector(lattice, sectors, cell_type, fixed):
    """A quarter of a square block, or half of it: its faces meet on the axis."""
    wide = 1 if sectors == 4 else 2

    def place(p):
        x, y, z = p.T
        y = wide * y - (wide - 1)
        return np.column_stack([0.3 * x, 0.3 * y, 0.2 * z + 0.02 * x * x + 0.02 * y * y])

    part = lattice((3, 3 * wide, 3), place, cell_type, curved=True, sectors=sectors)
    p = part.points
    if sectors == 4:
        left = np.flatnonzero(p[:, 1] == 0)
    else:
        left = np.flatnonzero((p[:, 0] == 0) & (p[:, 1] < 1e-12))
    distance, right = KDTree(p).query(p[left] @ turn(sectors).T)
    assert distance.max() < 1e-12
    assert np.count_nonzero(left == right) > 3  # on the axis
    sets = {"left": left, "right": right}
    if fixed:  # the ground, up to the axis
        sets["fixed"] = part.node_sets["z0"]
    return dataclasses.replace(part, node_sets=sets)


def casing_sector(lattice, sectors, cell_type, fixed):
    """The casing of the scene."""
    part = mesh.casing_sector(size=0.05)
    assert (part.sectors, part.cell_type) == (sectors, cell_type)
    assert ("fixed" in part.node_sets) == fixed
    return part


SMALL = [
    (bladed_sector, 7, "tetra10", True),
    (bladed_sector, 6, "hexahedron20", False),
    (wheel_sector, 4, "tetra10", True),
    (wheel_sector, 2, "hexahedron27", False),
]
LARGE = [
    (bladed_sector, 12, "tetra10", True),
    (bladed_sector, 12, "hexahedron20", False),
    (bladed_sector, 9, "hexahedron27", False),
    (bladed_sector, 5, "tetra", True),
    (bladed_sector, 3, "hexahedron", True),
    (wheel_sector, 4, "hexahedron20", False),
    (wheel_sector, 2, "tetra10", True),
    (casing_sector, 16, "tetra10", True),
]


@pytest.mark.parametrize(
    ("sector", "sectors", "cell_type", "fixed"),
    SMALL + LARGE if FULL else SMALL,
    ids=lambda value: getattr(value, "__name__", None),
)
def test_nodal_diameters_share_the_modes_of_the_ring(
    lattice, record, below, sector, sectors, cell_type, fixed
):
    part = sector(lattice, sectors, cell_type, fixed)
    one, ring = assemble(part, STEEL), assemble(whole_ring(part)[0], STEEL)
    half, count, each = sectors // 2, 40, 8 + 80 // sectors
    exact = eigenpairs(ring.K, ring.M, count + 1, shift=-1e6)[0]
    scale = exact[6]
    # Waves of k and -k have one frequency: between 0 and N/2 each counts twice.
    found, times = [], []
    for k in range(half + 1):
        values = (2 * np.pi * modes(one, each, k).frequency) ** 2
        assert values[-1] > exact[count]  # none of the ring's is left out
        found.append(values)
        times.append(np.full(each, 1 if 2 * k % sectors == 0 else 2))
    order = np.argsort(np.concatenate(found))
    together = np.repeat(np.concatenate(found)[order], np.concatenate(times)[order])[:count]
    difference = np.abs(together - exact[:count]) / np.maximum(exact[:count], scale)
    record("dofs of the ring", int(ring.K.shape[0]))
    record("nodal diameters", f"0 to {half}")
    counts = [int(np.count_nonzero(values <= together[-1] * (1 + 1e-12))) for values in found]
    record("frequencies of each", ", ".join(map(str, counts)))
    below("difference of ω²", difference.max(), 1e-9)
    assert min(counts) > 0


@pytest.mark.parametrize("sectors", [5, 6, 8] if FULL else [5, 6])
def test_each_mode_of_the_ring_moves_at_one_nodal_diameter(lattice, record, below, sectors):
    # The ring's own eigenspaces, each projected on the waves of every nodal diameter: trace 2 at
    # one between 0 and N/2, 1 at 0 or N/2, and none elsewhere.
    part = bladed_sector(lattice, sectors, "tetra10", fixed=True)
    merged, _ = whole_ring(part)
    ring = assemble(merged, STEEL)
    values, vectors = eigenpairs(ring.K, ring.M, 25)
    near = KDTree(merged.points)
    next_node = near.query(merged.points @ turn(sectors).T)[1]
    field = ring.field(vectors)
    turned = np.empty_like(field)  # the same field, one sector on
    turned[next_node] = np.einsum("ij,njk->nik", turn(sectors), field)
    free = ring.dofs >= 0
    rows = np.empty_like(vectors)
    rows[ring.dofs[free]] = turned[free]
    step = vectors.T @ (ring.M @ rows)  # that turn, among the modes
    groups = np.split(np.arange(25), np.flatnonzero(np.diff(values) > 1e-7 * values[1:]) + 1)[:-1]
    counted = {1: 0, 2: 0}
    worst = 0.0
    for group in groups:
        inside = step[np.ix_(group, group)]
        waves = np.linalg.eigvals(inside)
        worst = max(worst, float(np.max(np.abs(np.abs(waves) - 1))))
        diameter = np.abs(np.angle(waves)) * sectors / (2 * np.pi)
        k = round(float(diameter[0]))
        worst = max(worst, float(np.max(np.abs(diameter - k))))
        single = 2 * k % sectors == 0
        assert len(group) == (1 if single else 2)
        counted[len(group)] += 1
        alone = modes(assemble(part, STEEL), 25, k).frequency
        f = np.sqrt(values[group]) / (2 * np.pi)
        worst = max(worst, float(np.min(np.abs(alone - f[:, None]), axis=1).max() / f[0]))
    record("modes alone (ND 0 and N/2)", counted[1])
    record("pairs", counted[2])
    below("departure", worst, 1e-7)
    assert counted[1] > 1
    assert counted[2] > 4
