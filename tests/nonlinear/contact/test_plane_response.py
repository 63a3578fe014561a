"""Responses with isotropic friction against full coordinates and direct time integration."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    STUCK,
    Contact,
    Options,
    System,
    contact_loop,
    frequency_response,
    static_response,
)
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.globalisation import _released
from vanelock.rom.system.system import Contacts, Diameter, Force

Floats = NDArray[np.float64]
Make = Callable[..., System]
Lowest = Callable[[System], float]


def even(system: System) -> System:
    """The same stiffness in both tangential directions."""
    contacts = system.contacts
    return replace(system, contacts=replace(contacts, kt=contacts.kt[:, [0, 0]]))


def planar(swing: complex, mu: float, v0: float, shake: float) -> System:
    """A mass on unequal springs slides on the ground in a plane; another one shakes the load."""
    K = np.diag([1.0, 1.3, 2.0])
    return System(
        sectors=1,
        engine_order=0,
        diameters={
            0: Diameter(
                K=K.astype(complex),
                M=np.diag([1.0, 1.0, 0.5]).astype(complex),
                C=(0.06 * K).astype(complex),
                own=np.array([[[0, 0, 1], [1, 0, 0], [0, 1, 0]]], complex),
            )
        },
        contacts=Contacts(np.full(1, 0.9), np.full((1, 2), 0.8), np.array([mu]), np.array([v0])),
        force={1: Force(np.array([0.7, swing, shake], complex))},
    )


@pytest.mark.parametrize(
    ("swing", "v0", "shake", "state"),
    [
        (0.7j, 2.0, 0.0, SLIP),  # nearly a circle under constant load
        (0.5 + 0.2j, 2.0, 1.2, SLIP),  # an ellipse, the normal load varies
        (0.5j, 0.8, 2.0, SLIP_OPEN),
    ],
)
def test_mass_that_slides_in_a_plane(swing: complex, v0: float, shake: float, state: int) -> None:
    system = planar(swing, 0.6, v0, shake)
    d, omega, steps, periods = system.at(0), 1.05, 2000, 30
    assert d.C is not None
    M, K, C = (np.diagonal(matrix).real for matrix in (d.M, d.K, d.C))
    h = 2 * np.pi / omega / steps
    left = M / h**2 + C / (2 * h)
    force = system.force[1].vector
    angle = 2 * np.pi * np.arange(steps) / steps
    push = (force * np.exp(1j * angle)[:, None]).real
    x, before, w, last = np.zeros(3), np.zeros(3), np.zeros(2), np.empty((steps, 3))
    for i in range(periods * steps):
        s = i % steps
        n = 0.9 * max(v0 + x[2], 0.0)
        away = x[:2] - w
        size, reach = float(np.hypot(*away)), 0.6 * n / 0.8
        if size > reach:
            w = x[:2] - reach / size * away
        pull = np.array([0.8 * (x[0] - w[0]), 0.8 * (x[1] - w[1]), n])
        right = push[s] - K * x - pull + M * (2 * x - before) / h**2 + C * before / (2 * h)
        x, before = right / left, x
        last[(s + 1) % steps] = x
    moving = last - last.mean(axis=0)
    errors = []
    for harmonics in (1, 3, 7, 15):
        response = frequency_response(
            system, [omega / (2 * np.pi)], Options(harmonics, friction="isotropic")
        )
        assert response.converged.all()
        assert response.state[0, 0] == state
        history = sum(
            (response.x[k][0] * np.exp(1j * k * angle)[:, None]).real
            for k in range(1, harmonics + 1)
        )
        errors.append(float(np.abs(history - moving).max() / np.abs(moving).max()))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.3 * errors[0]
    assert errors[3] < 1e-3


def test_loop_stays_within_the_bound_in_the_plane_and_encloses_the_work(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = even(random_system(0, preload=1.0))
    hertz = np.linspace(0.9, 1.2, 7) * first_frequency(system)
    response = frequency_response(system, hertz, Options(3, friction="isotropic"), find_jumps=False)
    assert response.converged.all()
    assert np.any(response.state[-1] == SLIP_OPEN)
    for contact in range(6):
        u, f = contact_loop(response, -1, contact, 5000)
        assert np.all(np.hypot(f[:, 1], f[:, 2]) <= 0.3 * f[:, 0] + 1e-12)
        spectrum = np.fft.rfft(f, axis=0)[:4] / len(f)
        spectrum[1:] *= 2
        size = np.abs(f).max()
        np.testing.assert_allclose(spectrum, response.force[-1, :, contact], atol=1e-3 * size)
        closed = np.concatenate([u[-1:], u, u[:1]])
        area = sum(float(np.sum(f[:, d] * (closed[2:, d] - closed[:-2, d]) / 2)) for d in (1, 2))
        np.testing.assert_allclose(
            area, response.dissipation[-1, contact], atol=2e-3 * response.dissipation[-1].max()
        )


@pytest.mark.parametrize("constant_load", [False, True])
@pytest.mark.parametrize("friction", ["orthogonal", "isotropic"])
def test_held_contacts_stick_and_released_ones_are_themselves(
    random_system: Make, first_frequency: Lowest, friction: str, constant_load: bool
) -> None:
    system = even(random_system(2, preload=0.5))
    balance = structure(system, 2).balance(2 * np.pi * 1.1 * first_frequency(system))
    law = contact_law(system.contacts, 2, friction=friction, constant_load=constant_load)
    family = _released(balance, law)
    assert not family.law(1.0)(balance.linear).w.any()
    free, own = family.law(0.0)(balance.linear), law(balance.linear)
    assert own.w.any()
    np.testing.assert_allclose(free.w, own.w, atol=1e-13)
    np.testing.assert_allclose(free.jacobian, own.jacobian, atol=1e-11)


def test_isotropic_friction_sticks_as_orthogonal_does(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = even(random_system(3, preload=10.0, mu=10.0, amplitude=0.02))
    hertz = np.linspace(0.7, 1.6, 9) * first_frequency(system)
    one, other = (
        frequency_response(system, hertz, Options(3, friction=friction), find_jumps=False)
        for friction in ("orthogonal", "isotropic")
    )
    assert np.all(other.state == STUCK)
    np.testing.assert_allclose(other.contact, one.contact, rtol=0, atol=1e-14)


@pytest.mark.parametrize("kt", [1e10, 1e13])
def test_friction_that_vanishes_beside_the_motion_is_none(kt: float) -> None:
    K = 1e7 * np.array([[2.0, -1.0], [-1.0, 2.0]])
    contact = Contact(tangential=1, normal=(None, 0), mu=1e-9, kt=kt, kn=1e7, preload=0.1)
    system = System.from_matrices(np.eye(2), K, [contact], force={1: 0.1}, static_force={0: -3.0})
    found = frequency_response(system, [430.0, 500.0, 600.0], Options(1, friction="isotropic"))
    square = (2 * np.pi * found.frequency[:, None, None]) ** 2 * np.eye(2)
    alone = np.linalg.solve(K + np.diag([1e7, 0.0]) - square, [0.0, 0.1])
    assert found.converged.all()
    np.testing.assert_allclose(found.x[1], alone, rtol=1e-7)  # μ n is 1e-9 of the force


def test_what_isotropic_friction_cannot_do_is_refused(random_system: Make) -> None:
    system = random_system(0)
    with pytest.raises(InputError, match="contact 0 has kt"):
        frequency_response(system, [1.0], Options(1, friction="isotropic"))
    with pytest.raises(InputError, match="contact 0 has kt"):
        static_response(system, Options(friction="isotropic"))
    with pytest.raises(InputError, match="friction: given 'round': allowed: orthogonal, isotropic"):
        frequency_response(system, [1.0], Options(1, friction="round"))
