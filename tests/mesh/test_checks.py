"""Designs that cannot be are refused before they are meshed, by name, with what would fit."""

import re
from typing import Any

import pytest

from tests.mesh.conftest import refusal
from tests.refusals import refused
from vanelock.mesh import (
    CasingDimensions,
    VaneDimensions,
    casing_sector,
    check_fit,
    quality,
    vane_segment,
)
from vanelock.mesh.checks import check_vane
from vanelock.mesh.geometry.root_fillet import filleted
from vanelock.mesh.refinement import check_size

Values = dict[str, Any]


@pytest.mark.parametrize(("model", "changes", "message"), [
    (VaneDimensions, {"chrod": 0.05}, "chrod"), (VaneDimensions, {"chord": -0.05}, "chord"),
    (VaneDimensions, {"aerofoils": 0}, "aerofoils"),
    (VaneDimensions, {"interlock_slant": 75}, "interlock_slant"),
    (VaneDimensions, {"outer_shroud_outer_radius": 0.560}, "outer_shroud_outer_radius = 0.56 m: "
     "must exceed outer_shroud_inner_radius = 0.567 m"),
    (VaneDimensions, {"hook": {"lip_radius": 0.595}}, "roof_radius = 0.592 m: must exceed "
     "lip_radius = 0.595 m"),
    (VaneDimensions, {"hook": {"lip_radius": 0.570}}, "hook.lip_radius = 0.57 m: must exceed "
     "outer_shroud_outer_radius = 0.573 m"),
    (VaneDimensions, {"hook": {"band_extent": 0.97}}, "hook.band_extent = 0.97: the bands must be "
     "shorter than the foot, outer_shroud_extent = 0.96"),
    (VaneDimensions, {"hook": {"band_position": 0.060}}, "hook.band_position = 0.06 m: must "
     "exceed foot_front = 0.068 m"),
    (VaneDimensions, {"edge_thickness": 0.005}, "edge_thickness = 0.005: must not exceed "
     "thickness = 0.0045"),
    (VaneDimensions, {"fillet": 0.0001}, "fillet = 0.0001 m: must be 0 or at least 0.0005"),
    (VaneDimensions, {"root_fillet": 0.0002}, "root_fillet = 0.0002 m: must be 0 or at least"),
    (CasingDimensions, {"outer_radius": 0.6001}, "outer_radius = 0.6001 m: must exceed "
     "inner_radius = 0.6 m by at least 0.0005 m"),
    ])  # fmt: skip
def test_impossible_dimensions(model: Any, changes: Values, message: str) -> None:
    refused(re.escape(message), model, **changes)
    if "fillet" in changes or "root_fillet" in changes:
        for allowed in (0, 0.0005):
            assert getattr(model(**dict.fromkeys(changes, allowed)), next(iter(changes))) == allowed


