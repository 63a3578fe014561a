"""The vane's hexahedra, which the mesh study compares with tetrahedra."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from benchmarks.mesh.blocks import Sizes
from benchmarks.mesh.vane_blocks import vane_hexahedra
from vanelock.fem import Material, assemble
from vanelock.mesh import VaneDimensions
from vanelock.mesh.geometry import aerofoil

SECTORS = 16
MATERIAL = Material(E=170e9, nu=0.3, rho=8200)
# Corners of a hexahedron's six faces.
FACES = np.array(
    [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [3, 2, 6, 7], [0, 3, 7, 4], [1, 2, 6, 5]]
)


@pytest.fixture(scope="module", name="fine")
def fine_fixture():
    """Elements small enough that all curves are met to 1e-5 of their areas."""
    return vane_hexahedra(Sizes(0.008, thick=2), cell_type="hexahedron27")


def section_area(vane):
    """Of an aerofoil, m²: of the polygon of its sides, and of the parabolas at its ends."""
    convex, concave = aerofoil.outline(vane, np.linspace(-1, 1, 4001))
    across, axial = np.concatenate([convex, concave[::-1]]).T
    area = abs(0.5 * np.sum(across * np.roll(axial, -1) - np.roll(across, -1) * axial))
    edges = aerofoil.edges(vane)
    for k in (0, -1):
        # A parabola's segment is two thirds of the triangle between its tangents.
        chord, top = concave[k] - convex[k], edges.control[k] - convex[k]
        area += abs(chord[0] * top[1] - chord[1] * top[0]) / 3
    return area


def test_volume_is_that_of_rings_and_prisms(fine):
    vane = VaneDimensions()
    mid, hook = vane.hook.mid_plane, vane.hook
    pitch = 2 * np.pi / SECTORS

    def ring(low, high, front, rear):
        return pitch / 2 * (high**2 - low**2) * (rear - front) * 2

    outer = ring(
        vane.outer_shroud_inner_radius, vane.outer_shroud_outer_radius, vane.outer_shroud_front, mid
    )
    outer += ring(vane.outer_shroud_outer_radius, hook.lip_radius, vane.leg_front, vane.leg_rear)
    outer += ring(hook.lip_radius, hook.roof_radius, vane.foot_front, vane.leg_rear)
    inner = ring(
        vane.inner_shroud_inner_radius, vane.inner_shroud_outer_radius, vane.inner_shroud_front, mid
    )
    span = vane.outer_shroud_inner_radius - vane.inner_shroud_outer_radius
    prisms = vane.aerofoils * section_area(vane) * span
    expected = vane.outer_shroud_extent * outer + inner + prisms
    volume = assemble(fine, MATERIAL).M.sum() / 3 / MATERIAL.rho
    # The prisms' ends are cylinders: 12 mm³ less than the span makes of them.
    assert volume == pytest.approx(expected, rel=5e-5)


def test_blocks_are_glued(fine):
    corners = np.sort(fine.cells[:, FACES].reshape(-1, 4), axis=1)
    faces, count = np.unique(corners, axis=0, return_counts=True)
    assert set(count) == {1, 2}
    # Two faces at one place would be a crack.
    centre = fine.points[faces[count == 1]].mean(axis=1)
    distance, _ = cKDTree(centre).query(centre, k=2)
    assert distance[:, 1].min() > 1e-5
