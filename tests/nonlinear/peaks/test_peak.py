"""Peaks followed along a parameter, and their gradients: closed forms, sweeps, differences."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.nonlinear.systems import first_frequency, jenkins_element, random_system, solved_response
from tests.refusals import refused
from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    STUCK,
    AmplitudeGradient,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    peak_gradient,
    peak_gradient_of,
    peak_response,
)
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.families import Frequencies
from vanelock.nonlinear.fourier import TURN
from vanelock.nonlinear.newton.newton import solve
from vanelock.nonlinear.peaks.peak import Resonance
from vanelock.nonlinear.peaks.peak_gradient import _gradient_of_peak

K, KT, DAMPING = 1.0, 0.6, 0.01
NEAR = (0.1, 0.3)


def jenkins(force=1.0, mu=0.5, v0=1.0):
    """A unit mass on a spring and a friction element of constant normal load, 2 N/m · v0."""
    row = [[[0.0], [1.0], [0.0]]]
    one = Diameter(K=[[K]], M=[[1.0]], C=[[DAMPING]], own=row, output=row)
    contacts = Contacts([2.0], [[KT, KT]], [mu], [v0], ("pad",))
    return System(1, 0, {0: one}, contacts, {1: Force([force])}, ("mass",))


def jenkins_peak(force, limit, damping=DAMPING):
    """Frequency, Hz, and amplitude of its peak at H = 1, with the friction limit μn.

    With the describing function of the Jenkins element, F = X |Z(X, ω)|; the peak at a given
    force is where |Z| is stationary in ω, a cubic equation in ω at every X.
    """

    def impedance(X):
        stiffness = jenkins_element(X, KT, limit)[0] if X > limit / KT else KT + 0j
        spring, loss = stiffness.real, stiffness.imag
        # d/dω [(k - ω²)² + (cω + b)²] = 0
        roots = np.roots([2, 0, damping**2 - 2 * (K + spring), damping * loss])
        omega = max(roots[np.abs(roots.imag) < 1e-12].real)
        return omega, abs(K + spring - omega**2 + 1j * (damping * omega + loss))

    X = brentq(lambda X: X * impedance(X)[1] - force, 1e-9, 1e4, xtol=1e-15, rtol=1e-14)
    return impedance(X)[0] / TURN, X


def check_against_closed_form(found, peaks):
    assert found.converged.all()
    frequency, amplitude = np.array(peaks).T
    np.testing.assert_allclose(found.amplitude, amplitude, rtol=1e-9)
    np.testing.assert_allclose(found.frequency, frequency, rtol=1e-8)


def test_backbone_of_a_jenkins_oscillator_is_that_of_its_describing_function():
    values = np.geomspace(1e-3, 10, 33)
    found = peak_response(jenkins(), "force", values, NEAR, Options(1))
    assert found.output == "mass"
    assert found.direction == 1
    np.testing.assert_array_equal(found.parameter, values)
    check_against_closed_form(found, [jenkins_peak(float(value), 1.0) for value in values])
    stuck = found.states[:, STUCK] == 1
    assert 3 < stuck.sum() < 30
    # Where it sticks, half the half-power bandwidth is c / 2.
    np.testing.assert_allclose(found.width[stuck] * TURN, DAMPING / 2, rtol=2e-3)
    # Friction and the damper take what the force gives: at the peak of so light a damping the
    # force is nearly in quadrature.
    omega, X = TURN * found.frequency, found.amplitude
    lost = found.dissipation + np.pi * DAMPING * omega * X**2
    given = np.pi * values * -found.response.output[:, 1, 0, 1].imag
    np.testing.assert_allclose(lost, given, rtol=1e-8)


def test_backbones_from_the_other_side_and_at_steps_of_their_own():
    up = peak_response(jenkins(), "force", [0.05, 0.5, 5.0], NEAR, Options(1))
    down = peak_response(jenkins(), "force", [5.0, 0.5, 0.05], NEAR, Options(1))
    np.testing.assert_allclose(up.amplitude, down.amplitude[::-1], rtol=1e-9)
    calls = list[tuple[int, int, float, float]]()
    own = peak_response(
        jenkins(), "force", (1e-2, 10.0), NEAR, Options(1), progress=lambda *now: calls.append(now)
    )
    assert own.parameter[[0, -1]].tolist() == [1e-2, 10.0]
    assert 25 < len(own.parameter) < 200
    check_against_closed_form(own, [jenkins_peak(float(value), 1.0) for value in own.parameter])
    assert [each[0] for each in calls] == list(range(1, len(calls) + 1))
    assert calls[-1][:3] == (len(calls), len(calls), 10.0)
    # A straight line between two points, both logarithmic, is as good as the eye needs.
    middle = np.sqrt(own.parameter[1:] * own.parameter[:-1])
    drawn = np.sqrt(own.amplitude[1:] * own.amplitude[:-1])
    exact = [jenkins_peak(float(value), 1.0)[1] for value in middle]
    np.testing.assert_allclose(drawn, exact, rtol=0.03)


@pytest.mark.parametrize(("name", "factor"), [("mu", 2.0), ("interference", 1.0)])
def test_friction_that_damps_most_is_the_one_known(name, factor):
    # Without a damper X = (μn)² / (kt (μn - πF/4)): least at μn = πF/2, where X = πF/kt.
    values = np.geomspace(0.1, 10, 41)
    found = peak_response(jenkins(mu=0.5, v0=1.0), name, values, NEAR, Options(1), joint="pad")
    limits = factor * values
    check_against_closed_form(found, [jenkins_peak(1.0, float(limit)) for limit in limits])
    best = int(np.argmin(found.amplitude))
    assert 0.8 < limits[best] / (np.pi / 2) < 1.2
    assert 0.9 < found.amplitude[best] / (np.pi / KT) < 1.0  # the damper helps a little


@pytest.mark.parametrize("harmonics", [1, 3])
def test_slope_of_the_amplitude_is_exact(harmonics):
    system = random_system(5, preload=10.0, damping_ratio=0.01)  # on a rotating unbalance
    system = replace(system, force={1: Force(system.force[1].vector * 20, omega_power=2)})
    family = Frequencies(structure(system, harmonics), contact_law(system.contacts, harmonics))
    resonance = Resonance(family, (0, 2), 1e-13)
    omega = TURN * 1.4 * first_frequency(system)
    found = solve(family, np.zeros((6, 3, 2 * harmonics + 1)), omega, tolerance=1e-13)
    assert found.converged
    assert np.count_nonzero(found.deviation.state != STUCK) > 1
    step = 1e-5 * omega
    sides: Any = [resonance.read(omega + i * step, found.w) for i in (-1, 0, 1)]
    below, here, above = sides
    measured = (above.amplitude - below.amplitude) / (2 * step)
    np.testing.assert_allclose(here.slope, measured, rtol=1e-6)
    response = frequency_response(system, [omega / TURN], Options(harmonics))
    np.testing.assert_allclose(here.amplitude, response.amplitude[0, 0, 2], rtol=1e-9)


def test_friction_alone_bounds_a_peak_that_something_varies():
    # A period takes 4 μn X of work and gives π F X: friction alone bounds where μn > π F/4.
    (diameter,) = jenkins().diameters.values()
    system = replace(jenkins(), diameters={0: replace(diameter, C=None)})
    bound = 1.3 * np.pi / 8
    found = peak_response(system, "mu", [bound], NEAR, Options(1))
    check_against_closed_form(found, [jenkins_peak(1.0, 2 * bound, 0.0)])
    alone = System.from_matrices(np.eye(1), np.eye(1), damping_ratio=0.01, force={0: 1.0})
    with pytest.raises(InputError, match=r"parameter: given 'mu': the system has no contacts"):
        peak_response(alone, "mu", [bound], NEAR, Options(1))


@pytest.mark.parametrize(("options", "message"), [
    ({"values": (1.0, 1.0)}, "values: given .*: a range is"),
    ({"near": (0.3, 0.1)}, "near: given"),
    ({"near": (0.3, 0.5)}, "near: no peak was found in it at force = 1"),
    ({"options": Options(0)}, "harmonics: given 0"),
    ({"output": ("tip", 0)}, "output: given 'tip': allowed: mass"),
    ({"output": ("mass", 3)}, "output: given direction 3"),
    ({"output": "tip"}, r"output: given 'tip': needs \(text, a whole number\)"),
    ({"values": ["a"]}, "values: given .*: needs an array of numbers"),
])  # fmt: skip
def test_impossible_arguments_are_refused(options, message):
    arguments = {"parameter": "force", "values": [1.0], "near": NEAR, **options}
    refused(message, peak_response, jenkins(), **arguments)
    bare = replace(jenkins(), output_names=())
    refused("no output nodes", peak_response, bare, "force", [1.0], NEAR, Options(1))


def slipping(seed, kind="slip", **changes):
    """A ring under the load that friction damps most, and a range about its peak, Hz."""
    kinds = worst_of(seed)
    _, force, hertz = kinds.get(kind) or next(iter(kinds.values()))
    system = replace(loaded(spring_ring(seed), force), **changes)
    return system, (0.85 * hertz, 1.12 * hertz)


def test_no_peak_is_one_line():
    system, near = slipping(0)
    with pytest.raises(InputError, match=r"^near: no peak was found in it$"):
        peak_gradient(system, (2 * near[1], 2.02 * near[1]))
    refused("needs at least 1", peak_gradient, system, near, Options(0))


def test_a_peak_of_a_response_is_that_of_a_search():
    system, near = slipping(2)
    whole = peak_gradient(system, near, Options(3), frequency=True)
    hertz = np.linspace(near[0], near[1], 60)
    response = solved_response(system, hertz, Options(3))
    at = system.output_names.index(whole.output[0]), whole.output[1]
    point = int(response.amplitude[:, *at].argmax())
    found = peak_gradient_of(system, response, point, whole.output, 0.02)
    assert found.amplitude == pytest.approx(whole.amplitude, rel=1e-10)
    assert found.frequency == pytest.approx(whole.frequency, rel=1e-8)
    for by in (AmplitudeGradient.by_force, AmplitudeGradient.by_damping):
        assert by(found.at_peak) == pytest.approx(by(whole.at_peak), rel=1e-6)
        assert found.of_frequency(by) == pytest.approx(whole.of_frequency(by), rel=1e-3)
    with pytest.raises(InputError, match=r"^point: given 0: no peak was found there$"):
        peak_gradient_of(system, response, 0, whole.output, 1e-5)
    for place, width in ((response.points, 0.02), (point, np.nan)):
        with pytest.raises(InputError, match=r"^point, width: given .*: needs one of \d+ points"):
            peak_gradient_of(system, response, place, whole.output, width)


def test_where_no_frequency_is_followed_the_reason_is_said(monkeypatch):
    system, near = slipping(2)
    ready, found = Options(1).prepare(system, near, 1000), peak_gradient(system, near, Options(1))
    component = system.output_names.index(found.output[0]), found.output[1]
    monkeypatch.setattr(Resonance, "read", lambda *_: None)
    for changes, asked, why in (
        ({}, False, "the peak's frequency was not asked for"),
        ({"sharp": True}, True, "the peak is sharp"),
        ({"distance": 1e-3}, True, "the peak is not exact"),
        ({}, True, "close beside the peak the path turns back or was lost"),
    ):
        again = _gradient_of_peak(ready, component, replace(found.peak, **changes), asked)
        assert again is not None
        refused(f"^of_frequency: {why}", again.of_frequency, AmplitudeGradient.by_force)
