"""Linear limits by modes against the matrices at each frequency."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import first_frequency, random_system, rows, with_rest
from vanelock.nonlinear import (
    OPEN,
    STUCK,
    Contacts,
    Diameter,
    Force,
    System,
    linear_response,
    stuck_modes,
)
from vanelock.nonlinear.balance.limit_modes import limit_modes
from vanelock.rom import linear_damping

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


def test_repetition_gives_way_to_all_modes_at_once(monkeypatch):
    """Where damping couples far modes more than they are stiff."""
    monkeypatch.setattr("vanelock.nonlinear.balance.limit_modes._FEW", 0)
    system = scene("open", 0.01, False, True)
    A = np.random.default_rng(1).standard_normal((N, N))
    system = replace(system, diameters={0: replace(system.at(0), C=1e5 * A @ A.T)})
    modes = stuck_modes(system, 0)
    closed = np.ones(3 * C, bool)
    limit = limit_modes(modes, system.contacts.stiffness.ravel(), closed)
    push = modes.shapes.T @ system.force[1].vector
    found, left = limit.solve(np.array([100.0]), push[:, None])
    exact = by_definition(system, np.ones(C, bool), 100.0)
    np.testing.assert_allclose(np.abs(modes.rows @ found).reshape(-1, 3), exact, rtol=1e-7)
    assert left[0] < 1e-8


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
