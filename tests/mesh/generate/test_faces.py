"""Aerofoils whose faces are divided into rows and columns."""

import numpy as np
import pytest

from vanelock.common.cyclic import rotation
from vanelock.mesh import VaneDimensions, quality, vane_segment
from vanelock.mesh.element_size import SLENDER
from vanelock.mesh.generate.aerofoils import divisions
from vanelock.mesh.geometry import aerofoil

# Thin aerofoils, 320 in the ring: between them coarse elements would find no way of their own.
THIN = VaneDimensions(
    aerofoils=2,
    chord=0.008,
    thickness=0.0006,
    edge_thickness=0.0003,
    interlock_slant=30,
    root_fillet=0.0,
)
SHARP = VaneDimensions(aerofoils=2, root_fillet=0.0)


def edge_corners(vane, sectors, size):
    """Corner nodes (a, k, 3) where the sides of each aerofoil end, each in its own axes."""
    part = vane_segment(vane, sectors, size)
    corners = part.points[np.unique(part.cells[:, :4])]
    ends = []
    for angle in aerofoil.angles(vane, sectors):
        turned = (corners - [0, 0, vane.hook.mid_plane]) @ rotation(angle)
        for side in (0, 1):
            for station in (-1.0, 1.0):
                line = aerofoil.outline(vane, np.array([station]))[side, 0]
                ends.append(turned[np.linalg.norm(turned[:, 1:] - line, axis=1) < 1e-6])
    return part, ends


@pytest.mark.parametrize(("vane", "sectors"), [(SHARP, 16), (THIN, 160)])
def test_edges_of_aerofoils_carry_a_node_at_the_end_of_every_row(vane, sectors):
    size = 0.025
    part, ends = edge_corners(vane, sectors, size)
    found = divisions(vane, size)
    assert (found.rows % 2, found.columns % 2) == (0, 0)
    low, high = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    for line in ends:
        inside = line[np.hypot(line[:, 0], line[:, 1]) > low - 1e-6]
        assert len(inside) == found.rows + 1
        height = np.sort(inside[:, 0])
        step = np.diff(height)
        even = (high - low) / (2 * (found.rows - 2 * found.outer))  # of rows of one height
        assert step.max() < 1.1 * even
        assert even < min(size, SLENDER * vane.edge_thickness)
        assert step.max() < 1.07 * SLENDER * vane.edge_thickness
        # Short at the shrouds, or for thin edges short everywhere.
        longest = step.max() if 4 * found.outer > found.rows else size
        assert step[0] < 0.6 * longest
        assert step[-1] < 0.6 * longest
        for share in (0.25, 0.5, 0.75):  # output nodes stand there
            wanted = height[0] + share * np.ptp(height)
            assert abs(height - wanted).min() < 1e-3 * np.ptp(height)
    assert quality(part).smallest_sicn > 0.05


def test_camber_and_thin_edges_ask_for_more_columns_and_rows():
    usual = VaneDimensions()
    assert divisions(usual, 0.03) == (12, 4, 4)  # 135 mm by 47 mm
    assert divisions(usual, 0.012) == (16, 5, 8)
    assert divisions(VaneDimensions(lean=25), 0.012) == (22, 7, 8)  # 149 mm along the leaning edge
    assert divisions(VaneDimensions(camber=0.0), 0.05) == (6, 2, 2)
    assert divisions(VaneDimensions(camber=0.3), 0.05) == (6, 2, 4)
    assert divisions(VaneDimensions(edge_thickness=3e-4), 0.03) == (32, 8, 4)  # evenly
    assert divisions(VaneDimensions(edge_thickness=6e-4), 0.012) == (18, 5, 8)
