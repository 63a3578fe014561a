"""Sliders assembled elsewhere: the law translated, a closed form, and two other methods."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Options,
    frequency_response,
    static_response,
)
from vanelock.rom.system.coordinates import check
from vanelock.rom.system.system import Contacts, Diameter, Force, System

Make = Callable[..., System]


def with_slider(system: System, slider: np.ndarray) -> System:
    return replace(system, contacts=replace(system.contacts, slider=slider))


def one_contact(slider: float) -> System:
    """Two masses on springs of 1 N/m, pressed together by an interference; the first is pushed."""
    own = np.array([[[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]])
    return System(
        sectors=1,
        engine_order=0,
        diameters={0: Diameter(K=np.eye(2), M=np.eye(2), own=own, output=own)},
        contacts=Contacts(
            np.array([0.5]),
            np.array([[0.8, 0.8]]),
            np.array([0.3]),
            np.array([1.0]),
            slider=np.array([[slider, 0.0]]),
        ),
        force={0: Force(np.array([0.02, 0.0], complex))},
        output_names=("place",),
        damping_ratio=0.01,
    )


@pytest.mark.parametrize("slider", [0.0, 0.05, -0.1])
def test_static_friction_is_what_the_slider_says(slider: float) -> None:
    found = static_response(one_contact(slider))
    moved = (0.02 + 0.8 * slider) / 1.8
    assert found.force[0, 0, 0, 1] == pytest.approx(0.8 * (moved - slider), abs=1e-14)


def test_a_slider_beyond_the_bound_slips_to_it() -> None:
    bound = 0.3 * 0.5 * (2 / 3)
    found = static_response(one_contact(1.0))
    assert found.force[0, 0, 0, 1] == pytest.approx(-bound, rel=1e-12)


def test_zero_sliders_change_no_bit(random_system: Make) -> None:
    system = random_system(3, size=6, contacts=2)
    hertz, options = [0.2, 0.3], Options(3)
    given = with_slider(system, np.zeros((2, 2)))
    found = frequency_response(given, hertz, options, find_jumps=False)
    expected = frequency_response(system, hertz, options, find_jumps=False)
    np.testing.assert_array_equal(found.output, expected.output)


def test_a_saved_system_keeps_its_sliders(random_system: Make, tmp_path) -> None:
    slider = np.arange(12.0).reshape(6, 2)
    with_slider(random_system(1), slider).save(tmp_path / "system.h5")
    np.testing.assert_array_equal(System.load(tmp_path / "system.h5").contacts.slider, slider)


@pytest.mark.parametrize(
    ("slider", "message"),
    [
        (np.zeros((5, 2)), r"contact/slider has shape \(5, 2\), not \(6, 2\)"),
        (np.full((6, 2), np.nan), "contact/slider holds values that are not finite"),
    ],
)
def test_wrong_sliders_are_refused(random_system: Make, slider: np.ndarray, message: str) -> None:
    with pytest.raises(InputError, match=message):
        check(with_slider(random_system(1), slider))
