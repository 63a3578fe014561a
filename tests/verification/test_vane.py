"""The vane's physics, on the scene at its coarse size: limits, preload, peaks and slipping."""

from dataclasses import replace

import numpy as np
import pytest

from vanelock import rom
from vanelock.nonlinear import OPEN, STUCK, frequency_response, linear_response, static_response
from vanelock.nonlinear.law import SLIP, SLIP_OPEN


def changed(system, interlock, mu=None, v0=None, force=1.0):
    """The system with another interlock or a scaled force."""
    contacts = system.contacts
    if mu is not None:
        contacts = replace(contacts, mu=np.where(interlock, mu, contacts.mu))
    if v0 is not None:
        contacts = replace(contacts, v0=np.where(interlock, v0, contacts.v0))
    load = {h: rom.Force(f.vector * force, f.omega_power) for h, f in system.force.items()}
    return replace(system, contacts=contacts, force=load)


def second_mode(coarse):
    """Frequencies of the second ND 1 mode, interlock free and stuck, followed by MAC."""
    system = coarse.system
    free, shapes = rom.linear_modes(system, 1, 6, ~coarse.interlock)
    stuck, others = rom.linear_modes(system, 1, 6)
    agreement = rom.mac(shapes, others, system.at(1).M)[1]
    follower = int(np.argmax(agreement))
    return free[1], stuck[follower], agreement[follower]


def test_stuck_interlock_raises_the_second_mode(coarse):
    free, stuck, agreement = second_mode(coarse)
    assert agreement > 0.9
    assert 1.05 * free < stuck < 1.3 * free


@pytest.mark.parametrize("mu", [0.15, 0.3])
def test_interference_alone_closes_every_contact(coarse, mu):
    response = static_response(changed(coarse.system, coarse.interlock, mu))
    assert response.converged.all()
    assert response.residual[0] < 1e-10
    assert not np.any(response.state[0] == OPEN)
    normal = response.force[0, 0, :, 0].real
    assert normal.min() > 0
    # In equilibrium: the vane's contact forces and key reactions carry no net interlock force
    # beyond what its two faces give each other, so that right and left balance by construction.
    hooks = normal[~coarse.interlock]
    assert 100 < hooks.mean() < 500  # half of 1.67e7 N/m · 20 µm, less what the parts give way
    assert 0.5 < normal[coarse.interlock].mean() < 20  # near 1e6 N/m · 2 µm


@pytest.mark.parametrize("mu", [0.15, 0.3])
@pytest.mark.parametrize("harmonics", [1, 3])
def test_friction_holds_the_peak_down_between_the_linear_limits(coarse, mu, harmonics):
    system = changed(coarse.system, coarse.interlock, mu)
    free, stuck, _ = second_mode(coarse)
    limits = {}
    for name, frequency, closed in (("free", free, "hook"), ("stuck", stuck, "all")):
        band = frequency * (1 + 0.005 * np.linspace(-1, 1, 41))
        limits[name] = linear_response(system, band, closed).amplitude[:, 0].max()
    frequencies = np.linspace(free - 3, stuck + 3, 120)
    response = frequency_response(system, frequencies, harmonics=harmonics)
    assert response.converged.all()
    assert response.residual.max() < 1e-10
    curve = response.amplitude[:, 0].max(axis=1)
    peak = int(np.argmax(curve))
    assert curve[peak] < 0.6 * limits["free"]
    assert curve[peak] < 0.6 * limits["stuck"]
    assert free < frequencies[peak] < stuck
    slipping = np.isin(response.state[peak], (SLIP, SLIP_OPEN))
    assert slipping[coarse.interlock].mean() >= 0.3
    # The neighbouring points lie close: the maximum is a resonance peak, not a stray point.
    assert np.all(curve[[peak - 1, peak + 1]] > 0.9 * curve[peak])


@pytest.mark.parametrize("harmonics", [1, 3])
def test_a_thousandth_of_the_force_gives_the_stuck_linear_response(coarse, harmonics):
    free, stuck, _ = second_mode(coarse)
    frequencies = np.linspace(free - 3, stuck + 3, 25)
    system = changed(coarse.system, coarse.interlock, 0.3, force=1e-3)
    response = frequency_response(system, frequencies, harmonics=harmonics)
    expected = linear_response(system, frequencies, "all", harmonics=harmonics)
    assert response.converged.all()
    assert np.all(response.state == STUCK)
    scale = np.abs(expected.x[1]).max()
    for h in range(1, harmonics + 1):
        assert np.abs(response.x[h] - expected.x[h]).max() < 1e-8 * scale


def test_an_open_interlock_gives_the_free_linear_response(coarse):
    free, stuck, _ = second_mode(coarse)
    frequencies = np.linspace(free - 3, stuck + 3, 25)
    system = changed(coarse.system, coarse.interlock, v0=-1e-2, force=1.0)
    response = frequency_response(system, frequencies, harmonics=3)
    expected = linear_response(system, frequencies, "hook", harmonics=3)
    assert response.converged.all()
    assert np.all(response.state[:, coarse.interlock] == OPEN)
    assert np.all(response.state[:, ~coarse.interlock] == STUCK)
    scale = np.abs(expected.x[1]).max()
    for h in (1, 2, 3):
        assert np.abs(response.x[h] - expected.x[h]).max() < 1e-8 * scale
