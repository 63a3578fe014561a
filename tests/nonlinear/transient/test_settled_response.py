"""What a ring does instead of a wave: back to it, or away as its multiplier says, and settled."""

from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.nonlinear.systems import with_contacts
from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    MODULATED,
    STEADY,
    UNSETTLED,
    Options,
    frequency_response,
    settled_response,
    stability,
)
from vanelock.nonlinear.transient.settled_response import _verdict

STAYS, LEAVES = 0, 1
"""Rings of which the largest multiplier is 0.752 and 1.0707."""


@lru_cache
def wave(seed, friction="orthogonal", harmonics=9):
    """A ring, and its wave where friction with lift-off holds the peak down most."""
    _, force, frequency = worst_of(seed)["lift"]
    system = loaded(spring_ring(seed), force)
    if friction == "isotropic":
        kt = system.contacts.kt.mean(axis=1)
        system = with_contacts(system, kt=np.column_stack([kt, kt]))
    return system, frequency_response(system, [frequency], Options(harmonics, friction=friction))


def statistics(found):
    return np.array([found.mean, found.largest, found.smallest])[:, 0]


@pytest.mark.parametrize("friction", ["orthogonal", "isotropic"])
def test_a_ring_comes_back_to_a_stable_wave(friction):
    system, response = wave(STAYS, friction)
    errors = []
    for steps in (64, 256):
        found = settled_response(system, response, 0, steps, disturbance=1e-3, growth=0.0)
        assert found.verdict == STEADY
        assert found.returned
        assert found.defect[0] > 1e3 * found.defect[-1]
        assert found.largest == pytest.approx(found.smallest, rel=1e-3)
        errors.append(np.abs(statistics(found) / response.amplitude[0, 0] - 1).max())
    assert errors[1] < 3e-4
    assert errors[1] < errors[0] / 3


def test_a_ring_leaves_an_unstable_wave_by_its_multiplier():
    """Before that the wave itself, and after that what is no longer small, bend the growth."""
    system, response = wave(LEAVES, harmonics=41)
    multiplier = float(np.abs(stability(system, response, harmonics=41).multiplier[0, 0]))
    found = settled_response(system, response, 0, 256, disturbance=1e-5)
    small = np.flatnonzero(found.defect > 5e-3)[0]
    grows = slice(small - 40, small)
    rate = np.polyfit(np.arange(40), np.log(found.defect[grows]), 1)[0]
    assert np.exp(rate) == pytest.approx(multiplier, abs=3e-3)
    assert found.verdict == MODULATED
    assert not found.returned
    assert found.departure[-found.window :].min() > 0.1


def test_what_has_not_settled_says_so():
    system, response = wave(LEAVES)
    short = settled_response(system, response, 0, periods=60)
    assert (short.verdict, short.periods) == (UNSETTLED, 60)
    # One that came to rest, but was not followed as long as asked for, has not either.
    system, response = wave(STAYS)
    rest = settled_response(system, response, 0, periods=60, least=200, growth=0.0)
    assert rest.verdict == UNSETTLED


def test_a_second_motion_on_its_way_is_waited_for():
    """Two motions grow, 1.267 and 1.158 a period: the first alone seems settled after 72."""
    _, force, frequency = worst_of(LEAVES)["lift"]
    system = loaded(spring_ring(LEAVES), 1.5 * force)
    response = frequency_response(system, [frequency], Options(5))
    followed = partial(settled_response, system, response, 0, 64)
    for need, ends in ((71.5, 72), (72.5, 108)):
        growth = 2 * np.log(1e4) / need * frequency
        assert followed(periods=108, growth=growth).periods == ends
    found = followed(periods=360)
    assert found.verdict == UNSETTLED
    early, late = (
        found.amplitude[part, :, 0].max((0, 1)) for part in (slice(48, 72), slice(336, 360))
    )
    assert late[2] > 1.4 * early[2]


@pytest.mark.parametrize("seed", [0, 1])
def test_what_grows_slowly_is_not_hidden_by_what_dies_out(seed):
    """A wave that a ring leaves slowly is not taken for one that it stays with, growth unknown."""
    system, frequency = loaded(spring_ring(20), 0.7101), worst_of(20)["lift"][2]
    response = frequency_response(system, [frequency], Options(9))
    assert 1.002 < np.abs(stability(system, response).multiplier[0, 0]) < 1.004
    found = settled_response(system, response, 0, periods=200, seed=seed, growth=0.0)
    assert found.verdict != STEADY


@pytest.mark.parametrize(
    ("growth", "above", "verdict"),
    [
        (1.002, 1.0, UNSETTLED),  # amplitudes are alike, but may be those of the wave yet
        (1.002, 20.0, MODULATED),
        (1.01, 20.0, UNSETTLED),  # still growing
        (0.9, 1.0, STEADY),
        (1.02, 1e-4, UNSETTLED),  # small, and growing
    ],
)
def test_a_disturbance_on_its_way_is_no_verdict(growth, above, verdict):
    defect: NDArray[np.float64] = np.multiply(1e-2 * above, np.power(growth, np.arange(150)))
    defect[0] = 1e-2
    assert _verdict(np.ones((150, 4, 1, 3)), defect, 0.02) == verdict


def test_sectors_that_are_excited_alike_are_followed_one_by_one():
    """A disturbance that they do not share is there, and dies out."""
    system, _ = wave(STAYS)
    alike = replace(system, engine_order=system.sectors)
    response = frequency_response(alike, [0.12], Options(5))
    found = settled_response(alike, response, 0, disturbance=1e-2, growth=0.0)
    assert found.amplitude.shape[1] == system.sectors
    assert np.ptp(found.amplitude[0, :, 0, 0]) > 1e-3 * response.amplitude[0, 0, 0]
    assert np.ptp(found.amplitude[-1, :, 0, 0]) < 1e-4 * response.amplitude[0, 0, 0]
    assert found.returned


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"point": 1}, "point: given 1: there are 1, counted from 0"),
        ({"steps": 39}, "steps: given 39: allowed: 40 or more"),
        ({"periods": 47}, "periods: given 47: allowed: 48 or more"),
        ({"tolerance": 1.0}, "tolerance: given 1.0: allowed: from 0 to below 1"),
        ({"seed": -1}, "seed: given -1: allowed: 0 or more"),
        ({"modes": 0}, "modes: given 0: allowed: 1 or more"),
    ],
)
def test_what_cannot_be_followed_is_refused(more, message):
    system, response = wave(STAYS)
    with pytest.raises(InputError, match=message):
        settled_response(system, response, **{"point": 0, **more})


def test_a_point_that_did_not_converge_is_no_wave():
    system, response = wave(STAYS)
    lost = replace(response, converged=np.array([False]))
    with pytest.raises(InputError, match="point: given 0: it did not converge"):
        settled_response(system, lost, 0)