UNFIT: list[tuple[Values, Values, str]] = [
    ({}, {"sectors": 5}, "ring.sectors = 5: must lie between 6 and 360"),
    ({"aerofoils": 6}, {}, "vane.aerofoils = 6, vane.outer_shroud_extent = 0.96: the outermost of "
     "6"),
    ({"stagger": -40}, {}, "vane.stagger = -40 deg, vane.interlock_slant = 35 deg: the outermost "
     "of 4"),
    ({"thickness": 0.024}, {}, "vane.chord = 0.047 m: must be at least twice vane.thickness = "
     "0.024 m"),
    ({"inner_shroud_front": 0.085}, {}, "vane.inner_shroud_front = 0.085 m: the aerofoils' front, "
     "at 0.0"),
    ({"foot_front": 0.066}, {}, "casing.groove_bottom = 0.066 m: must lie at least 0.0005 m below "
     "vane.foot_front = 0.066 m"),
    ({}, {"groove_mouth": 0.073}, "vane.hook.band_position = 0.074 m: must lie"),
    ({}, {"rail_inner_radius": 0.572}, "vane.outer_shroud_outer_radius = 0.573 m"),
    ({}, {"inner_radius": 0.590}, "vane.hook.roof_radius = 0.592 m: must lie"),
    ({}, {"length": 0.150}, "2 vane.hook.mid_plane - casing.rail_front = 0.142 m"),
    ({}, {"fillet": 0.003, "inner_radius": 0.595}, "casing.fillet = 0.003 m: between "
     "vane.hook.roof_radius and casing.inner_radius at most 0.0025 m fits"),
    ({"fillet": 0.006}, {}, "vane.fillet = 0.006 m: between vane.outer_shroud_outer_radius and "
     "vane.hook.lip_radius at most 0.00525 m fits"),
    ({"fillet": 0.002, "leg_rear": 0.0985}, {}, "vane.fillet = 0.002 m: between vane.leg_rear and "
     "its mirror image at most 0.00125 m"),
    ({"fillet": 0.001, "outer_shroud_front": 0.0835}, {}, "vane.fillet = 0.001 m: between "
     "vane.outer_shroud_front and vane.leg_front none fits"),
    ({"root_fillet": 0.012}, {}, "vane.root_fillet = 0.012 m: beside the ends of the outer shroud "
     "(vane.outer_shroud_extent) at most 0.00684 m fits"),
    ({"root_fillet": 0.006, "outer_shroud_front": 0.076, "aerofoils": 2}, {}, "vane.root_fillet = "
     "0.006 m: behind vane.outer_shroud_front"),
    ({"root_fillet": 0.005, "interlock_slant": 48}, {}, "vane.root_fillet = 0.005 m: beside the "
     "interlock faces"),
    ({"root_fillet": 0.006, "outer_shroud_extent": 0.92, "hook": {"band_extent": 0.85}}, {},
     "vane.root_fillet = 0.006 m: beside the ends of the outer shroud (vane.outer_shroud_extent)"),
    ({"root_fillet": 0.006, "inner_shroud_outer_radius": 0.545, "inner_shroud_inner_radius": 0.53},
     {}, "vane.root_fillet = 0.006 m: within a quarter of the span between the shrouds"),
    ({"root_fillet": 0.012, "camber": 0.4, "aerofoils": 1, "inner_shroud_front": 0.04,
      "outer_shroud_front": 0.04}, {}, "vane.root_fillet = 0.012 m: on the hollow side (vane.camb"),
    ({}, {"bosses": 2, "boss_position": 0.020}, "casing.boss_position = 0.02 m: a boss of 0.025 m "
     "clears the flanges between 0.023 m and 0.177 m"),
    ({}, {"bosses": 2, "boss_position": 0.105}, "casing.boss_position = 0.105 m: a boss of 0.025 m "
     "covers a force node: it must stay 0.013 m away from 0.1 m"),
    ({}, {"bosses": 1, "boss_position": 0.065}, "casing.boss_position = 0.065 m: a boss of 0.025 m "
     "covers an output node: it must stay 0.013 m away from 0.07 m"),
    ({}, {"bosses": 8, "boss_diameter": 0.030}, "casing.boss_diameter = 0.03 m: 8 bosses in one of "
     "16 sectors touch each other or the cyclic faces: at most 0.0284 m fits"),
    ({}, {"bosses": 1, "boss_diameter": 0.160, "length": 0.5, "boss_position": 0.35},
     "casing.boss_diameter = 0.16 m: the shell is too thin for it: at most 0.1298 m fits"),
]  # fmt: skip


@pytest.mark.parametrize(("vane", "casing", "message"), UNFIT)
def test_parts_that_do_not_fit(vane: Values, casing: Values, message: str) -> None:
    """What is said to fit does; without bosses their dimensions mean nothing."""

    def check(**changes: Values) -> None:
        values = {"sectors": 16, **casing, **changes.get("casing", {})}
        sectors = values.pop("sectors")
        dimensions = VaneDimensions.model_validate(vane | changes.get("vane", {}))
        check_fit(dimensions, CasingDimensions(**values), sectors)

    said = refusal(check)
    assert said.startswith(message)
    if "at most " in said and "fillet = " not in said.replace("root_fillet", ""):
        part, name = said.partition(" = ")[0].split(".")
        check(**{part: {name: float(said.partition("at most ")[2].split()[0])}})
    if "bosses" in casing:
        check(casing={"bosses": 0})


