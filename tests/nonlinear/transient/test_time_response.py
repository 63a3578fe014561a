"""Time integration of the ring: its own accuracy, against other integrators and the whole ring."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import random_system
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    time_response,
)


def single(mu, force, v0):
    """A mass on a spring of 1 N/m that slides on the ground, and one that bounces."""
    one = {0: Diameter(K=np.eye(2), M=np.eye(2), own=np.array([[[0, 1], [1, 0.3], [0, 0]]]))}
    contacts = Contacts([1.0], [[0.8, 0.8]], [mu], [v0])
    return System(1, 0, one, contacts, {1: Force([force, 0.3 * force])}, damping_ratio=0.03)


@pytest.mark.parametrize("v0", [1.0, 0.1, -0.1])
def test_error_falls_with_the_square_of_the_step(v0):
    # Where in a step a state changes scatters the error; the order shows over many steps.
    system, steps = single(0.4, 0.5, v0), np.array([50, 100, 200, 400, 800, 1600])
    exact = time_response(system, 0.17, 30, 12800).contact
    found = [time_response(system, 0.17, 30, int(count)).contact for count in steps]
    errors = np.array([np.abs(each - exact).max() for each in found]) / np.abs(exact[1]).max()
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] < -1.7
    assert errors[3] < 5e-5


def test_missing_diameters_are_named():
    system = random_system(1, sectors=7, harmonics=1)
    with pytest.raises(InputError, match="nodal diameters 2, 3"):
        time_response(system, 0.1)


def test_what_the_integration_does_not_know_is_refused():
    system = single(0.4, 0.5, 0.1)
    response = frequency_response(system, [0.17, 0.2], Options(3))
    for start, message in (
        ((response, 2), "given point 2: the response has 2"),
        ((response, 1), "given a point at 0.2 Hz: needs one at 0.17 Hz"),
        ((replace(response, friction="isotropic"), 0), "needs one with orthogonal"),
        ((replace(response, harmonic_diameters=np.array([0, 0, 0, 1])), 0), "nodal diameters"),
    ):
        with pytest.raises(InputError, match=message):
            time_response(system, 0.17, start=start)
    matrices = replace(system.at(0), C=np.array([[0.1, 0.05], [0.05, 0.1]]))
    with pytest.raises(InputError, match="nd/0/C: given one that couples the modes"):
        time_response(replace(system, diameters={0: matrices}), 0.17)
    with pytest.raises(InputError, match="steps: given 30: allowed: 40 or more"):
        time_response(system, 0.17, steps=30)


def test_linear_ring_is_in_its_steady_state_at_once():
    # So much preload and friction that all sticks: the motion is the balance's, nothing to settle.
    system = random_system(3, preload=1e3, mu=50.0, sectors=6, engine_order=-1, harmonics=5)
    response = frequency_response(system, [0.3], Options(2))
    found = time_response(system, 0.3, 2, 64, 2)
    assert found.defect.max() < 1e-12
    lag = np.exp(2j * np.pi * np.arange(6) / 6)[:, None, None]
    for name in ("contact", "force", "output"):
        given, expected = getattr(found, name), getattr(response, name)[0]
        for h in range(3):
            scale = np.abs(expected[:2]).max()
            assert np.abs(given[h] - lag**h * expected[h]).max() < 1e-10 * scale
    for h in range(3):
        assert np.abs(found.x[h] - response.x[h][0]).max() < 1e-10 * np.abs(response.x[1]).max()
