"""Uncoupled and constant-load balances against full coordinates, closed forms and each other."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    OPEN,
    SLIP,
    SLIP_OPEN,
    STUCK,
    Options,
    Response,
    System,
    audit_response,
    contact_loop,
    frequency_response,
    static_response,
)
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.forced_response.options import with_static_mean
from vanelock.nonlinear.newton.newton import solve
from vanelock.rom.system.system import Contacts, Diameter, Force

Floats = NDArray[np.float64]
TURN = 2 * np.pi
Make = Callable[..., System]
Lowest = Callable[[System], float]
COUPLINGS = ("coupled", "uncoupled", "constant-load")


def even(system: System) -> System:
    """The same stiffness in both tangential directions."""
    contacts = system.contacts
    return replace(system, contacts=replace(contacts, kt=contacts.kt[:, [0, 0]]))


def all_three(system: System, hertz: Floats, harmonics: int, friction: str) -> list[Response]:
    return [
        frequency_response(
            system,
            hertz,
            Options(harmonics, coupling=coupling, friction=friction),
            find_jumps=False,
        )
        for coupling in COUPLINGS
    ]


@pytest.mark.parametrize("friction", ["orthogonal", "isotropic"])
def test_couplings_agree_in_full_stick(
    random_system: Make, first_frequency: Lowest, friction: str
) -> None:
    # Stuck for good, contacts are springs; where one slid at assembly, vibration relaxes its mean
    # friction, which the coupled mean alone follows.
    for mu, slid in ((10.0, False), (0.3, True)):
        system = even(random_system(3, preload=10.0, mu=mu, amplitude=0.02))
        hertz = np.linspace(0.7, 1.6, 9) * first_frequency(system)
        static = static_response(system, Options(friction=friction))
        assert (static.active[0] > 0) == slid
        coupled, *others = all_three(system, hertz, 3, friction)
        assert np.all(coupled.state == STUCK)
        for other in others:
            assert other.converged.all()
            assert np.all(other.state == STUCK)
            for a, b in ((coupled.contact, other.contact), (coupled.force, other.force)):
                moving = np.abs(a[:, 1:]).max()
                np.testing.assert_allclose(b[:, 1:], a[:, 1:], rtol=0, atol=1e-10 * moving)
            apart = np.abs(other.force[:, 0] - coupled.force[:, 0]).max()
            largest = np.abs(coupled.force[:, 0]).max()
            if slid:
                assert 1e-4 * largest < apart < 0.05 * largest
            else:
                assert apart < 1e-12 * largest


@pytest.mark.parametrize("friction", ["orthogonal", "isotropic"])
@pytest.mark.parametrize("coupling", ["uncoupled", "constant-load"])
def test_harmonic_zero_is_the_static_problem(
    random_system: Make, first_frequency: Lowest, coupling: str, friction: str
) -> None:
    system = even(random_system(0, preload=1.0))
    hertz = np.array([0.8, 1.2]) * first_frequency(system)
    response = frequency_response(
        system, hertz, Options(2, coupling=coupling, friction=friction), find_jumps=False
    )
    assert response.converged.all()
    assert np.any(response.dissipation > 0)
    static = static_response(system, Options(friction=friction))
    for p in range(2):
        np.testing.assert_allclose(response.x[0][p], static.x[0][0], atol=1e-12)
        for name in ("contact", "force", "output"):
            found, expected = getattr(response, name)[p, 0], getattr(static, name)[0, 0]
            np.testing.assert_allclose(found, expected, atol=1e-12)
    assert (response.coupling, response.friction) == (coupling, friction)


def sliding(force: complex, shake: complex, v0: float) -> System:
    """A mass that slides on the ground while another one shakes the normal load of its contact."""
    return System(
        sectors=1,
        engine_order=0,
        diameters={
            0: Diameter(
                K=np.diag([1.0, 2.0]).astype(complex),
                M=np.diag([1.0, 0.5]).astype(complex),
                C=np.diag([0.06, 0.2]).astype(complex),
                own=np.array([[[0, 1], [1, 0], [0, 0]]], complex),
            )
        },
        contacts=Contacts(np.full(1, 0.9), np.full((1, 2), 0.8), np.array([0.3]), np.array([v0])),
        force={1: Force(np.array([force, shake], complex))},
    )


def test_constant_load_is_the_closed_form_of_the_oscillator_with_a_jenkins_element() -> None:
    # However the normal load is shaken, even to tension: friction is bounded by μ times that at
    # rest. Harmonic balance with H = 1 is |k - mω² + iωc + κ(A)| A = f with Jenkins' κ(A).
    system = sliding(0.7, 3.0, 2.0)
    static = static_response(system)
    limit = 0.3 * static.force[0, 0, 0, 0].real
    np.testing.assert_allclose(limit / 0.3, 0.9 * 2.0 / (1 + 0.9 / 2.0))

    def jenkins(amplitude: float) -> complex:
        kt = 0.8
        if kt * amplitude <= limit:
            return kt
        psi = np.arccos(1 - 2 * limit / (kt * amplitude))
        work = 4 * limit * (amplitude - limit / kt)
        in_phase = kt * amplitude / np.pi * (psi - 0.5 * np.sin(2 * psi))
        return complex(in_phase / amplitude, work / (np.pi * amplitude**2))

    omegas = np.linspace(0.2, 1.5, 14)
    response = frequency_response(
        system, omegas / (2 * np.pi), Options(1, coupling="constant-load"), find_jumps=False
    )
    assert response.converged.all()
    assert {STUCK, SLIP} <= set(response.state[:, 0])
    for p, omega in enumerate(omegas):
        D = 1 - omega**2 + 0.06j * omega

        def excess(a: float, D: complex = D) -> float:
            return abs(D + jenkins(a)) * a - 0.7

        amplitude = brentq(excess, 1e-9, 50.0, xtol=1e-14)
        exact = 0.7 / (D + jenkins(amplitude))
        np.testing.assert_allclose(response.x[1][p, 0], exact, atol=1e-9)
        normal = 3.0 / (2 + 0.9 - 0.5 * omega**2 + 0.2j * omega)
        np.testing.assert_allclose(response.x[1][p, 1], normal, atol=1e-12)
        np.testing.assert_allclose(response.force[p, 1, 0, 0], 0.9 * normal, atol=1e-12)
    # the normal spring is in tension for a part of the period
    assert np.abs(response.contact[:, 1, 0, 0]).max() > 1.1 * response.contact[0, 0, 0, 0].real


@pytest.mark.parametrize("coupling", ["uncoupled", "constant-load"])
def test_time_integration_with_the_mean_held(coupling: str) -> None:
    # A contact that slips in every period forgets where it is on the average, so holding the mean
    # tangential displacement changes no other harmonic; the normal one is linear until it opens.
    system = sliding(0.7, 0.9, 2.0)
    omega, steps, periods = 1.1, 4000, 40
    static = static_response(system).contact[0, 0, 0, 0].real
    M, K, C = np.array([1.0, 0.5]), np.array([1.0, 2.0]), np.array([0.06, 0.2])
    h = 2 * np.pi / omega / steps
    # the normal mass moves linearly: its contact's spring never opens
    shaken = 0.9 / (2 + 0.9 - 0.5 * omega**2 + 0.2j * omega)
    assert abs(shaken) < static
    angle = 2 * np.pi * np.arange(steps) / steps
    v = static + (shaken * np.exp(1j * angle)).real
    n = 0.9 * (v if coupling == "uncoupled" else np.full(steps, static))
    x, before, w, last = 0.0, 0.0, 0.0, np.empty(steps)
    left = M[0] / h**2 + C[0] / (2 * h)
    for i in range(periods * steps):
        s = i % steps
        reach = 0.3 * n[s] / 0.8
        w = min(max(w, x - reach), x + reach)
        push = 0.7 * np.cos(angle[s]) - K[0] * x - 0.8 * (x - w)
        push += M[0] * (2 * x - before) / h**2 + C[0] * before / (2 * h)
        x, before = push / left, x
        last[(s + 1) % steps] = x
    errors = []
    for harmonics in (1, 3, 7, 15):
        response = frequency_response(
            system, [omega / (2 * np.pi)], Options(harmonics, coupling=coupling), find_jumps=False
        )
        assert response.converged.all()
        assert response.state[0, 0] == SLIP
        history = sum(
            (response.x[k][0, 0] * np.exp(1j * k * angle)).real for k in range(1, harmonics + 1)
        )
        moving = last - last.mean()
        errors.append(float(np.abs(history - moving).max() / np.abs(moving).max()))
    assert errors[1] < 0.6 * errors[0]
    assert errors[3] < 2e-3


def test_contact_open_at_rest_stays_open_under_constant_load() -> None:
    system = sliding(0.7, 3.0, -0.2)
    hertz = np.array([0.1, 0.15])
    held = frequency_response(system, hertz, Options(2, coupling="constant-load"), find_jumps=False)
    loose = frequency_response(system, hertz, Options(2, coupling="uncoupled"), find_jumps=False)
    assert held.converged.all()
    assert loose.converged.all()
    assert np.all(held.state == OPEN)
    assert np.all(loose.state == SLIP_OPEN)
    np.testing.assert_allclose(held.force, 0, atol=1e-14)
    np.testing.assert_allclose(
        held.x[1][:, 1], 3.0 / (2 - 0.5 * (TURN * hertz) ** 2 + 0.2j * TURN * hertz), rtol=1e-12
    )
    u, f = contact_loop(held, 0, 0, 16)
    assert u[:, 0].max() > 0  # it would touch
    np.testing.assert_array_equal(f, 0)


@pytest.mark.parametrize("friction", ["orthogonal", "isotropic"])
@pytest.mark.parametrize("coupling", ["uncoupled", "constant-load"])
def test_ranges_directions_samples_and_loops_work_with_every_coupling(
    random_system: Make, first_frequency: Lowest, coupling: str, friction: str
) -> None:
    system = even(random_system(5, preload=3.0, contacts=3, damping_ratio=0.01))
    low, high = (float(f) for f in np.array([0.8, 1.3]) * first_frequency(system))
    found = frequency_response(
        system, (low, high), Options(1, coupling=coupling, friction=friction), find_jumps=False
    )
    assert found.converged.all()
    down = frequency_response(
        system,
        found.frequency[::-3],
        Options(1, coupling=coupling, friction=friction, direction="down"),
        find_jumps=False,
    )
    others, largest = [down], np.abs(found.contact).max()
    if friction == "orthogonal":
        sampled = Options(1, coupling=coupling, samples=512)
        others += [frequency_response(system, found.frequency[::-3], sampled, find_jumps=False)]
    for other in others:
        assert other.converged.all()
        atol = (1e-7 if other is down else 2e-3) * largest
        np.testing.assert_allclose(other.contact, found.contact[::-3], atol=atol)
    point = int(found.dissipation.sum(axis=1).argmax())
    contact = int(found.dissipation[point].argmax())
    assert found.dissipation[point, contact] > 0
    u, f = contact_loop(found, point, contact, 4000)
    spectrum = 2 * np.fft.rfft(f, axis=0)[1] / len(f)
    size = np.abs(f).max()
    np.testing.assert_allclose(spectrum, found.force[point, 1, contact], atol=2e-4 * size)
    closed = np.concatenate([u[-1:], u, u[:1]])
    area = sum(float(np.sum(f[:, d] * (closed[2:, d] - closed[:-2, d]) / 2)) for d in (1, 2))
    np.testing.assert_allclose(area, found.dissipation[point, contact], rtol=2e-3)


def test_an_unconverged_state_at_rest_marks_every_point(random_system: Make) -> None:
    system = random_system(1, preload=10.0, amplitude=0.01)
    prepared = structure(system, 1)
    law = contact_law(system.contacts, 1)
    moving = solve(fixed(prepared.balance(1.0), law), np.zeros((6, 3, 3)), 0.0)
    assert moving.converged
    rest = replace(moving, converged=False, residual=0.5)
    joined = with_static_mean(moving, rest)
    assert not joined.converged
    assert joined.residual == 0.5


def test_static_load_that_grows_with_the_frequency_needs_the_coupled_balance() -> None:
    system = sliding(0.7, 0.0, 1.0)
    load = {**system.force, 0: Force(np.ones(2, complex), 2)}
    with pytest.raises(InputError, match="force/0 grows with the frequency"):
        frequency_response(
            replace(system, force=load), [0.1], Options(1, coupling="uncoupled"), find_jumps=False
        )


def test_an_audit_is_refused_where_it_would_judge_by_another_law() -> None:
    system = sliding(0.7, 0.0, 1.0)
    response = frequency_response(system, [0.1], Options(1, coupling="uncoupled"), find_jumps=False)
    with pytest.raises(InputError, match="response: uncoupled: an audit is of coupled balances"):
        audit_response(system, response)
