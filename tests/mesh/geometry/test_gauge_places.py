"""Places on an aerofoil against the profile and the output nodes that the mesh has."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import VaneDimensions, on_aerofoil
from vanelock.mesh.geometry.aerofoil import output_points

VANE = VaneDimensions()


def test_places_lie_on_the_profile_between_the_shrouds_and_normals_point_away():
    nodes = output_points(VANE, 16)  # at mid-chord of the convex side
    for span, node in zip((0.25, 0.5, 0.75), nodes, strict=True):
        place = on_aerofoil(VANE, 16, 2, span, 0.5, "suction")
        assert np.linalg.norm(place.position - node) < 1e-14
    for number in (1, 4):
        for span, radius in enumerate(
            (VANE.inner_shroud_outer_radius, VANE.outer_shroud_inner_radius)
        ):
            at = on_aerofoil(VANE, 16, number, span, 0.3, "pressure").position
            assert np.hypot(*at[:2]) == pytest.approx(radius, rel=1e-14)
    convex, concave = (on_aerofoil(VANE, 16, 3, 0.4, 0.5, s) for s in ("suction", "pressure"))
    apart = convex.position - concave.position
    along = [np.linalg.norm(apart), convex.normal @ apart, -concave.normal @ apart]
    assert along == pytest.approx([VANE.thickness] * 3, rel=1e-3)


def test_directions_are_tangents_and_turn_from_span_to_chord():
    places = [on_aerofoil(VANE, 16, 1, 0.3, c, "suction", "chord") for c in (0.2, 0.2 + 1e-6)]
    span = on_aerofoil(VANE, 16, 1, 0.3, 0.2, "suction", "span").direction
    step = places[1].position - places[0].position
    step -= (step @ span) * span  # the shroud that the span counts from is round
    assert places[0].direction == pytest.approx(step / np.linalg.norm(step), abs=1e-4)
    assert places[0].direction @ places[0].normal == pytest.approx(0, abs=1e-12)
    half = on_aerofoil(VANE, 16, 1, 0.3, 0.2, "suction", 30.0).direction
    assert half == pytest.approx(
        np.cos(np.pi / 6) * span + np.sin(np.pi / 6) * places[0].direction, abs=1e-12
    )
    # From front to rear: the trailing edge lies at the larger z.
    assert places[0].direction[2] > 0


@pytest.mark.parametrize(("given", "message"), [
    ({"aerofoil": 5}, "aerofoil = 5: allowed are 1 to 4"),
    ({"span": 1.2}, "span = 1.2: allowed are 0 to 1"),
    ({"chord": -0.1}, "chord = -0.1: allowed are 0 to 1"),
])  # fmt: skip
def test_what_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        on_aerofoil(VANE, 16, **({"aerofoil": 1, "span": 0.5, "chord": 0.5} | given))
