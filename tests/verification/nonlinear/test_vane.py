"""The vane's physics: linear limits, preload, peaks and slipping."""

import numpy as np
import pytest

from tests.nonlinear.systems import rows, solved_response, stuck_damping
from tests.verification.vane import interlocked, second_mode
from vanelock.nonlinear import (
    OPEN,
    STUCK,
    Options,
    linear_response,
    static_response,
)


def test_stuck_interlock_raises_the_second_mode(scene, record):
    free, stuck, agreement = second_mode(scene.system)
    record("free", f"{free:.2f} Hz")
    record("stuck", f"{stuck:.2f} Hz")
    record("MAC", f"{agreement:.3f}")
    assert agreement > 0.9
    assert 1.05 * free < stuck < 1.3 * free


@pytest.mark.parametrize("mu", [0.15, 0.3])
def test_interference_alone_closes_every_contact(scene, mu, record):
    response = static_response(interlocked(scene.system, mu))
    assert response.converged.all()
    assert response.residual[0] < 1e-10
    assert not np.any(response.state[0] == OPEN)
    normal = response.force[0, 0, :, 0].real
    for joint in ("hook", "interlock"):
        of_joint = normal[scene.interlock == (joint == "interlock")]
        record(joint, f"{of_joint.min():.2f} to {of_joint.max():.2f} N")
    assert normal.min() > 0
    hooks = normal[~scene.interlock]
    stiff = (scene.system.contacts.kn * scene.system.contacts.v0)[~scene.interlock]
    assert 0.3 < (hooks / stiff).mean() < 1.5  # half of kn v0, less what the parts give way
    stiff = (scene.system.contacts.kn * scene.system.contacts.v0)[scene.interlock]
    assert 0.25 < (normal[scene.interlock] / stiff).mean() < 10  # near kn v0


@pytest.mark.parametrize("mu", [0.15, 0.3])
@pytest.mark.parametrize("harmonics", [1, 3])
def test_friction_holds_the_peak_down_between_the_linear_limits(scene, mu, harmonics, record):
    system = interlocked(scene.system, mu)
    free, stuck, _ = second_mode(scene.system)
    limits = {}
    for name, frequency, closed in (("free", free, "hook"), ("stuck", stuck, "all")):
        band = frequency * (1 + 0.005 * np.linspace(-1, 1, 41))
        limits[name] = linear_response(system, band, closed).amplitude[:, 0].max()
    frequencies = np.linspace(free - 3, stuck + 3, 120)
    response = solved_response(system, frequencies, Options(harmonics))
    assert response.residual.max() < 1e-10
    curve = response.amplitude[:, 0].max(axis=1)
    peak = int(np.argmax(curve))
    work = response.dissipation[peak]
    slipping = work > 1e-6 * work.max()  # whether or not it lifts off as well
    record("peak / free", f"{curve[peak] / limits['free']:.3f}")
    record("peak / stuck", f"{curve[peak] / limits['stuck']:.3f}")
    record("x", f"{(frequencies[peak] - free) / (stuck - free):.3f}")
    record("slipping", f"{slipping[scene.interlock].mean():.0%}")
    assert curve[peak] < 0.6 * limits["free"]
    assert curve[peak] < 0.6 * limits["stuck"]
    assert free < frequencies[peak] < stuck
    assert slipping[scene.interlock].mean() >= 0.3
    # The neighbouring points lie close: the maximum is a resonance peak, not a stray point.
    assert np.all(curve[[peak - 1, peak + 1]] > 0.9 * curve[peak])


def direct_solution(system, frequencies, closed):
    """Linear harmonic 1 by its definition: one dense solve a frequency, no modes condensed."""
    one, C, B = system.at(1), stuck_damping(system, 1), rows(system, 1)[np.repeat(closed, 3)]
    K = one.K + (B.conj().T * system.contacts.stiffness[closed].ravel()) @ B
    return np.array(
        [
            np.linalg.solve(K + 1j * w * C - w**2 * one.M, system.force[1].at(w))
            for w in 2 * np.pi * frequencies
        ]
    )


def difference(response, expected):
    """Largest difference of the coordinates' harmonics h >= 1 from a linear harmonic 1."""
    largest = np.abs(response.x[1] - expected).max()
    higher = [np.abs(x).max() for h, x in response.x.items() if h > 1]
    return max([largest, *higher]) / np.abs(expected).max()


@pytest.mark.parametrize("harmonics", [1, 3])
def test_a_thousandth_of_the_force_gives_the_stuck_linear_response(scene, harmonics, below):
    free, stuck, _ = second_mode(scene.system)
    frequencies = np.linspace(free - 3, stuck + 3, 25)
    system = interlocked(scene.system, 0.3, load=1e-3)
    response = solved_response(system, frequencies, Options(harmonics))
    expected = direct_solution(system, frequencies, np.full(system.contacts.count, True))
    assert np.all(response.state == STUCK)
    error = difference(response, expected)
    below("difference", error, 1e-8)


def test_an_open_interlock_gives_the_free_linear_response(scene, below):
    free, stuck, _ = second_mode(scene.system)
    frequencies = np.linspace(free - 3, stuck + 3, 25)
    system = interlocked(scene.system, v0=-1e-2)
    response = solved_response(system, frequencies, Options(3))
    expected = direct_solution(system, frequencies, ~scene.interlock)
    assert np.all(response.state[:, scene.interlock] == OPEN)
    assert np.all(response.state[:, ~scene.interlock] == STUCK)
    error = difference(response, expected)
    below("difference", error, 1e-8)
