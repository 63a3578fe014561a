"""The condensed balance against full coordinates, finite differences and its linear limits."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    OPEN,
    SLIP,
    SLIP_OPEN,
    STUCK,
    Options,
    Response,
    System,
    frequency_response,
    harmonic_modes,
    linear_response,
    static_response,
)
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.families import Frequencies, Frictions
from vanelock.nonlinear.newton.linearised import newton_matrix
from vanelock.rom.system.system import Contacts, Diameter, Force

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]
Make = Callable[..., System]
Lowest = Callable[[System], float]


def with_gaps(system: System, gap: float) -> System:
    contacts = system.contacts
    return replace(system, contacts=replace(contacts, v0=np.full(contacts.count, -gap)))


def with_force(system: System, factor: float) -> System:
    load = {h: Force(f.vector * factor, f.omega_power) for h, f in system.force.items()}
    return replace(system, force=load)


def modal_damping(system: System, k: int) -> Array:
    """C = Σ 2ζω (M V)(M V)ᴴ over mass-normalised modes with every contact stuck."""
    matrices, n = system.at(k), len(system.at(k).K)
    B = matrices.own if matrices.next is None else (
        matrices.own + matrices.next * np.exp(-2j * np.pi * k / system.sectors)
    )  # fmt: skip
    B = B.reshape(-1, n)
    stiffness = matrices.K + B.conj().T @ np.diag(system.contacts.stiffness.reshape(-1)) @ B
    values, V = la.eigh(stiffness, matrices.M)
    MV = matrices.M @ V
    ratio = system.damping_ratio or 0.0
    C: Array = (MV * (2 * ratio * np.sqrt(values))) @ MV.conj().T
    return C if matrices.C is None else C + matrices.C


def rows(system: System, k: int) -> Array:
    """(3c, n) relative displacement of the contacts, next sector at its phase."""
    matrices = system.at(k)
    phase = np.exp(-2j * np.pi * k / system.sectors)
    B = matrices.own if matrices.next is None else matrices.own + matrices.next * phase
    return np.asarray(B.reshape(-1, len(matrices.K)), complex)


def dynamic_stiffness(system: System, harmonic: int, omega: float) -> Array:
    k, s = system.nodal_diameter(harmonic), harmonic * omega
    matrices = system.at(k)
    D: Array = matrices.K - s**2 * matrices.M + 1j * s * modal_damping(system, k)
    return D


@pytest.mark.parametrize("preload", [0.3, 10.0])
def test_solution_balances_in_full_coordinates_with_marched_forces(
    random_system: Make,
    first_frequency: Lowest,
    march: Callable[..., Floats],
    coefficients: Callable[..., Array],
    preload: float,
) -> None:
    system = random_system(0, preload=preload)
    response = frequency_response(
        system, first_frequency(system) * np.array([0.8, 1.4]), Options(3), find_jumps=False
    )
    assert response.converged.all()
    assert response.residual.max() < 1e-10
    if preload < 1:
        assert np.any(response.state == SLIP_OPEN)
    for p, frequency in enumerate(response.frequency):
        omega = 2 * np.pi * frequency
        q = np.array(
            [
                (rows(system, system.nodal_diameter(h)) @ response.x[h][p]).reshape(-1, 3)
                for h in range(4)
            ]
        )
        q[0, :, 0] += system.contacts.v0
        np.testing.assert_allclose(q, response.contact[p], atol=1e-9 * np.abs(q).max())
        pull = coefficients(march(system.contacts, q, 20000), 3)
        for h in range(4):
            B = rows(system, system.nodal_diameter(h))
            force = system.force[h].at(omega) if h in system.force else 0.0
            gap = dynamic_stiffness(system, h, omega) @ response.x[h][p]
            gap = gap + B.conj().T @ pull[h].reshape(-1) - force
            # what remains is the marching's own error, of first order at touch-downs
            assert np.abs(gap).max() < 1e-3 * np.abs(system.force[1].vector).max()
            exact = gap + B.conj().T @ (response.force[p, h] - pull[h]).reshape(-1)
            assert np.abs(exact).max() < 1e-8 * np.abs(system.force[1].vector).max()


@pytest.mark.parametrize("harmonics", [1, 3])
def test_newton_matrix_is_the_derivative_in_every_state(
    random_system: Make, first_frequency: Lowest, harmonics: int
) -> None:
    system = random_system(5, contacts=40, size=30, preload=3.0)
    prepared = structure(system, harmonics)
    law = contact_law(system.contacts, harmonics)
    omega = 2 * np.pi * 1.1 * first_frequency(system)
    balance = prepared.balance(omega)
    rng = np.random.default_rng(2)
    shape = balance.linear.shape
    w = 0.5 * rng.normal(size=shape) / np.repeat(np.arange(harmonics + 1), 2)[1:].clip(1) ** 2
    w[::3] = 0.0
    w[1::3, 0, 0] = -40.0
    found = law(balance.displacement(w))
    assert set(found.state) == {STUCK, SLIP, OPEN, SLIP_OPEN}
    every = np.arange(w.size)
    matrix = newton_matrix(balance, found, every)

    def gap(w: Floats, omega: float) -> Floats:
        other = prepared.balance(omega)
        return np.asarray((w - law(other.displacement(w)).w).reshape(-1))

    for _ in range(3):
        direction, step = rng.normal(size=shape), 1e-6
        measured = (gap(w + step * direction, omega) - gap(w - step * direction, omega)) / (
            2 * step
        )
        exact = matrix @ direction.reshape(-1)
        assert np.abs(measured - exact).max() < 1e-7 * np.abs(exact).max()
    step = 1e-6 * omega
    measured = (gap(w, omega + step) - gap(w, omega - step)) / (2 * step)
    exact = -Frequencies(prepared, law).rate(omega, w, found, every)
    assert np.abs(measured - exact).max() < 1e-6 * np.abs(exact).max()
    family, step = Frictions(balance, law), 1e-6
    u = balance.displacement(w)
    measured = (family.law(1 + step)(u).w - family.law(1 - step)(u).w).reshape(-1) / (2 * step)
    exact = family.rate(1.0, w, found, every)
    assert np.abs(exact).max() > 0
    assert np.abs(measured - exact).max() < 1e-6 * np.abs(exact).max()


def test_full_stick_is_the_linear_response_with_all_contacts_closed(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = with_force(random_system(1, preload=10.0, mu=50.0), 1e-2)
    hertz = first_frequency(system) * np.linspace(0.5, 2.5, 25)
    response = frequency_response(system, hertz, Options(3), find_jumps=False)
    expected = linear_response(system, hertz, "all", harmonics=3)
    assert response.converged.all()
    assert np.all(response.state == STUCK)
    same(response, expected, 1e-10)


def test_open_gaps_give_the_linear_response_with_no_contact_closed(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = with_gaps(random_system(2), 1e4)
    hertz = first_frequency(system) * np.linspace(0.5, 2.5, 25)
    response = frequency_response(system, hertz, Options(3), find_jumps=False)
    expected = linear_response(system, hertz, "none", harmonics=3)
    assert response.converged.all()
    assert np.all(response.state == OPEN)
    same(response, expected, 1e-10)
    for h in range(4):  # and both are what the matrices without contacts say
        D = dynamic_stiffness(system, h, 2 * np.pi * hertz[7])
        x = la.solve(D, system.force[1].vector) if h == 1 else np.zeros(len(D))
        assert np.abs(response.x[h][7] - x).max() < 1e-10 * np.abs(response.x[1][7]).max()


def same(response: Response, expected: Response, tolerance: float) -> None:
    for h in response.x:
        error = np.abs(response.x[h] - expected.x[h]).max()
        assert error <= tolerance * np.abs(expected.x[1]).max()


def test_linear_response_at_a_free_resonance_far_below_the_contacts(
    random_system: Make, first_frequency: Lowest
) -> None:
    # Stuck, the structure hardly moves; free, it resonates with little damping.
    system = random_system(2, damping_ratio=1e-6)
    stiff = replace(system.contacts, kn=np.full(6, 1e6), kt=np.full((6, 2), 1e6))
    system = replace(system, contacts=stiff)
    hertz = first_frequency(system)
    response = linear_response(system, [hertz], "none")
    assert response.converged.all()
    x = la.solve(dynamic_stiffness(system, 1, 2 * np.pi * hertz), system.force[1].vector)
    assert np.abs(x).max() > 1e3 * np.abs(linear_response(system, [hertz], "all").x[1]).max()
    # Rounding of 1e6 N/m, 1e-10 N/m, detunes what is damped by 1e-6 of its stiffness.
    assert np.abs(response.x[1][0] - x).max() < 1e-5 * np.abs(x).max()


def test_some_contacts_closed_are_springs_in_full_coordinates(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(4)
    closed = np.array([True, False, True, False, False, True])
    hertz = 1.3 * first_frequency(system)
    response = linear_response(system, [hertz], closed)
    omega, k = 2 * np.pi * hertz, system.nodal_diameter(1)
    B = rows(system, k)[np.repeat(closed, 3)]
    springs = system.contacts.stiffness[closed].reshape(-1)
    D = dynamic_stiffness(system, 1, omega) + (B.conj().T * springs) @ B
    x = la.solve(D, system.force[1].vector)
    assert np.abs(response.x[1][0] - x).max() < 1e-10 * np.abs(x).max()
    B0 = rows(system, 0)[np.repeat(closed, 3)].real
    preload = np.zeros((closed.sum(), 3))
    preload[:, 0] = system.contacts.v0[closed]
    K = system.at(0).K + (B0.T * springs) @ B0
    x0 = la.solve(K, -B0.T @ (springs * preload.reshape(-1)))
    assert np.abs(response.x[0][0] - x0).max() < 1e-10 * np.abs(x0).max()


def test_closed_names_joints_and_refuses_what_does_not_fit(random_system: Make) -> None:
    system = random_system(4)
    named = replace(
        system, contacts=replace(system.contacts, joint=("hook",) * 2 + ("interlock",) * 4)
    )
    mask = np.array([True] * 2 + [False] * 4)
    by_name = linear_response(named, [0.1], "hook")
    np.testing.assert_array_equal(by_name.x[1], linear_response(system, [0.1], mask).x[1])
    with pytest.raises(InputError, match="'bolt'.*hook, interlock"):
        linear_response(named, [0.1], "bolt")
    with pytest.raises(InputError, match=r"needs bool, \(6,\)"):
        linear_response(named, [0.1], mask[:3])


def test_a_static_load_that_nothing_holds_is_refused() -> None:
    mass = Diameter(
        K=np.zeros((1, 1), complex),
        M=np.ones((1, 1), complex),
        own=np.array([[[0.0], [1.0], [0.0]]], complex),
    )
    loose = System(
        sectors=1,
        engine_order=0,
        diameters={0: mass},
        contacts=Contacts(np.ones(1), np.ones((1, 2)), np.array([0.3]), np.ones(1)),
        force={0: Force(np.ones(1, complex)), 1: Force(np.ones(1, complex))},
    )
    with pytest.raises(InputError, match="do not hold the static load"):
        linear_response(loose, [1.0], "none")
    free = linear_response(replace(loose, force={1: loose.force[1]}), [1.0], "none")
    np.testing.assert_allclose(free.x[1][0, 0], -1 / (2 * np.pi) ** 2, rtol=1e-12)


@pytest.mark.parametrize("preload", [0.3, 3.0])
def test_power_of_the_force_is_taken_by_friction_and_damping(
    random_system: Make, first_frequency: Lowest, preload: float
) -> None:
    system = random_system(6, preload=preload)
    hertz = first_frequency(system) * np.linspace(0.6, 2.0, 8)
    response = frequency_response(system, hertz, Options(3), find_jumps=False)
    assert response.converged.all()
    assert np.all(response.dissipation >= 0)
    total = 0.0
    damping = [modal_damping(system, system.nodal_diameter(h)) for h in range(4)]
    for p, frequency in enumerate(hertz):
        omega = 2 * np.pi * frequency
        work = np.pi * np.vdot(system.force[1].vector, 1j * response.x[1][p]).real
        viscous = sum(
            np.pi * h**2 * omega * np.vdot(response.x[h][p], damping[h] @ response.x[h][p]).real
            for h in range(1, 4)
        )
        friction = response.dissipation[p].sum()
        assert abs(work - viscous - friction) < 1e-9 * work
        total += work
    assert response.dissipation.sum() > 0.3 * total


def test_damping_matrix_that_the_modes_do_not_diagonalise(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(7, damping_ratio=None, engine_order=0, sectors=1)
    rng = np.random.default_rng(0)
    factor = rng.normal(size=(20, 3))
    C = (0.01 * factor @ factor.T).astype(complex)
    damped = replace(system, diameters={0: replace(system.at(0), C=C)})
    assert structure(damped, 1).at(1).coupled_damping is not None
    hertz = first_frequency(system) * np.array([0.8, 1.3])
    response = frequency_response(damped, hertz, Options(2), find_jumps=False)
    assert response.converged.all()
    assert np.any(response.state == SLIP_OPEN)
    B = rows(system, 0)
    for p in (0, 1):
        for h in (1, 2):
            gap = dynamic_stiffness(damped, h, 2 * np.pi * hertz[p]) @ response.x[h][p]
            gap = gap + B.T @ response.force[p, h].reshape(-1)
            gap = gap - (system.force[1].vector if h == 1 else 0.0)
            assert np.abs(gap).max() < 1e-9 * np.abs(system.force[1].vector).max()


def test_a_force_above_the_harmonics_of_the_balance_is_refused(random_system: Make) -> None:
    system = random_system(1)
    size = len(system.at(system.nodal_diameter(3)).K)
    system = replace(system, force={**system.force, 3: Force(np.ones(size, complex))})
    refused = "harmonics: given 1: the system has force/3"
    with pytest.raises(InputError, match=refused):
        frequency_response(system, [0.1], Options(1))
    with pytest.raises(InputError, match=refused):
        linear_response(system, [0.1], harmonics=1)
    assert frequency_response(system, [0.1], Options(3)).x[3].any()
    assert linear_response(system, [0.1], harmonics=3).x[3].any()
    assert static_response(system).converged.all()


def test_unbalance_grows_with_the_square_of_the_speed(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(10, preload=1e3, mu=1e3)
    unbalance = replace(system, force={1: Force(system.force[1].vector, omega_power=2)})
    hertz = first_frequency(system) * np.array([0.7, 1.1])
    plain, grown = (linear_response(s, hertz, "all") for s in (system, unbalance))
    factor = (2 * np.pi * hertz[:, None]) ** 2
    np.testing.assert_allclose(grown.x[1], factor * plain.x[1], rtol=1e-12)
    response = frequency_response(unbalance, hertz, Options(1), find_jumps=False)
    np.testing.assert_allclose(response.x[1], grown.x[1], rtol=1e-9)


def test_static_state_balances_with_friction_and_lift_off(random_system: Make) -> None:
    # Interference on some contacts, gaps on others, pulled by a static load.
    system = random_system(11, contacts=12, size=16, engine_order=0, sectors=1, harmonics=0)
    rng = np.random.default_rng(3)
    system = replace(
        system,
        contacts=replace(system.contacts, v0=rng.normal(size=12)),
        force={0: Force(rng.normal(size=16).astype(complex))},
    )
    rest = static_response(system)
    known = static_response(system, modes=harmonic_modes(system, 0).diameters)
    np.testing.assert_array_equal(known.force, rest.force)
    assert rest.converged.all()
    assert set(rest.state[0]) == {STUCK, OPEN}
    assert rest.x[0].dtype == float
    B, x = rows(system, 0).real, rest.x[0][0]
    u = (B @ x).reshape(-1, 3)
    u[:, 0] += system.contacts.v0
    n = np.maximum(system.contacts.kn * u[:, 0], 0)
    limit = (system.contacts.mu * n)[:, None]
    t = np.clip(system.contacts.kt * u[:, 1:], -limit, limit)
    pull = np.column_stack([n, t])
    np.testing.assert_allclose(rest.force[0, 0].real, pull, atol=1e-12)
    assert np.any(np.abs(t) == limit, where=n[:, None] > 0), "some slide at assembly"
    gap = system.at(0).K @ x + B.T @ pull.reshape(-1) - system.force[0].vector
    assert np.abs(gap).max() < 1e-10 * np.abs(pull).max()
