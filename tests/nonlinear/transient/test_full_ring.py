"""One sector at the nodal diameter of every harmonic against the whole ring, assembled."""

from dataclasses import replace

import numpy as np
import pytest

from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    linear_response,
    static_response,
    stuck_modes,
)

N, MASSES = 5, 3


def spring_mass_sector(seed):
    """K within a sector, K to the next one, M, contact rows on own and on next coordinates."""
    rng = np.random.default_rng(seed)
    K0, K1 = np.diag(rng.uniform(0.5, 1.0, MASSES)), np.zeros((MASSES, MASSES))
    for a in range(MASSES):  # springs between the masses, to ground and to the next sector
        for b in range(a):
            k = rng.uniform(0.1, 0.5)
            K0[[a, b], [a, b]] += k
            K0[[a, b], [b, a]] -= k
        k = rng.uniform(0.05, 0.3)
        b = int(rng.integers(MASSES))
        K0[a, a] += k
        K0[b, b] += k
        K1[a, b] -= k
    own, beyond = rng.normal(size=(2, 3, MASSES)), np.zeros((2, 3, MASSES))
    beyond[1] = rng.normal(size=(3, MASSES))  # the second contact lies between two sectors
    return K0, K1, np.diag(rng.uniform(0.5, 1.5, MASSES)), own, beyond


def sector(seed, order, v0):
    K0, K1, M, own, beyond = spring_mass_sector(seed)
    diameters = {}
    for k in range(N // 2 + 1):  # the others follow by conjugation
        next_ = K1 * np.exp(-2j * np.pi * k / N)
        diameters[k] = Diameter(
            K=K0 + next_ + next_.conj().T,
            M=M.astype(complex),
            own=own.astype(complex),
            next=beyond.astype(complex),
        )
    rng = np.random.default_rng(seed + 100)
    return System(
        sectors=N,
        engine_order=order,
        diameters=diameters,
        contacts=Contacts(
            rng.uniform(0.5, 1, 2), rng.uniform(0.5, 1, (2, 2)), np.full(2, 0.4), np.full(2, v0)
        ),
        force={
            0: Force((0.1 * rng.normal(size=MASSES)).astype(complex)),
            1: Force(np.asarray(rng.normal(size=(2, MASSES)).T @ [1, 1j], complex)),
            2: Force((0.3 * rng.normal(size=MASSES)).astype(complex)),
        },
        damping_ratio=0.03,
    )


def whole(seed, one):
    """The same ring with every sector's coordinates and contacts, no symmetry used."""
    K0, K1, M, own, beyond = spring_mass_sector(seed)
    step = np.roll(np.eye(N), 1, axis=1)  # picks the next sector
    K = np.kron(np.eye(N), K0) + np.kron(step, K1) + np.kron(step.T, K1.T)
    rows = np.concatenate(
        [
            np.concatenate(
                [own[c] * (i == j) + beyond[c] * ((i + 1) % N == j) for j in range(N)], axis=1
            )[None]
            for i in range(N)
            for c in range(2)
        ]
    )
    lag = -2 * np.pi * one.engine_order / N
    force = {
        h: Force(np.kron(np.exp(1j * h * lag * np.arange(N)), f.vector).astype(complex))
        for h, f in one.force.items()
    }
    contacts = one.contacts
    return System(
        sectors=1,
        engine_order=0,
        diameters={0: Diameter(K.astype(complex), np.kron(np.eye(N), M) + 0j, rows + 0j)},
        contacts=Contacts(
            np.tile(contacts.kn, N),
            np.tile(contacts.kt, (N, 1)),
            np.tile(contacts.mu, N),
            np.tile(contacts.v0, N),
        ),
        force=force,
        damping_ratio=one.damping_ratio,
    )


@pytest.mark.parametrize(
    ("harmonics", "order", "v0"),
    [(1, 1, 4.0), (4, 1, 0.5), (3, -1, 0.5), (3, 2, 0.5), (1, 5, 1.0), (3, 5, 1.0)],
)
def test_sector_balance_is_the_rings(order, v0, harmonics):
    one = sector(3, order, v0)
    one = replace(one, force={h: f for h, f in one.force.items() if h <= harmonics})
    ring = whole(3, one)
    hertz = np.array([0.12, 0.21])
    mine, all_ = (
        frequency_response(one, hertz, Options(harmonics), find_jumps=False),
        frequency_response(ring, hertz, Options(harmonics), find_jumps=False),
    )
    assert mine.converged.all()
    assert all_.converged.all()
    assert np.any(np.isin(mine.state, (SLIP, SLIP_OPEN)))
    lag = np.exp(-2j * np.pi * order * np.arange(N) / N)
    scale = np.abs(mine.x[1]).max()
    for h in range(harmonics + 1):
        expected = np.concatenate([mine.x[h] * lag[j] ** h for j in range(N)], axis=1)
        assert np.abs(all_.x[h] - expected).max() < 1e-7 * scale
    np.testing.assert_array_equal(all_.state, np.tile(mine.state, N))
    np.testing.assert_allclose(
        all_.dissipation.sum(axis=1), N * mine.dissipation.sum(axis=1), rtol=1e-7
    )


def test_static_and_linear_limits_of_the_ring():
    one = sector(4, 2, 0.7)
    ring = whole(4, one)
    rest, expected = static_response(one), static_response(ring)
    np.testing.assert_allclose(np.tile(rest.x[0], N), expected.x[0], atol=1e-12)
    for closed in ("all", "none"):
        a, b = (linear_response(s, [0.2, 0.3], closed, 2) for s in (one, ring))
        for h in (1, 2):
            scale = np.abs(b.x[h]).max()
            np.testing.assert_allclose(a.x[h], b.x[h][:, :MASSES], atol=1e-10 * scale)


def test_one_diameter_for_all_harmonics_is_another_structure():
    # The wave's own diameters reproduce the ring; that of the first harmonic for all does not.
    one = sector(3, 1, 0.5)
    hertz = [0.17, 0.21]
    wave = frequency_response(one, hertz, Options(5))
    same = frequency_response(one, hertz, Options(5, harmonic_diameters="sector"))
    np.testing.assert_array_equal(wave.harmonic_diameters, [0, 1, 2, 3, 4, 0])
    np.testing.assert_array_equal(same.harmonic_diameters, [0, 1, 1, 1, 1, 1])
    assert same.converged.all()
    assert np.abs(same.x[2] - wave.x[2]).max() > 0.05 * np.abs(wave.x[2]).max()


def test_known_modes_serve_other_friction_and_interference(monkeypatch):
    one = sector(3, 1, 0.5)
    modes = {k: stuck_modes(one, k) for k in one.diameters}
    contacts = replace(one.contacts, mu=0.7 * one.contacts.mu, v0=1.3 * one.contacts.v0)
    other = replace(one, contacts=contacts)
    plain = frequency_response(other, [0.17, 0.21], Options(5))
    monkeypatch.setattr("vanelock.nonlinear.balance.balance.stuck_modes", None)
    given = frequency_response(other, [0.17, 0.21], Options(5), modes=modes)
    np.testing.assert_array_equal(given.contact, plain.contact)
    assert np.any(
        given.contact != frequency_response(one, [0.17, 0.21], Options(5), modes=modes).contact
    )
