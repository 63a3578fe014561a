"""The volume of the geometry, which meshes are judged against, in closed form."""

import numpy as np
import pytest

from vanelock.mesh import (
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
    casing_sector,
    quality,
    vane_segment,
)


def turned(angle, *rectangles):
    """Volume of rectangles (r from, r to, z from, z to) turned by an angle."""
    return sum(angle * (b**2 - a**2) / 2 * (d - c) for a, b, c, d in rectangles)


def test_a_casing_s_is_that_of_shell_flanges_and_rails():
    """All dimensions but those of the fillets and bosses, none of them at its default."""
    casing = CasingDimensions(
        length=0.206,
        inner_radius=0.601,
        outer_radius=0.606,
        flange_radius=0.631,
        flange_thickness=0.0127,
        rail_inner_radius=0.579,
        rail_front=0.056,
        groove_bottom=0.067,
        groove_mouth=0.083,
    )
    hook = HookDimensions(roof_radius=0.593, lip_radius=0.5845, mid_plane=0.103)
    part, angle = casing_sector(casing, sectors=20, hook=hook, size="coarse"), 2 * np.pi / 20
    shell = turned(angle, (0.601, 0.606, 0, 0.206))
    flange = turned(angle, (0.606, 0.631, 0, 0.0127))
    rail = turned(angle, (0.579, 0.601, 0.056, 0.083)) - turned(
        angle, (0.5845, 0.593, 0.067, 0.083)
    )
    assert part.cad_volume == pytest.approx(shell + 2 * flange + 2 * rail, rel=1e-9)
    assert quality(part).volume == pytest.approx(part.cad_volume, rel=1e-6)  # curved like it


def test_a_vane_s_is_that_of_shrouds_and_aerofoils():
    vane = VaneDimensions(
        aerofoils=3,
        chord=0.049,
        thickness=0.0055,
        edge_thickness=0.0026,
        camber=0.0,
        stagger=5.0,
        root_fillet=0.0,
        inner_shroud_inner_radius=0.411,
        inner_shroud_outer_radius=0.434,
        inner_shroud_front=0.071,
        outer_shroud_inner_radius=0.566,
        outer_shroud_outer_radius=0.574,
        outer_shroud_front=0.059,
        outer_shroud_extent=0.95,
        foot_front=0.0675,
        leg_front=0.0845,
        leg_rear=0.0895,
    )
    pitch = 2 * np.pi / 16
    part = vane_segment(vane, size="coarse")
    # The slanted faces are each other's image, so that the inner shroud fills the whole pitch.
    plate = turned(0.95 * pitch, (0.566, 0.574, 0.059, 0.141))
    leg = turned(0.95 * pitch, (0.574, 0.592, 0.0845, 0.0895), (0.584, 0.592, 0.0675, 0.0845))
    shrouds = plate + 2 * leg + turned(pitch, (0.411, 0.434, 0.071, 0.129))
    mean = 0.0026 + 2 / 3 * (0.0055 - 0.0026)  # of a parabola; parabolas round the edges
    section = (0.049 - 0.0026) * mean + 2 / 3 * 0.0026**2
    volume = shrouds + 3 * section * (0.566 - 0.434)
    assert part.cad_volume == pytest.approx(volume, rel=3e-4)
    assert quality(part).volume == pytest.approx(part.cad_volume, rel=3e-3)


def test_an_aerofoil_that_leans_has_its_outer_end_at_the_larger_angle():
    vane = VaneDimensions(aerofoils=1, lean=9.0, twist=6.0, root_fillet=0)
    part = vane_segment(vane, size="coarse")
    r, angle = np.hypot(*part.points[:, :2].T), np.arctan2(part.points[:, 1], part.points[:, 0])
    between = (r > 0.440) & (r < 0.560)
    height, sideways = r[between] * np.cos(angle[between]), r[between] * np.sin(angle[between])
    slope = np.polyfit(height, sideways, 1)[0]
    assert slope == pytest.approx(np.tan(np.radians(9.0)), rel=0.1)