def test_meshing_refuses_what_cannot_be_before_it_starts() -> None:
    for begin, build in (
        ("vane.aerofoils = 8, vane.outer", lambda: vane_segment(VaneDimensions(aerofoils=8))),
        (
            "casing.rail_inner_radius",
            lambda: casing_sector(CasingDimensions(rail_inner_radius=0.59)),
        ),
        ("ring.sectors = 3", lambda: vane_segment(sectors=3)),
    ):
        assert refusal(build).startswith(begin)


@pytest.mark.parametrize(("vane", "casing", "size", "message"), [
    ({}, {"fillet": 0.001}, 0.025, "casing.fillet = 0.001 m: too small for elements of 25 mm: "
     "allowed are 0, 0.00125 m and more, or mesh.size up to 0.02 m"),
    ({"fillet": 0.001}, None, 0.041, "vane.fillet = 0.001 m: too small"),
    ({"root_fillet": 0.001}, None, 0.025, "vane.root_fillet = 0.001 m: too small for elements of "
     "25 mm"),
    ({}, {"bosses": 1, "boss_height": 0.001}, 0.025, "casing.boss_height = 0.001 m: too small for "
     "elemen"),
    ({}, {"bosses": 1, "boss_diameter": 0.004}, 0.025, "casing.boss_diameter = 0.004 m: too small"),
])  # fmt: skip
def test_what_is_too_small_for_the_elements(
    vane: Values, casing: Values | None, size: float, message: str
) -> None:
    dimensions = VaneDimensions(**vane)
    shell = None if casing is None else CasingDimensions(**casing)
    said = refusal(lambda: check_size(size, dimensions, shell, 16))
    assert said.startswith(message)
    if shell is None:
        assert refusal(lambda: vane_segment(dimensions, size=size)) == said
    else:
        assert said.endswith(" up to 0.02 m")
        assert refusal(lambda: casing_sector(shell, size=size)) == said
        check_size(0.02, dimensions, shell, 16)
    if "fillet" in vane:  # elements are half as long where these are
        check_size(0.039, dimensions, None, 16)


@pytest.mark.parametrize(("changes", "sectors", "radius"), [
    ({}, 16, 0.003),
    ({"chord": 0.008, "thickness": 0.0006, "edge_thickness": 0.0003}, 160, 0.00191),
    ({"inner_shroud_front": 0.078}, 16, 0.0),  # nor does half of it
])  # fmt: skip
def test_a_root_fillet_is_chosen_that_fits(changes: Values, sectors: int, radius: float) -> None:
    vane = VaneDimensions(aerofoils=2, **changes)
    found = filleted(vane, sectors)
    assert found.root_fillet == pytest.approx(radius)
    check_vane(found, sectors)
    if 0 < radius < 0.003:
        larger = vane.model_copy(update={"root_fillet": radius + 1e-4})
        assert "root_fillet" in refusal(lambda: check_vane(larger, sectors))


def test_the_largest_fillets_that_fit_are_meshed() -> None:
    """At the limits of either part alone, where sides of half a millimetre are left."""
    one = VaneDimensions(aerofoils=1, root_fillet=0.012)
    largest = float(refusal(lambda: check_vane(one, 16)).split("at most ")[1].split()[0])
    assert 0.008 < largest < 0.012
    for part, least in (
        (casing_sector(CasingDimensions(fillet=0.00375), size=0.03), 0.0),
        (vane_segment(VaneDimensions(aerofoils=1, root_fillet=0, fillet=0.00525), size=0.03), 0.0),
        (vane_segment(one.model_copy(update={"root_fillet": largest}), size=0.03), 0.02),
    ):
        assert quality(part).smallest_jacobian > 0
        assert quality(part).smallest_sicn > least
