"""Estimates of what a mesh has, against meshes that were made."""

from typing import Any

import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import (
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
    casing_sector,
    quality,
    vane_segment,
)
from vanelock.mesh.refinement import (
    MOST,
    _casing_plates,
    casing_dofs,
    check_size,
    vane_dofs,
)

SHORT = {"aerofoils": 2, "chord": 0.03, "interlock_slant": 20, "root_fillet": 0.003}


THIN = {"aerofoils": 1, "root_fillet": 0, "thickness": 0.002, "edge_thickness": 0.0006}


DESIGNS: dict[str, tuple[float, int, dict[str, Any], dict[str, Any]]] = {
    "short with filleted roots": (0.025, 24, SHORT, {"outer_radius": 0.612}),
    "thin edges": (0.025, 16, THIN, {}),
}


@pytest.mark.parametrize("design", DESIGNS)
def test_estimates_are_near_the_meshes(design: str) -> None:
    size, sectors, *changes = DESIGNS[design]
    vane, casing = VaneDimensions(**changes[0]), CasingDimensions(**changes[1])
    made = (
        vane_segment(vane, sectors, size),
        casing_sector(casing, vane.hook, sectors, size, stretch=1),
    )
    estimated = vane_dofs(vane, sectors, size), casing_dofs(casing, vane.hook, sectors, size)
    for part, dofs in zip(made, estimated, strict=True):
        assert dofs == pytest.approx(3 * len(part.points), rel=0.25)
    volume = sum(area * thickness for area, thickness in _casing_plates(casing, vane.hook, sectors))
    assert volume == pytest.approx(quality(made[1]).volume, rel=0.04)


@pytest.mark.parametrize(
    ("vane_size", "vane", "size", "casing"),
    [  # degrees of freedom of meshes that are too large to be made in a test
        (0.010, 124470, 0.006, 108777),
        (0.008, 193971, 0.005, 161760),
        (0.006, 354099, 0.004, 259428),
    ],
)
def test_estimates_are_near_large_meshes(
    vane_size: float, vane: int, size: float, casing: int
) -> None:
    assert vane_dofs(VaneDimensions(), 16, vane_size) == pytest.approx(vane, rel=0.1)
    estimated = casing_dofs(CasingDimensions(), HookDimensions(), 16, size)
    assert estimated == pytest.approx(casing, rel=0.2)


def test_too_large_meshes_are_refused_with_the_smallest_size() -> None:
    vane, casing = VaneDimensions(root_fillet=0), CasingDimensions()
    dofs = vane_dofs(vane, 16, 0.002) + casing_dofs(casing, vane.hook, 16, 0.002, 3)
    with pytest.raises(InputError) as caught:
        check_size(0.002, vane, casing, 16)
    message = str(caught.value)
    assert message.startswith(
        f"mesh.size = 2 mm: about {round(dofs, -5):,.0f} degrees of freedom: at most {MOST:,} "
    )
    assert message.endswith(" mm here")
    smallest = 1e-3 * float(message.partition("sizes from ")[2].split()[0])
    assert smallest == pytest.approx(0.004, abs=2e-4)
    check_size(smallest, vane, casing, 16)
    with pytest.raises(InputError):
        check_size(smallest - 1e-4, vane, casing, 16)
    # A name is refused as well where the parts are large.
    large = CasingDimensions(outer_radius=4.9, flange_radius=5.0)
    with pytest.raises(InputError, match=r'^mesh\.size = "medium": about'):
        check_size("medium", vane, large, 6)
