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
from vanelock.mesh.revolved import casing_outline, hooks_outline, inner_shroud_outline


def revolved(corners, angle):
    """Volume of a polygon of (radius, z) turned by an angle: the angle times ∮ r²/2 dz."""
    r, z = np.array([corner[:2] for corner in corners]).T
    after, end = np.roll(r, -1), np.roll(z, -1)
    return abs(angle * np.sum((end - z) * (r**2 + r * after + after**2)) / 6)


def test_a_casing_s_is_that_of_its_outline_turned():
    casing, hook = CasingDimensions(rail_front=0.056, outer_radius=0.606), HookDimensions()
    part = casing_sector(casing, sectors=20, size="coarse")
    volume = revolved(casing_outline(casing, hook), 2 * np.pi / 20)
    assert part.cad_volume == pytest.approx(volume, rel=1e-9)
    assert quality(part).volume == pytest.approx(volume, rel=1e-6)  # elements curved like it


@pytest.mark.slow
def test_a_vane_s_is_that_of_shrouds_and_aerofoils():
    vane, pitch = VaneDimensions(camber=0.0, stagger=5.0), 2 * np.pi / 16
    part = vane_segment(vane, size="coarse")
    # The slanted faces are each other's image, so that the inner shroud fills the whole pitch.
    shrouds = revolved(hooks_outline(vane), vane.outer_shroud_extent * pitch)
    shrouds += revolved(inner_shroud_outline(vane), pitch)
    edge = vane.edge_thickness
    mean = edge + 2 / 3 * (vane.thickness - edge)  # of a parabola; parabolas round the edges
    section = (vane.chord - edge) * mean + 2 / 3 * edge**2
    span = vane.outer_shroud_inner_radius - vane.inner_shroud_outer_radius
    volume = shrouds + vane.aerofoils * section * span
    assert part.cad_volume == pytest.approx(volume, rel=3e-4)
    assert quality(part).volume == pytest.approx(part.cad_volume, rel=3e-3)


def test_it_survives_the_part_s_file(tmp_path, lattice):
    part = lattice((1, 1, 1))
    part.save(tmp_path / "part.h5")
    assert type(part).load(tmp_path / "part.h5").cad_volume is None
