"""Sizes of meshes told beforehand, against meshes that were made."""

from typing import Any

import pytest

from vanelock.errors import InputError
from vanelock.mesh import CasingDimensions, VaneDimensions, casing_sector, quality, vane_segment
from vanelock.mesh.effort import casing_plates, check_size, degrees_of_freedom, vane_plates

DESIGNS: dict[str, tuple[int, dict[str, Any], dict[str, Any]]] = {
    "scene": (16, {}, {}),
    "thick": (16, {"thickness": 0.010, "edge_thickness": 0.004}, {"outer_radius": 0.612}),
    "short": (24, {"aerofoils": 2, "chord": 0.03, "interlock_slant": 20}, {}),
    "three aerofoils": (18, {"aerofoils": 3, "chord": 0.054}, {}),
}


@pytest.mark.parametrize("size", [0.025, 0.009])
@pytest.mark.parametrize("design", DESIGNS)
def test_estimates_are_near_the_meshes(design: str, size: float) -> None:
    sectors, *changes = DESIGNS[design]
    vane, casing = VaneDimensions(**changes[0]), CasingDimensions(**changes[1])
    for part, plates in (
        (vane_segment(vane, sectors, size), vane_plates(vane, sectors)),
        (
            casing_sector(casing, vane.hook, sectors, size),
            casing_plates(casing, vane.hook, sectors),
        ),
    ):
        assert degrees_of_freedom(plates, size) == pytest.approx(3 * len(part.points), rel=0.25)
        volume = sum(area * thickness for area, thickness in plates)
        assert volume == pytest.approx(quality(part).volume, rel=0.04)


@pytest.mark.parametrize(
    ("size", "vane", "casing"),
    [  # degrees of freedom of meshes that are too large to be made in a test
        (0.006, 119346, 103116),
        (0.005, 175878, 157359),
        (0.004, 277146, 256875),
        (0.003, 567699, 529248),
    ],
)
def test_estimates_are_near_large_meshes(size: float, vane: int, casing: int) -> None:
    told = VaneDimensions(), CasingDimensions()
    assert degrees_of_freedom(vane_plates(told[0], 16), size) == pytest.approx(vane, rel=0.2)
    plates = casing_plates(told[1], told[0].hook, 16)
    assert degrees_of_freedom(plates, size) == pytest.approx(casing, rel=0.2)


def test_too_large_meshes_are_refused_with_the_smallest_size() -> None:
    vane, casing = VaneDimensions(), CasingDimensions()
    with pytest.raises(InputError) as caught:
        check_size(0.002, vane, casing, 16)
    told = str(caught.value)
    assert told.startswith(
        "mesh.size = 0.002 m: about 3,100,000 degrees of freedom: at most 1,000,"
    )
    assert told.endswith("sizes from 3.2 mm here")
    check_size(0.0032, vane, casing, 16)
    with pytest.raises(InputError):
        check_size(0.0031, vane, casing, 16)
    # A name is refused as well where the parts are large.
    large = CasingDimensions(outer_radius=4.9, flange_radius=5.0)
    with pytest.raises(InputError, match=r'^mesh\.size = "medium": about'):
        check_size("medium", vane, large, 6)
