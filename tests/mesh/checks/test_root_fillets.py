"""Fillets of aerofoils that do not fit are refused, with the largest that does."""

from typing import Any

import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import VaneDimensions, quality, vane_segment
from vanelock.mesh.checks.dimensions import check_vane
from vanelock.mesh.checks.root_fillets import filleted
from vanelock.mesh.refinement.dof_estimate import check_size


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        (
            {"root_fillet": 0.012},
            "beside the ends of the outer shroud (vane.outer_shroud_extent) at most 0.00684 m fits",
        ),
        (
            {"root_fillet": 0.012, "inner_shroud_front": 0.075, "aerofoils": 2},
            "behind vane.inner_shroud_front",
        ),
        (
            {"root_fillet": 0.006, "outer_shroud_front": 0.076, "aerofoils": 2},
            "behind vane.outer_shroud_front",
        ),
        ({"root_fillet": 0.005, "interlock_slant": 48}, "beside the interlock faces"),
        (
            {"root_fillet": 0.006, "outer_shroud_extent": 0.92, "hook": {"band_extent": 0.85}},
            "beside the ends of the outer shroud (vane.outer_shroud_extent)",
        ),
        (
            {
                "root_fillet": 0.006,
                "inner_shroud_outer_radius": 0.545,
                "inner_shroud_inner_radius": 0.53,
            },
            "within a quarter of the span between the shrouds",
        ),
        (
            {
                "root_fillet": 0.012,
                "camber": 0.4,
                "aerofoils": 1,
                "inner_shroud_front": 0.04,
                "outer_shroud_front": 0.04,
            },
            "on the hollow side (vane.camber)",
        ),
    ],
)
def test_what_does_not_fit_is_refused_by_name(changes: dict[str, Any], where: str) -> None:
    vane = VaneDimensions.model_validate(changes)
    with pytest.raises(InputError) as caught:
        check_vane(vane, 16)
    message = str(caught.value)
    assert message.startswith(f"vane.root_fillet = {vane.root_fillet:g} m: {where}")
    assert "\n" not in message
    if "at most" in message:
        largest = float(message.split("at most ")[1].split()[0])
        check_vane(vane.model_copy(update={"root_fillet": largest}), 16)


@pytest.mark.parametrize(
    ("changes", "sectors", "radius"),
    [
        ({}, 16, 0.003),
        ({"chord": 0.008, "thickness": 0.0006, "edge_thickness": 0.0003}, 160, 0.00191),
        ({"inner_shroud_front": 0.078}, 16, 0.0),  # nor does half of it
    ],
)
def test_a_radius_is_chosen_that_fits(changes: dict[str, Any], sectors: int, radius: float) -> None:
    vane = VaneDimensions(aerofoils=2, **changes)
    found = filleted(vane, sectors)
    assert found.root_fillet == pytest.approx(radius)
    check_vane(found, sectors)
    if 0 < radius < 0.003:
        with pytest.raises(InputError, match="root_fillet"):
            check_vane(vane.model_copy(update={"root_fillet": radius + 1e-4}), sectors)


def test_the_largest_that_fits_is_meshed() -> None:
    vane = VaneDimensions(aerofoils=1, root_fillet=0.012)
    with pytest.raises(InputError) as caught:
        check_vane(vane, 16)
    largest = float(str(caught.value).split("at most ")[1].split()[0])
    assert 0.008 < largest < 0.012
    part = vane_segment(vane.model_copy(update={"root_fillet": largest}), size=0.02)
    assert quality(part).smallest_sicn > 0.02


def test_radii_too_small_for_any_mesh_or_for_this_one_are_refused() -> None:
    with pytest.raises(ValueError, match=r"root_fillet = 0\.0002 m: must be 0 or at least 0\.0005"):
        VaneDimensions(root_fillet=0.0002)
    small = VaneDimensions(root_fillet=0.001)
    expected = r"^vane\.root_fillet = 0\.001 m: too small for elements of 25 mm"
    with pytest.raises(InputError, match=expected):
        vane_segment(small, size=0.025)
    with pytest.raises(InputError, match=expected):
        check_size(0.025, small, None, 16)
