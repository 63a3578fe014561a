"""Isotropic friction in time: the step's own equations, its order, and the harmonic balance."""

import numpy as np
import pytest

from tests.nonlinear.systems import even, planar, random_system, with_contacts
from vanelock.common.errors import InputError
from vanelock.nonlinear import SLIP, SLIP_OPEN, STUCK, Options, frequency_response, time_response

HERTZ, RATIO = 1.05 / (2 * np.pi), 0.03


@pytest.mark.parametrize(
    ("swing", "v0", "shake", "state"),
    [
        (0.7j, 2.0, 0.0, SLIP),  # nearly a circle under constant load
        (0.5 + 0.2j, 2.0, 1.2, SLIP),  # an ellipse, the normal load varies
        (0.5j, 0.8, 2.0, SLIP_OPEN),
    ],
)
def test_steady_states_are_those_of_the_balance(swing, v0, shake, state):
    system, counts = planar(swing, 0.6, v0, shake, RATIO), np.array([128, 256, 512, 1024])
    balance = frequency_response(system, [HERTZ], Options(41, friction="isotropic"))
    each = frequency_response(system, [HERTZ], Options(41))
    exact = balance.contact[0, :21]
    scale, errors = np.abs(exact[1]).max(), []
    for steps in counts:
        found = time_response(system, HERTZ, 60, int(steps), 20, friction="isotropic")
        assert found.unsolved == 0
        assert found.defect[-1] < 1e-10
        assert found.state[0, 0] == balance.state[0, 0] == state
        errors.append(np.abs(found.contact[:, 0] - exact).max() / scale)
        np.testing.assert_allclose(
            found.dissipation[0], balance.dissipation[0], rtol=3 * (32 / steps) ** 2
        )
    assert errors[-1] < 1e-5
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] < -1.5
    # Friction bounded in each direction by itself is another law.
    assert np.abs(each.contact[0, :21] - exact).max() > 1e3 * errors[-1] * scale
    begun = time_response(system, HERTZ, 2, 1024, 20, (balance, 0), friction="isotropic")
    assert begun.departure.max() < 5e-5


def test_what_sticks_is_in_its_steady_state_at_once():
    system = planar(0.7j, 3.0, 2.0, 0.3, RATIO)
    balance = frequency_response(system, [HERTZ], Options(3, friction="isotropic"))
    assert balance.state[0, 0] == STUCK
    found = time_response(system, HERTZ, 2, 64, 3, friction="isotropic")
    scale = np.abs(balance.contact[0, 1]).max()
    np.testing.assert_allclose(found.contact[:, 0], balance.contact[0], atol=1e-12 * scale)


def test_sectors_of_a_ring_repeat_the_wave():
    system = random_system(4, size=8, contacts=2, preload=2.0, sectors=5, damping_ratio=0.03)
    system = even(system)
    hertz, errors = 0.16, []
    balance = frequency_response(system, [hertz], Options(15, friction="isotropic"))
    assert {SLIP, SLIP_OPEN} & set(balance.state[0])
    lag = np.exp(-2j * np.pi * np.outer(np.arange(16), np.arange(5)) / 5)[..., None, None]
    for steps in (256, 1024):
        found = time_response(
            system, hertz, 60, steps, 15, (balance, 0), 1e-9, friction="isotropic"
        )
        apart = np.abs(found.contact - lag * balance.contact[0][:, None]).max()
        errors.append(apart / np.abs(balance.contact[0, 1]).max())
    assert errors[0] < 1e-3
    assert errors[1] < 0.2 * errors[0]


def test_a_start_has_the_law_that_is_followed():
    system = planar(0.7j, 0.6, 2.0, 0.0, RATIO)
    response = frequency_response(system, [HERTZ], Options(1))
    with pytest.raises(InputError, match="with orthogonal friction.*needs one with isotropic"):
        time_response(system, HERTZ, start=(response, 0), friction="isotropic")
    with pytest.raises(InputError, match="friction: given 'round': allowed: orthogonal, isotropic"):
        time_response(system, HERTZ, friction="round")
    uneven = with_contacts(system, kt=np.array([[1.0, 2.0]]))
    with pytest.raises(InputError, match="contact 0 has kt"):
        time_response(uneven, HERTZ, friction="isotropic")
