"""Arcs where aerofoils meet the shrouds, and the volume that they add, in closed form."""

import numpy as np
import pytest

from vanelock.mesh import VaneDimensions
from vanelock.mesh.geometry import aerofoil
from vanelock.mesh.geometry.root_fillet import _PLACES, _SLANT, feet, strips, sweep, volume

STRAIGHT = {"camber": 0.0, "stagger": 0.0, "aerofoils": 1}


def section(vane):
    """Area of a section without camber: parabolas along it and round its edges."""
    mean = vane.edge_thickness + 2 / 3 * (vane.thickness - vane.edge_thickness)
    return (vane.chord - vane.edge_thickness) * mean + 2 / 3 * vane.edge_thickness**2


def added(vane):
    """Volume of a fillet on a flat shroud, whose section has a perimeter P and kinks of 26.6°.

    An offset by d adds Pd + Kd² to the section's area; a convex curve that turns by 2π has
    K = π, of which each kink's angle φ counts tan(φ/2) for φ/2.
    """
    outline = aerofoil.around(vane, pieces=400)
    perimeter = np.linalg.norm(np.diff(outline, axis=0, append=outline[:1]), axis=1).sum()
    kink = np.arctan(0.5) - np.arctan(
        2 * (vane.thickness - vane.edge_thickness) / (vane.chord - vane.edge_thickness)
    )
    rounding = np.pi + 4 * (np.tan(kink / 2) - kink / 2)
    r = vane.root_fillet
    height = np.linspace(0, r * np.cos(_SLANT), 4001)
    offset = r - np.sqrt(r**2 - (r * np.cos(_SLANT) - height) ** 2)
    return np.trapezoid(perimeter * offset + rounding * offset**2, height)


@pytest.mark.parametrize("radius", [0.0005, 0.003])
def test_volume_is_that_of_the_section_and_two_fillets(radius):
    vane = VaneDimensions(**STRAIGHT, root_fillet=radius)
    span = vane.outer_shroud_inner_radius - vane.inner_shroud_outer_radius
    plain = section(vane) * span
    assert volume(vane) == pytest.approx(plain + 2 * added(vane), rel=2e-5)
    assert volume(vane) - plain == pytest.approx(2 * added(vane), rel=1e-2)


@pytest.mark.parametrize("changes", [{}, {"lean": 9.5, "twist": -14.0}])
@pytest.mark.parametrize("outer", [False, True])
def test_arcs_are_tangent_to_both_and_have_the_radius(changes, outer):
    """Across the section's curve: the same way from the corner along shroud and aerofoil."""
    radius = 0.003
    vane = VaneDimensions(**changes, root_fillet=radius)
    for strip in strips(vane, outer):
        up = strip.corner * [1, 1, 0] * (-1 if outer else 1)
        up /= np.linalg.norm(up, axis=1)[:, None]
        out = strip.foot - strip.corner
        reach = np.linalg.norm(out, axis=1)
        out /= reach[:, None]
        line = strip.top - strip.corner
        along = np.cross(out, up)
        line -= np.sum(line * along, axis=1)[:, None] * along
        # The mitres at the ends are longer.
        inner = slice(1, -1)
        assert np.linalg.norm(line, axis=1)[inner] == pytest.approx(reach[inner], rel=1e-4)
        angle = np.arccos(np.sum(line * out, axis=1) / np.linalg.norm(line, axis=1))
        assert (reach * np.tan(angle / 2))[inner] == pytest.approx(radius, rel=5e-3)
        centre = strip.foot + radius * up
        for place in range(1, len(_PLACES) - 1):
            off = strip.arc(place, np.linspace(0, 1, 7)) - centre[place]
            off -= np.sum(off * along[place], axis=1)[:, None] * along[place]
            assert np.linalg.norm(off, axis=1) == pytest.approx(radius, rel=1e-2)


def test_they_end_on_the_shrouds_and_turn_by_78_degrees():
    vane = VaneDimensions(root_fillet=0.003)
    assert np.hypot(*feet(vane, False).T[:2]) == pytest.approx(0.432, abs=1e-9)
    assert np.hypot(*feet(vane, True).T[:2]) == pytest.approx(0.567, abs=1e-9)
    assert np.degrees(sweep(vane)) == pytest.approx(78, abs=4)
    assert np.degrees(sweep(VaneDimensions(root_fillet=0.003, lean=15.0))) == pytest.approx(
        78 + 15, abs=4
    )
