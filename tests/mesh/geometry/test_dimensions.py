"""Dimensions: units, defaults of the scene, and what is refused before meshing, by name."""

import re
from typing import Any

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import (
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
    casing_sector,
    check_fit,
    vane_segment,
)
from vanelock.mesh.geometry.aerofoil import around
from vanelock.mesh.geometry.element_size import element_size


def test_lengths_and_angles_take_units() -> None:
    vane = VaneDimensions(chord="54 mm", stagger="0.5 rad", hook={"roof_radius": "59.2 cm"})
    assert vane.chord == pytest.approx(0.054, rel=1e-15)
    assert vane.stagger == pytest.approx(28.64788975654116, rel=1e-14)
    assert vane.hook.roof_radius == pytest.approx(0.592, rel=1e-15)


def test_every_dimension_says_what_it_is() -> None:
    for model in (VaneDimensions, CasingDimensions, HookDimensions):
        for name, field in model.model_fields.items():
            assert name == "hook" or len(field.description or "") > 15, name


@pytest.mark.parametrize(
    ("model", "changes", "message"),
    [
        (VaneDimensions, {"chrod": 0.05}, "chrod"),
        (VaneDimensions, {"chord": -0.05}, "chord"),
        (VaneDimensions, {"chord": float("nan")}, "chord"),
        (VaneDimensions, {"aerofoils": 0}, "aerofoils"),
        (VaneDimensions, {"interlock_slant": 75}, "interlock_slant"),
        (
            VaneDimensions,
            {"outer_shroud_outer_radius": 0.560},
            "outer_shroud_outer_radius = 0.56 m: must exceed outer_shroud_inner_radius = 0.567 m",
        ),
        (
            VaneDimensions,
            {"inner_shroud_outer_radius": 0.6},
            "outer_shroud_inner_radius = 0.567 m: must exceed inner_shroud_outer_radius = 0.6 m",
        ),
        (
            VaneDimensions,
            {"hook": {"lip_radius": 0.595}},
            "roof_radius = 0.592 m: must exceed lip_radius = 0.595 m",
        ),
        (
            VaneDimensions,
            {"hook": {"lip_radius": 0.570}},
            "hook.lip_radius = 0.57 m: must exceed outer_shroud_outer_radius = 0.573 m",
        ),
        (
            VaneDimensions,
            {"hook": {"band_extent": 0.97}},
            "hook.band_extent = 0.97: the bands must be shorter than the foot, "
            "outer_shroud_extent = 0.96",
        ),
        (
            VaneDimensions,
            {"hook": {"band_position": 0.060}},
            "hook.band_position = 0.06 m: must exceed foot_front = 0.068 m",
        ),
        (
            VaneDimensions,
            {"leg_rear": 0.11},
            "hook.mid_plane = 0.1 m: must exceed leg_rear = 0.11 m",
        ),
        (
            VaneDimensions,
            {"edge_thickness": 0.005},
            "edge_thickness = 0.005: must not exceed thickness = 0.0045",
        ),
        (
            CasingDimensions,
            {"outer_radius": 0.6001},
            "outer_radius = 0.6001 m: must exceed inner_radius = 0.6 m by at least 0.0005 m",
        ),
        (
            CasingDimensions,
            {"groove_bottom": 0.05},
            "groove_bottom = 0.05 m: must exceed rail_front = 0.058 m",
        ),
    ],
)
def test_impossible_dimensions_are_refused(
    model: Any, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        model(**changes)


@pytest.mark.parametrize(
    ("vane", "casing", "sectors", "message"),
    [
        ({}, {}, 5, "ring.sectors = 5: must lie between 6 and 360"),
        (
            {"aerofoils": 6},
            {},
            16,
            "vane.aerofoils = 6, vane.outer_shroud_extent = 0.96: the outermost of 6",
        ),
        (
            {"chord": 0.07, "inner_shroud_front": 0.06, "outer_shroud_front": 0.05},
            {},
            16,
            "vane.chord = 0.07 m, vane.outer_shroud_extent = 0.96: the outermost of 4",
        ),
        ({"interlock_slant": -20}, {}, 16, "vane.interlock_slant = -20 deg: the outermost"),
        (
            {"stagger": -40},
            {},
            16,
            "vane.stagger = -40 deg, vane.interlock_slant = 35 deg: the outermost of 4",
        ),
        (
            {"thickness": 0.024},
            {},
            16,
            "vane.chord = 0.047 m: must be at least twice vane.thickness = 0.024 m",
        ),
        ({}, {}, 60, "vane.interlock_slant = 35 deg, ring.sectors = 60: the outermost"),
        (
            {"inner_shroud_front": 0.085},
            {},
            16,
            "vane.inner_shroud_front = 0.085 m: the aerofoils' front, at 0.0",
        ),
        (
            {"foot_front": 0.066},
            {},
            16,
            "casing.groove_bottom = 0.066 m: must lie at least 0.0005 m below "
            "vane.foot_front = 0.066 m",
        ),
        ({}, {"groove_mouth": 0.084}, 16, "casing.groove_mouth = 0.084 m: must lie"),
        ({}, {"groove_mouth": 0.073}, 16, "vane.hook.band_position = 0.074 m: must lie"),
        ({}, {"rail_inner_radius": 0.572}, 16, "vane.outer_shroud_outer_radius = 0.573 m"),
        ({}, {"rail_inner_radius": 0.585}, 16, "casing.rail_inner_radius = 0.585 m"),
        ({}, {"inner_radius": 0.590}, 16, "vane.hook.roof_radius = 0.592 m: must lie"),
        ({}, {"length": 0.150}, 16, "2 vane.hook.mid_plane - casing.rail_front = 0.142 m"),
    ],
)
def test_parts_that_do_not_fit_are_refused(
    vane: dict[str, Any], casing: dict[str, Any], sectors: int, message: str
) -> None:
    with pytest.raises(InputError) as caught:
        check_fit(VaneDimensions(**vane), CasingDimensions(**casing), sectors)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_meshing_refuses_what_cannot_be_before_it_starts() -> None:
    with pytest.raises(InputError, match=r"^vane\.aerofoils = 8, vane\.outer_shroud_extent"):
        vane_segment(VaneDimensions(aerofoils=8), 16, "coarse")
    with pytest.raises(InputError, match=r"^casing\.rail_inner_radius"):
        casing_sector(CasingDimensions(rail_inner_radius=0.59), size="coarse")
    with pytest.raises(InputError, match=r"^ring\.sectors = 3"):
        vane_segment(sectors=3)


@pytest.mark.parametrize("slant", [-30.0, 0.0, 55.0, 60.0])
def test_refused_chord_is_the_one_that_reaches_the_interlock(slant: float) -> None:
    """The limit against the distance of every profile point from the shroud's slanted end."""
    dimensions = VaneDimensions(interlock_slant=slant, outer_shroud_extent=0.999)

    def distance(chord: float) -> float:
        # Half a turn about the radial axis takes the left end to the right one.
        points = around(dimensions.model_copy(update={"chord": chord}), pieces=24)
        across, axial = np.concatenate([points, -points]).T
        angle = np.pi / 16 * 3 / 4 + np.arctan(across / 0.421)  # of the outermost aerofoil
        x, y = np.hypot(0.421, across) * np.array([np.cos(angle), np.sin(angle)])
        end = np.array([-np.sin(np.pi / 16), np.cos(np.pi / 16)]) @ [x, y]
        return float((axial * np.sin(np.radians(slant)) - end * np.cos(np.radians(slant))).min())

    low, high = 0.01, 0.12
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if distance(middle) > 5e-4 else (low, middle)
    casing = CasingDimensions()
    wide = {"inner_shroud_front": 0.01, "outer_shroud_front": 0.01}
    changed = dimensions.model_copy(update=wide)
    check_fit(changed.model_copy(update={"chord": low - 1e-6}), casing, 16)
    with pytest.raises(InputError, match=r"^vane\.chord"):
        check_fit(changed.model_copy(update={"chord": low + 1e-6}), casing, 16)


def test_sizes_have_names_and_limits() -> None:
    assert element_size("medium", "casing") == 0.0125
    assert element_size("medium", "vane") == 0.016
    assert element_size(0.01, "vane") == 0.01
    with pytest.raises(InputError, match='^mesh.size = "tiny": allowed are "coarse", "medium",'):
        element_size("tiny", "vane")
    for size in (0.0, -0.01, 1.0, float("nan")):
        with pytest.raises(InputError, match=r"^mesh\.size = .* m: must lie between 0.001 and"):
            element_size(size, "vane")
