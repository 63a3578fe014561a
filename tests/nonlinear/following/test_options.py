"""Couplings, friction and other options of what is followed, against responses by frequency."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.following.test_parameters import changed
from vanelock.nonlinear import (
    SLIP_OPEN,
    STUCK,
    Options,
    Response,
    System,
    frequency_response,
    hysteresis,
    parameter_response,
    peak_response,
)
from vanelock.nonlinear.following.parameter_response import _NAMES
from vanelock.rom.system.system import Force

Make = Callable[..., System]
Lowest = Callable[[System], float]

METHODS = [
    ("coupled", "isotropic"),
    ("uncoupled", "orthogonal"),
    ("uncoupled", "isotropic"),
    ("constant-load", "orthogonal"),
    ("constant-load", "isotropic"),
]


def taken_in_turn(names: Sequence[str]) -> list[tuple[str, str, str]]:
    """Every method with one of the parameters."""
    return [(names[i % len(names)], *method) for i, method in enumerate(METHODS)]


@pytest.fixture
def even(random_system: Make) -> System:
    """Six contacts, as stiff in either tangential direction, under a static load too."""
    system = random_system(1, preload=3.0)
    contacts = replace(system.contacts, kt=system.contacts.kt[:, [0, 0]])
    static = Force(np.full(len(system.at(0).K), 0.3 + 0j))
    return replace(system, contacts=contacts, force={0: static, **system.force})


def differ(one: Response, other: Response) -> float:
    """Largest difference of contacts, forces and outputs, each relative to the largest."""
    worst = 0.0
    for name in ("contact", "force", "output"):
        expected = getattr(other, name)
        apart = np.abs(getattr(one, name) - expected).max()
        worst = max(worst, float(apart / np.abs(expected).max()))
    return worst


@pytest.mark.parametrize(("coupling", "friction"), METHODS)
def test_hysteresis_is_that_of_sweeps_by_frequency(
    even: System, first_frequency: Lowest, coupling: str, friction: str
) -> None:
    hertz = np.linspace(0.8, 1.5, 7) * first_frequency(even)
    options = Options(2, coupling, friction)
    found = hysteresis(even, hertz, options)
    assert found.complete
    assert found.connected
    for sweep, direction in ((found.up, "up"), (found.down, "down")):
        direct = frequency_response(
            even, hertz, replace(options, direction=direction), find_jumps=False
        )
        assert direct.converged.all()
        assert differ(sweep, direct) < 1e-11
        assert (sweep.coupling, sweep.friction) == (coupling, friction)
        assert sweep.samples == 0
    if not len(found.fold):
        direct = frequency_response(even, found.branch.frequency, options, find_jumps=False)
        assert differ(found.branch, direct) < 1e-9
    assert len(found.fold) == (2 if coupling == "coupled" else 0)


@pytest.mark.parametrize(("name", "coupling", "friction"), taken_in_turn(list(_NAMES)))
def test_along_a_parameter_points_are_those_of_systems_changed_by_hand(
    even: System, first_frequency: Lowest, name: str, coupling: str, friction: str
) -> None:
    hertz, options = 1.3 * first_frequency(even), Options(2, coupling, friction)
    values = np.linspace(-1, 6, 4) if name == "interference" else np.geomspace(0.03, 0.6, 4)
    found = parameter_response(even, hertz, name, values, options)
    assert found.response.converged.all()
    assert np.any(found.response.dissipation > 0)
    for i, value in enumerate(values):
        system = changed(even, name, value, np.ones(6, bool))
        assert differ(found.at(i), frequency_response(system, [hertz], options)) < 1e-8


@pytest.mark.parametrize(("name", "coupling", "friction"), taken_in_turn(list(_NAMES)[::-1]))
def test_peaks_are_the_largest_of_a_fine_sweep(
    sliding_system: Make, name: str, coupling: str, friction: str
) -> None:
    system = sliding_system(preload=0.6)
    exact = 1e-6 if friction == "isotropic" else 1e-9  # slip in the plane is collocated
    options = Options(3, coupling, friction)
    values = [0.5, 1.0, 2.0] if name != "mu" else [0.1, 0.3, 0.6]
    found = peak_response(system, name, values, (0.15, 0.22), options)
    assert found.converged.all()
    assert not np.any(found.response.state == STUCK)
    for i, value in enumerate(values):
        moved = changed(system, name, value, np.ones(1, bool))
        hertz = found.frequency[i] + found.width[i] * np.linspace(-1, 1, 41)
        swept = frequency_response(moved, hertz, options, find_jumps=False)
        size = swept.amplitude[:, 0, found.direction]
        assert size.max() < (1 + exact) * found.amplitude[i]
        assert abs(int(size.argmax()) - 20) <= (0 if exact < 1e-8 else 1)
        assert differ(found.at(i), swept.at([20])) < 1e-8


def test_modes_left_out_are_estimated_wherever_a_state_was_solved(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(1, preload=3.0)
    hertz = 1.3 * first_frequency(system)
    # Of a range, the highest frequency counts.
    options, ends = Options(2, static_beyond=2.0), (0.9 * hertz, hertz)
    along = parameter_response(system, hertz, "mu", [0.2, 0.3], options).response
    direct = frequency_response(system, [hertz], options)
    assert differ(along.at([1]), direct) < 1e-8
    assert direct.truncation[0] > 1e-3
    assert along.truncation[1] == pytest.approx(direct.truncation[0], rel=1e-3)
    both = hysteresis(system, ends, replace(options, coupling="uncoupled"))
    swept = frequency_response(
        system, both.branch.frequency, replace(options, coupling="uncoupled")
    )
    assert SLIP_OPEN in swept.state
    np.testing.assert_allclose(both.branch.truncation, swept.truncation, rtol=1e-2)
