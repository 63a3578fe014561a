"""Aerofoils whose faces are divided into rows and columns."""

import numpy as np
import pytest

from vanelock.common.cyclic import rotation
from vanelock.mesh import VaneDimensions, quality, vane_segment
from vanelock.mesh.generate.aerofoil_faces import SLENDER, divisions
from vanelock.mesh.geometry import aerofoil

# Eight thin aerofoils a sector, between which coarse elements would find no way of their own.
THIN = VaneDimensions(
    aerofoils=8, chord=0.008, thickness=0.0006, edge_thickness=0.0003, interlock_slant=30
)


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


@pytest.mark.parametrize(("vane", "sectors"), [(VaneDimensions(), 16), (THIN, 40)])
def test_edges_of_aerofoils_carry_a_node_at_the_end_of_every_row(vane, sectors):
    part, ends = edge_corners(vane, sectors, "coarse")
    rows, columns = divisions(vane, 0.025)
    assert (rows % 4, columns % 2) == (0, 0)
    for line in ends:
        inside = line[np.hypot(line[:, 0], line[:, 1]) > vane.inner_shroud_outer_radius - 1e-6]
        assert len(inside) == rows + 1
        step = np.diff(np.sort(inside[:, 0]))
        assert step.max() < 1.01 * step.min()
        assert step.max() < min(0.025, SLENDER * vane.edge_thickness)
    assert quality(part).smallest_sicn > 0.01


def test_camber_and_thin_edges_ask_for_more_columns_and_rows():
    assert divisions(VaneDimensions(), 0.025) == (8, 4)  # 135 mm by 47 mm
    assert divisions(VaneDimensions(camber=0.0), 0.025) == (8, 2)
    assert divisions(VaneDimensions(edge_thickness=3e-4), 0.025) == (16, 4)
    assert divisions(VaneDimensions(lean=25), 0.012) == (16, 4)  # 149 mm along the leaning edge
