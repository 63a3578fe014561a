"""The condensed balance and its linear limits against full coordinates and finite differences."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import (
    first_frequency,
    random_system,
    rows,
    solved_response,
    stuck_damping,
    with_contacts,
    with_rest,
)
from tests.refusals import refused
from vanelock.nonlinear import (
    OPEN,
    SLIP,
    SLIP_OPEN,
    STUCK,
    Contact,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    audit_response,
    frequency_response,
    linear_response,
    static_response,
    stuck_modes,
)
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.families import Frequencies
from vanelock.nonlinear.newton.linearised import newton_matrix
from vanelock.rom import linear_damping


def dynamic_stiffness(system, harmonic, omega):
    k, s = system.nodal_diameter(harmonic), harmonic * omega
    matrices, C = system.at(k), stuck_damping(system, k)
    C = C if matrices.C is None else C + matrices.C
    return matrices.K - s**2 * matrices.M + 1j * s * C


@pytest.mark.parametrize("harmonics", [1, 3])
def test_newton_matrix_is_the_derivative_in_every_state(harmonics):
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

    def gap(w, omega=omega):
        return (w - law(prepared.balance(omega).displacement(w)).w).reshape(-1)

    for _ in range(3):
        direction, step = rng.normal(size=shape), 1e-6
        measured = (gap(w + step * direction) - gap(w - step * direction)) / (2 * step)
        exact = matrix @ direction.reshape(-1)
        assert np.abs(measured - exact).max() < 1e-7 * np.abs(exact).max()
    step = 1e-6 * omega
    measured = (gap(w, omega + step) - gap(w, omega - step)) / (2 * step)
    exact = -Frequencies(prepared, law).rate(omega, w, found, every)
    assert np.abs(measured - exact).max() < 1e-6 * np.abs(exact).max()


def test_linear_response_at_a_free_resonance_far_below_the_contacts():
    # Stuck, the structure hardly moves; free, it resonates with little damping.
    system = random_system(2, damping_ratio=1e-6)
    system = with_contacts(system, kn=np.full(6, 1e6), kt=np.full((6, 2), 1e6))
    hertz = first_frequency(system)
    response = linear_response(system, [hertz], "none")
    assert response.converged.all()
    x = la.solve(dynamic_stiffness(system, 1, 2 * np.pi * hertz), system.force[1].vector)
    assert np.abs(x).max() > 1e3 * np.abs(linear_response(system, [hertz], "all").x[1]).max()
    # Rounding of 1e6 N/m, 1e-10 N/m, detunes what is damped by 1e-6 of its stiffness.
    assert np.abs(response.x[1][0] - x).max() < 1e-5 * np.abs(x).max()


def test_closed_names_joints_and_refuses_what_does_not_fit():
    system = random_system(4)
    named = with_contacts(system, joint=("hook",) * 2 + ("interlock",) * 4)
    mask = np.array([True] * 2 + [False] * 4)
    by_name = linear_response(named, [0.1], "hook")
    np.testing.assert_array_equal(by_name.x[1], linear_response(system, [0.1], mask).x[1])
    of_none, none = linear_response(system, [0.1], []), linear_response(system, [0.1], "none")
    np.testing.assert_array_equal(of_none.x[1], none.x[1])  # also where no joint has a name
    refused("'bolt'.*hook, interlock", linear_response, named, [0.1], "bolt")
    refused(r"needs bool, \(6,\)", linear_response, named, [0.1], mask[:3])


def test_a_static_load_that_nothing_holds_is_refused():
    mass = Diameter(K=[[0.0]], M=[[1.0]], own=[[[0.0], [1.0], [0.0]]])
    contacts = Contacts([1.0], [[1.0, 1.0]], [0.3], [1.0])
    loose = System(1, 0, {0: mass}, contacts, {0: Force([1.0]), 1: Force([1.0])})
    refused("do not hold the static load", linear_response, loose, [1.0], "none")
    free = linear_response(replace(loose, force={1: loose.force[1]}), [1.0], "none")
    np.testing.assert_allclose(free.x[1][0, 0], -1 / (2 * np.pi) ** 2, rtol=1e-12)


def test_damping_matrix_that_the_modes_do_not_diagonalise():
    system = random_system(7, damping_ratio=None, engine_order=0, sectors=1)
    factor = np.random.default_rng(0).normal(size=(20, 3))
    damped = replace(system, diameters={0: replace(system.at(0), C=0.01 * factor @ factor.T + 0j)})
    assert structure(damped, 1).at(1).coupled_damping is not None
    hertz = first_frequency(system) * np.array([0.8, 1.3])
    response = solved_response(damped, hertz, Options(2))
    assert np.any(response.state == SLIP_OPEN)
    for p in (0, 1):
        for h in (1, 2):
            gap = dynamic_stiffness(damped, h, 2 * np.pi * hertz[p]) @ response.x[h][p]
            gap = gap + rows(system, 0).T @ response.force[p, h].reshape(-1)
            gap = gap - (system.force[1].vector if h == 1 else 0.0)
            assert np.abs(gap).max() < 1e-9 * np.abs(system.force[1].vector).max()


def test_a_force_above_the_harmonics_of_the_balance_is_refused():
    system = random_system(1)
    size = len(system.at(system.nodal_diameter(3)).K)
    system = replace(system, force={**system.force, 3: Force(np.ones(size))})
    words = "harmonics: given 1: the system has force/3"
    refused(words, frequency_response, system, [0.1], Options(1))
    refused(words, linear_response, system, [0.1], harmonics=1)
    assert frequency_response(system, [0.1], Options(3)).x[3].any()
    assert linear_response(system, [0.1], harmonics=3).x[3].any()
    assert static_response(system).converged.all()


def test_unbalance_grows_with_the_square_of_the_speed():
    system = random_system(10, preload=1e3, mu=1e3)
    unbalance = replace(system, force={1: Force(system.force[1].vector, omega_power=2)})
    hertz = first_frequency(system) * np.array([0.7, 1.1])
    plain, grown = (linear_response(s, hertz, "all") for s in (system, unbalance))
    factor = (2 * np.pi * hertz[:, None]) ** 2
    np.testing.assert_allclose(grown.x[1], factor * plain.x[1], rtol=1e-12)
    response = solved_response(unbalance, hertz, Options(1))
    np.testing.assert_allclose(response.x[1], grown.x[1], rtol=1e-9)


def test_static_load_that_grows_with_frequency_is_that_load():
    system = random_system(4, preload=0.5)
    hertz = first_frequency(system)
    push, omega = np.random.default_rng(0).normal(size=20), 2 * np.pi * hertz
    growing, constant = (
        replace(system, force={**system.force, 0: load})
        for load in (Force(push / omega**2, omega_power=2), Force(push))
    )
    found, expected = (solved_response(s, [hertz], Options(2)) for s in (growing, constant))
    np.testing.assert_allclose(found.contact, expected.contact, atol=1e-9)
    np.testing.assert_allclose(found.x[0], expected.x[0], atol=1e-9)
    family = Frequencies(structure(growing, 2), contact_law(system.contacts, 2))
    w, step = 0.1 * np.ones((system.contacts.count, 3, 5)), 1e-5 * omega
    rate = family.structure.slope(omega, w)
    ahead, behind = (family.at(omega + s).displacement(w) for s in (step, -step))
    np.testing.assert_allclose(rate, (ahead - behind) / (2 * step), atol=1e-6 * np.abs(rate).max())


K = np.array([[30.0, -5.0], [-5.0, 20.0]])
ZETA = 0.01


def linked(kt, damping):
    """Two masses of 1 kg on springs, which a stuck contact joins."""
    contact = Contact(tangential=(1, 0), kt=kt, mu=0.5, preload=1e3)
    loads = {"force": {1: 1.0}, "static_force": {0: -3.0}}
    system = System.from_matrices(np.eye(2), K, [contact], damping_ratio=ZETA, **loads)
    return replace(system, damping_joints=damping)


@pytest.mark.parametrize("kt", [1e10, 1e13, 1e16, 1e18, 1e30])
@pytest.mark.parametrize("damping", ["open", "stuck"])
def test_a_far_stiffer_contact_is_a_rigid_link(kt, damping):
    """Both masses then are one, 2 kg on 40 N/m; forces lost in rounding are no solution."""
    system = linked(kt, damping)
    response = frequency_response(system, [0.5], Options(harmonics=1))
    if damping == "stuck" or kt <= 1e16:
        np.testing.assert_allclose(response.x[0][0], -3 / 40, rtol=1e-8)
    s = 2 * np.pi * 0.5
    c = 2 * ZETA * (la.sqrtm(K).sum() if damping == "open" else np.sqrt(2 * 40.0))
    exact = 1 / abs(40 - 2 * s**2 + 1j * s * c)
    np.testing.assert_allclose(np.abs(response.x[1][0]), exact, rtol=1e-8)
    if response.converged[0] and kt <= 1e16:  # beyond, rounding is all that an audit sees
        checked = audit_response(system, response)
        assert checked.residual[0] < 1e-6 + checked.residual_error[0]


def test_modes_that_are_not_those_of_the_matrices_are_noticed():
    system = linked(30.0, "open")
    assert linear_response(system, [0.5]).residual.max() < 1e-14
    modes = stuck_modes(system, 0)
    wrong = {0: replace(modes, shapes=modes.shapes * [1.0, 1 + 1e-4])}
    for response in (
        linear_response(system, [0.5], modes=wrong),
        frequency_response(system, [0.5], Options(1), modes=wrong),
    ):
        assert 1e-6 < response.residual[0] < 1e-3
        assert not response.converged[0]


N, C = 30, 5


def scene(damping, ratio, given, free):
    """Two chains that contacts join; nothing else need hold them."""
    rng = np.random.default_rng(4)
    chain = np.diag(np.full(N, 2.0)) - np.eye(N, k=1) - np.eye(N, k=-1)
    chain[0, 0] = chain[-1, -1] = 1.0
    chain[N // 2 - 1 : N // 2 + 1, N // 2 - 1 : N // 2 + 1] += np.array([[-1, 1], [1, -1]])
    K = 1e6 * chain + (0 if free else 1e4) * np.eye(N)
    M = np.diag(rng.uniform(0.5, 1.5, N))
    own = np.zeros((C, 3, N))
    for i in range(C):
        for d in range(3):
            own[i, d, rng.integers(N // 2)], own[i, d, rng.integers(N // 2, N)] = 1, -1
    A = rng.standard_normal((N, 3))
    matrices = Diameter(K, M, own, output=own[:1], C=A @ A.T if given else None)
    stiffness = rng.uniform(1e4, 1e6, (C, 3))
    contacts = Contacts(stiffness[:, 0], stiffness[:, 1:], np.full(C, 0.3), np.zeros(C))
    push = rng.standard_normal(N)  # real numbers, as a user may give them, or complex ones
    force = {1: Force(push + 1j * rng.standard_normal(N) if free else push)}
    return System(1, 1, {0: matrices}, contacts, force, ("a",), ratio, damping)


def by_definition(system, closed, s):
    """Displacements of the contacts."""
    given, k = system.at(0), system.contacts.stiffness
    B = given.own.reshape(-1, N)
    K = given.K + (B.T * np.where(closed[:, None], k, 0).ravel()) @ B
    every = given.K + (B.T * k.ravel()) @ B
    damped = given.K if system.damping_joints == "open" else every
    omega2, V = la.eigh(damped, given.M)
    MV = given.M @ V
    C = (MV * (2 * system.damping_ratio * np.sqrt(np.where(omega2 > 1e-2, omega2, 0)))) @ MV.T
    C = C if given.C is None else C + given.C
    D = K - s**2 * given.M + 1j * s * C
    return np.asarray(np.abs(B @ np.linalg.solve(D, system.force[1].vector)).reshape(-1, 3))


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("given", [False, True])
@pytest.mark.parametrize("ratio", [1e-3, 0.05, 0.9])
@pytest.mark.parametrize("damping", ["open", "stuck"])
@pytest.mark.parametrize("few", [0, 100])
def test_limits_are_those_of_the_matrices(monkeypatch, few, damping, ratio, given, free):
    """Some contacts closed, whatever the damping is of; also where nothing holds the structure."""
    monkeypatch.setattr("vanelock.nonlinear.balance.limit_modes._FEW", few)
    system = scene(damping, ratio, given, free)
    for closed in (np.zeros(C, bool), np.ones(C, bool), np.arange(C) < 2):
        response = linear_response(system, [2.0, 40.0, 120.0, 290.0], closed)
        assert response.converged.all()
        for i, hertz in enumerate(response.frequency):
            exact = by_definition(system, closed, 2 * np.pi * hertz)
            found = np.abs(response.contact[i, 1])
            np.testing.assert_allclose(found, exact, rtol=1e-8, atol=1e-8 * exact.max())


@pytest.mark.parametrize("joints", ["stuck", "open"])
@pytest.mark.parametrize("closed", ["none", "all", "some"])
@pytest.mark.parametrize("static", [0, 2])
def test_limits_of_a_ring_are_those_of_the_dense_equations(joints, closed, static):
    system = with_rest(replace(random_system(7), damping_joints=joints))
    push = replace(system.force[0], omega_power=static)
    system = replace(system, force={**system.force, 0: push})
    mask = np.full(system.contacts.count, closed == "all")
    mask[::2] |= closed == "some"
    hertz = first_frequency(system) * np.array([0.7, 1.0, 1.01])
    found = linear_response(system, hertz, mask, harmonics=2)
    assert found.converged.all()
    assert np.all(found.state == np.where(mask, STUCK, OPEN))
    k, offset = system.contacts.stiffness[mask].reshape(-1), system.contacts.offset
    for h in range(3):
        nd = system.nodal_diameter(h)
        one, every, C = system.at(nd), rows(system, nd), linear_damping(system, nd)
        B = every[np.repeat(mask, 3)]
        for i, omega in enumerate(2 * np.pi * hertz):
            s = h * omega
            dynamic = one.K + (B.conj().T * k) @ B - s**2 * one.M + 1j * s * C
            force = system.force[h].at(omega) if h in system.force else np.zeros(20)
            if h == 0:
                force = force - B.conj().T @ (k * offset[mask].ravel())
            x = np.linalg.solve(dynamic, force)
            np.testing.assert_allclose(found.x[h][i], x, atol=1e-8 * max(np.abs(x).max(), 1e-300))
            u = (every @ x).reshape(-1, 3) + (offset if h == 0 else 0.0)
            np.testing.assert_allclose(found.contact[i, h], u, atol=1e-8 * np.abs(u).max() + 1e-300)
