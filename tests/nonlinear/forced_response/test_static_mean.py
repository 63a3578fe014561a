"""What is held at rest: uncoupled and constant-load balances, and sliders assembled elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.nonlinear.systems import (
    even,
    first_frequency,
    in_time,
    jenkins_element,
    random_system,
    solved_response,
    with_contacts,
)
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    OPEN,
    SLIP,
    SLIP_OPEN,
    STUCK,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    audit_response,
    contact_loop,
    static_response,
)
from vanelock.nonlinear.fourier import TURN
from vanelock.rom.system.coordinates import check


@pytest.mark.parametrize("friction", ["orthogonal", "isotropic"])
@pytest.mark.parametrize("coupling", ["uncoupled", "constant-load"])
def test_harmonic_zero_is_the_static_problem(coupling, friction):
    system = even(random_system(0, preload=1.0))
    hertz = np.array([0.8, 1.2]) * first_frequency(system)
    response = solved_response(system, hertz, Options(2, coupling=coupling, friction=friction))
    assert np.any(response.dissipation > 0)
    static = static_response(system, Options(friction=friction))
    for p in range(2):
        np.testing.assert_allclose(response.x[0][p], static.x[0][0], atol=1e-12)
        for name in ("contact", "force", "output"):
            found, expected = getattr(response, name)[p, 0], getattr(static, name)[0, 0]
            np.testing.assert_allclose(found, expected, atol=1e-12)
    assert (response.coupling, response.friction) == (coupling, friction)


def sliding(force, shake, v0):
    """A mass that slides on the ground while another one shakes the normal load of its contact."""
    one = Diameter(
        K=np.diag([1.0, 2.0]),
        M=np.diag([1.0, 0.5]),
        C=np.diag([0.06, 0.2]),
        own=[[[0, 1], [1, 0], [0, 0]]],
    )
    contacts = Contacts([0.9], [[0.8, 0.8]], [0.3], [v0])
    return System(1, 0, {0: one}, contacts, {1: Force([force, shake])})


def test_constant_load_is_the_closed_form_of_the_oscillator_with_a_jenkins_element():
    # However the normal load is shaken, even to tension: friction is bounded by μ times that at
    # rest. Harmonic balance with H = 1 is |k - mω² + iωc + κ(A)| A = f with Jenkins' κ(A).
    system = sliding(0.7, 3.0, 2.0)
    static = static_response(system)
    limit = 0.3 * static.force[0, 0, 0, 0].real
    np.testing.assert_allclose(limit / 0.3, 0.9 * 2.0 / (1 + 0.9 / 2.0))

    def stiffness(a):
        return 0.8 if 0.8 * a <= limit else jenkins_element(a, 0.8, limit)[0]

    omegas, options = np.linspace(0.2, 1.5, 14), Options(1, coupling="constant-load")
    response = solved_response(system, omegas / TURN, options)
    assert {STUCK, SLIP} <= set(response.state[:, 0])
    for p, omega in enumerate(omegas):
        D = 1 - omega**2 + 0.06j * omega

        a = brentq(lambda a, D=D: abs(D + stiffness(a)) * a - 0.7, 1e-9, 50.0, xtol=1e-14)
        exact = 0.7 / (D + stiffness(a))
        np.testing.assert_allclose(response.x[1][p, 0], exact, atol=1e-9)
        normal = 3.0 / (2 + 0.9 - 0.5 * omega**2 + 0.2j * omega)
        np.testing.assert_allclose(response.x[1][p, 1], normal, atol=1e-12)
        np.testing.assert_allclose(response.force[p, 1, 0, 0], 0.9 * normal, atol=1e-12)
    # the normal spring is in tension for a part of the period
    assert np.abs(response.contact[:, 1, 0, 0]).max() > 1.1 * response.contact[0, 0, 0, 0].real


@pytest.mark.parametrize("coupling", ["uncoupled", "constant-load"])
def test_time_integration_with_the_mean_held(coupling):
    # A contact that slips in every period forgets where it is on the average, so holding the mean
    # tangential displacement changes no other harmonic; the normal one is linear until it opens.
    system, hertz, steps = sliding(0.7, 0.9, 2.0), 1.1 / TURN, 4000
    pushed = sliding(0.7, 0.9 if coupling == "uncoupled" else 0.0, 2.0)
    path, _ = in_time(pushed, hertz, 40, steps)
    assert path[:, 1].min() > -2.0  # it never opens
    moving = path[:, 0] - path[:, 0].mean()
    turn, errors = np.exp(2j * np.pi * np.arange(steps) / steps), []
    for harmonics in (1, 3, 7, 15):
        options = Options(harmonics, coupling=coupling)
        response = solved_response(system, [hertz], options)
        assert response.state[0, 0] == SLIP
        history = sum((response.x[k][0, 0] * turn**k).real for k in range(1, harmonics + 1))
        errors.append(float(np.abs(history - moving).max() / np.abs(moving).max()))
    assert errors[1] < 0.6 * errors[0]
    assert errors[3] < 2e-3


def test_contact_open_at_rest_stays_open_under_constant_load():
    system = sliding(0.7, 3.0, -0.2)
    hertz = np.array([0.1, 0.15])
    held, loose = (
        solved_response(system, hertz, Options(2, coupling=coupling))
        for coupling in ("constant-load", "uncoupled")
    )
    assert np.all(held.state == OPEN)
    assert np.all(loose.state == SLIP_OPEN)
    np.testing.assert_allclose(held.force, 0, atol=1e-14)
    alone = 3.0 / (2 - 0.5 * (TURN * hertz) ** 2 + 0.2j * TURN * hertz)
    np.testing.assert_allclose(held.x[1][:, 1], alone, rtol=1e-12)
    u, f = contact_loop(held, 0, 0, 16)
    assert u[:, 0].max() > 0  # it would touch
    np.testing.assert_array_equal(f, 0)


def test_static_load_that_grows_with_the_frequency_needs_the_coupled_balance():
    system = sliding(0.7, 0.0, 1.0)
    system = replace(system, force={**system.force, 0: Force([1.0, 1.0], 2)})
    with pytest.raises(InputError, match="force/0 grows with the frequency"):
        solved_response(system, [0.1], Options(1, coupling="uncoupled"))


def test_an_audit_is_refused_where_it_would_judge_by_another_law():
    system = sliding(0.7, 0.0, 1.0)
    response = solved_response(system, [0.1], Options(1, coupling="uncoupled"))
    with pytest.raises(InputError, match="response: uncoupled: an audit is of coupled balances"):
        audit_response(system, response)


def assembled(slider):
    """Two masses on springs of 1 N/m, pressed together by an interference; the first is pushed."""
    own = [[[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]]
    contacts = Contacts([0.5], [[0.8, 0.8]], [0.3], [1.0], slider=[[slider, 0.0]])
    one = {0: Diameter(K=np.eye(2), M=np.eye(2), own=own)}
    return System(1, 0, one, contacts, {0: Force([0.02, 0.0])}, damping_ratio=0.01)


@pytest.mark.parametrize("slider", [0.0, 0.05, -0.1, 1.0])
def test_static_friction_is_what_the_slider_says_up_to_the_bound(slider):
    found = static_response(assembled(slider)).force[0, 0, 0, 1]
    stuck = 0.8 * ((0.02 + 0.8 * slider) / 1.8 - slider)
    bound = 0.3 * 0.5 * (2 / 3)
    assert found == pytest.approx(np.clip(stuck, -bound, bound), rel=1e-12, abs=1e-14)


def test_a_saved_system_keeps_its_sliders_and_wrong_ones_are_refused(tmp_path):
    slider, system = np.arange(12.0).reshape(6, 2), random_system(1)
    with_contacts(system, slider=slider).save(tmp_path / "system.h5")
    np.testing.assert_array_equal(System.load(tmp_path / "system.h5").contacts.slider, slider)
    with pytest.raises(InputError, match=r"contact/slider has shape \(5, 2\), not \(6, 2\)"):
        check(with_contacts(system, slider=slider[:5]))
    with pytest.raises(InputError, match="contact/slider holds values that are not finite"):
        check(with_contacts(system, slider=np.full((6, 2), np.nan)))
