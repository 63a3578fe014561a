"""Damping of the structure whose joints are open, given beside springs that stick."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    audit_response,
    frequency_response,
    linear_response,
    stability,
    stuck_modes,
    time_response,
)

Make = Callable[..., System]
Lowest = Callable[[System], float]
ZETA = 0.02


def ring(random_system: Make, seed: int = 3, **more) -> System:
    """Four contacts that open and two that "free" leaves closed."""
    system = random_system(seed, damping_ratio=ZETA, **more)
    joint = ("pad", "pad", "seat", "pad", "seat", "pad")
    contacts = replace(system.contacts, joint=joint, always_closed=("seat",))
    return replace(system, contacts=contacts, damping_joints="open")


def matrices(system: System, k: int) -> tuple[np.ndarray, ...]:
    """K with the seat closed, the springs beside, M and C by definition."""
    given, n = system.at(k), len(system.at(k).K)
    B = system.contact_rows(k)
    pad = np.array(system.contacts.joint) == "pad"
    springs = []
    for chosen in (~pad, pad):
        b = B[chosen].reshape(-1, n)
        springs.append((b.conj().T * system.contacts.stiffness[chosen].reshape(-1)) @ b)
    free = given.K + springs[0]
    omega2, V = la.eigh(free, given.M)
    MV = given.M @ V
    return free, springs[1], given.M, (MV * (2 * ZETA * np.sqrt(omega2))) @ MV.conj().T


def receptance(system: System, k: int, s: float) -> np.ndarray:
    """D̃⁻¹ by the modes."""
    modes = stuck_modes(system, k)
    return np.asarray(modes.shapes @ modes.solve(s, modes.shapes.conj().T))


def test_every_mode_of_the_free_ring_has_the_ratio(random_system: Make) -> None:
    system = ring(random_system)
    for k in system.diameters:
        free, springs, M, _ = matrices(system, k)
        for s in (0.3, 1.7, 8.0):
            full = la.inv(receptance(system, k, s)) - springs
            damping = (full - full.conj().T) / (2j * s)
            omega2, V = la.eigh(free, M)
            ratio = V.conj().T @ damping @ V / (2 * np.sqrt(omega2))
            np.testing.assert_allclose(ratio, ZETA * np.eye(len(M)), atol=1e-10)


def test_dynamic_stiffness_is_that_in_full_coordinates(random_system: Make) -> None:
    system = ring(random_system)
    for k in system.diameters:
        free, springs, M, C = matrices(system, k)
        resonance = np.sqrt(la.eigvalsh(free, M)[1])  # of the open structure: springs do nothing
        for s in (0.0, 0.4, resonance, 5.0):
            expected = la.inv(free + springs - s**2 * M + 1j * s * C)
            atol = 1e-11 * np.abs(expected).max()
            np.testing.assert_allclose(receptance(system, k, s), expected, atol=atol)


def test_stuck_ratio_of_two_masses_is_the_closed_form() -> None:
    # Apart, each mass m on its spring k has 2ζ√(km); stuck, the antisymmetric mode sees k + 2 kt.
    k, m, kt = 2.0, 0.5, 3.0
    own = np.zeros((1, 3, 2))
    own[0, 1] = 1, -1
    system = System(
        sectors=1,
        engine_order=0,
        diameters={0: Diameter(K=k * np.eye(2), M=m * np.eye(2), own=own)},
        contacts=Contacts(np.ones(1), np.array([[kt, 1.0]]), np.ones(1), np.ones(1)),
        force={1: Force(np.array([1.0, -1.0], complex))},
        damping_ratio=ZETA,
        damping_joints="open",
    )
    omega = np.sqrt((k + 2 * kt) / m)
    ratio = ZETA * np.sqrt(k / (k + 2 * kt))
    found = linear_response(system, [omega / (2 * np.pi)]).x[1][0]
    expected = 1 / (2j * ratio * (k + 2 * kt))
    np.testing.assert_allclose(found, [expected, -expected], rtol=1e-12)


def test_open_gaps_answer_mode_by_mode(random_system: Make, first_frequency: Lowest) -> None:
    system = ring(random_system, preload=-1e3)
    none = replace(system.contacts, always_closed=())
    system = replace(system, contacts=none)
    hertz = first_frequency(system) * np.linspace(0.9, 1.4, 7)
    found = frequency_response(system, hertz, Options(1), find_jumps=False)
    k = system.nodal_diameter(1)
    omega2, V = la.eigh(system.at(k).K, system.at(k).M)
    push = V.conj().T @ system.force[1].vector
    s = 2 * np.pi * hertz[:, None]
    expected = (push / (omega2 - s**2 + 2j * ZETA * s * np.sqrt(omega2))) @ V.T
    np.testing.assert_allclose(found.x[1], expected, atol=1e-10 * np.abs(expected).max())
    linear = linear_response(system, hertz, "none")
    np.testing.assert_allclose(linear.x[1], expected, atol=1e-10 * np.abs(expected).max())


def test_without_contacts_that_open_both_are_the_same(random_system: Make) -> None:
    system = ring(random_system)
    held = replace(system.contacts, always_closed=("seat", "pad"))
    both = [replace(system, contacts=held, damping_joints=each) for each in ("open", "stuck")]
    a, b = (frequency_response(each, [0.1, 0.14], Options(3), find_jumps=False) for each in both)
    np.testing.assert_array_equal(a.contact, b.contact)


def test_rigid_motions_of_the_free_structure_are_not_damped() -> None:
    # A mass that hangs in its contact alone: nothing viscous is left.
    own = np.zeros((1, 3, 1))
    own[0, 1, 0] = 1
    system = System(
        sectors=1,
        engine_order=0,
        diameters={0: Diameter(K=np.zeros((1, 1)), M=np.ones((1, 1)), own=own)},
        contacts=Contacts(np.ones(1), np.full((1, 2), 4.0), np.ones(1), np.ones(1)),
        damping_ratio=0.1,
        damping_joints="open",
    )
    modes = stuck_modes(system, 0)
    assert modes.damping.tolist() == [0.0]
    assert modes.poles().tolist() == [0.0]
    np.testing.assert_allclose(receptance(system, 0, 1.0), [[1 / 3]], rtol=1e-12)
    np.testing.assert_allclose(receptance(system, 0, 0.0), [[1 / 4]], rtol=1e-12)


def test_massless_motion_that_only_opening_contacts_hold_is_refused() -> None:
    own = np.zeros((1, 3, 2))
    own[0, :, 1] = 1
    system = System(
        sectors=1,
        engine_order=0,
        diameters={0: Diameter(K=np.diag([1.0, 0.0]), M=np.diag([1.0, 0.0]), own=own)},
        contacts=Contacts(np.ones(1), np.ones((1, 2)), np.ones(1), np.ones(1)),
        damping_ratio=0.1,
        damping_joints="open",
    )
    with pytest.raises(InputError, match="they alone hold has no mass.*damping/joints"):
        stuck_modes(system, 0)


def test_modes_that_count_statically_cost_what_is_estimated(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = ring(random_system, seed=7, size=60, preload=10.0)
    hertz = first_frequency(system) * np.array([1.2, 2.0])
    full = frequency_response(system, hertz, Options(3), find_jumps=False)
    cut = frequency_response(system, hertz, Options(3, static_beyond=16.0), find_jumps=False)
    largest = np.abs(full.contact[:, 1:]).max(axis=(1, 2, 3))
    made = np.abs(cut.contact[:, 1:] - full.contact[:, 1:]).max(axis=(1, 2, 3)) / largest
    assert cut.truncation.max() > 1e-4
    np.testing.assert_allclose(cut.truncation, made, rtol=0.5)


@pytest.mark.parametrize(("order", "hertz"), [(0, 0.163), (1, 0.18)])
def test_audit_and_time_agree_with_the_balance(
    sliding_system: Make, order: int, hertz: float
) -> None:
    system = replace(sliding_system(amplitude=5), engine_order=order, damping_joints="open")
    response = frequency_response(system, [hertz], Options(15), find_jumps=False)
    assert response.dissipation.sum() > 0
    audit = audit_response(system, response)
    assert audit.residual[0] < 1e-8
    assert audit.imbalance[0] < 3 * audit.imbalance_error[0]
    marched = time_response(system, hertz, 3, steps=2000, start=(response, 0))
    assert marched.departure.max() < 1e-3
    assert marched.defect.max() < 1e-3
    x = response.x[1][0]
    np.testing.assert_allclose(marched.x[1], x, atol=1e-3 * np.abs(x).max())


def test_exponents_of_a_stuck_ring_are_its_eigenvalues(random_system: Make) -> None:
    system = ring(random_system, sectors=4, preload=1e3)
    contacts = replace(system.contacts, mu=np.full(6, 50.0))
    system = replace(system, contacts=contacts, damping_ratio=ZETA)
    hertz = 0.2
    response = frequency_response(system, [hertz], Options(1), find_jumps=False)
    found = stability(system, response, count=4)
    omega, exponents = 2 * np.pi * hertz, []
    for k in range(3):
        free, springs, M, C = matrices(system, k)
        n = len(M)
        A = np.block(
            [
                [np.zeros((n, n)), np.eye(n)],
                [-la.solve(M, free + springs), -la.solve(M, C)],
            ]
        )
        exponents.append(la.eigvals(A))
    every = np.concatenate([*exponents, *(each.conj() for each in exponents)])
    turned = every[:, None] + 1j * omega * np.arange(-60, 61)
    for each in found.exponent[0]:
        assert np.abs(turned - each).min() < 1e-10 * np.abs(every).min()
    assert found.growth[0, 0] == pytest.approx(every.real.max(), rel=1e-9)
