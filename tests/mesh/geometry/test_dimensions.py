"""Dimensions: units, defaults of the scene, and what is refused before meshing, by name."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import CasingDimensions, HookDimensions, VaneDimensions, check_fit
from vanelock.mesh.checks import _gap
from vanelock.mesh.element_size import element_size
from vanelock.mesh.geometry.aerofoil import around


def test_lengths_and_angles_take_units() -> None:
    vane = VaneDimensions(chord="54 mm", stagger="0.5 rad", hook={"roof_radius": "59.2 cm"})
    assert vane.chord == pytest.approx(0.054, rel=1e-15)
    assert vane.stagger == pytest.approx(28.64788975654116, rel=1e-14)
    assert vane.hook.roof_radius == pytest.approx(0.592, rel=1e-15)


def test_every_dimension_says_what_it_is() -> None:
    for model in (VaneDimensions, CasingDimensions, HookDimensions):
        for name, field in model.model_fields.items():
            assert name == "hook" or len(field.description or "") > 15, name


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


@pytest.mark.parametrize("step", [0.5, 1.5, 2.5, 4.0])
def test_circles_are_a_diameter_nearer_than_their_middles(step: float) -> None:
    """By how much they cross, too, wherever they stand."""
    angle = 2 * np.pi * np.arange(400) / 400
    circle = np.column_stack([3 + np.cos(angle), -7 + np.sin(angle)])
    assert _gap(circle, step) == pytest.approx(step - 2, abs=1e-4)
