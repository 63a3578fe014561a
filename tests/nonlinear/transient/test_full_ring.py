"""One sector at the nodal diameter of every harmonic against the whole ring, assembled."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import with_contacts
from tests.verification.nonlinear.spring_rings import CONTACTS, MASSES, assembled, spring_ring
from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
)

SEED, N = 0, 5


def sector(order, v0, harmonics):
    """A ring's sector under loads in three harmonics."""
    system, rng = spring_ring(SEED), np.random.default_rng(103)
    force = {
        0: Force(0.1 * rng.normal(size=MASSES)),
        1: system.force[1],
        2: Force(0.3 * rng.normal(size=MASSES)),
    }
    force = {h: f for h, f in force.items() if h <= harmonics}
    system = replace(system, engine_order=order, force=force)
    return with_contacts(system, v0=np.full(CONTACTS, v0))


def whole(one):
    """The same ring with every sector's coordinates and contacts, no symmetry used."""
    K, M, B, *_ = assembled(SEED)
    lag = np.exp(-2j * np.pi * one.engine_order * np.arange(N) / N)
    force = {h: Force(np.kron(lag**h, f.vector)) for h, f in one.force.items()}
    given = one.contacts
    kt, others = np.tile(given.kt, (N, 1)), (np.tile(x, N) for x in (given.mu, given.v0))
    contacts = Contacts(np.tile(given.kn, N), kt, *others)
    diameter = Diameter(K, M, B.reshape(-1, 3, N * MASSES))
    return System(1, 0, {0: diameter}, contacts, force, damping_ratio=one.damping_ratio)


@pytest.mark.parametrize(
    ("harmonics", "order", "v0"),
    [(1, 1, 4.0), (4, 1, 0.5), (3, -1, 0.5), (3, 2, 0.5), (1, 5, 1.0), (3, 5, 1.0)],
)
def test_sector_balance_is_the_rings(order, v0, harmonics):
    one = sector(order, v0, harmonics)
    hertz = np.array([0.12, 0.21])
    mine, ring = (
        frequency_response(system, hertz, Options(harmonics), find_jumps=False)
        for system in (one, whole(one))
    )
    assert mine.converged.all()
    assert ring.converged.all()
    assert np.any(np.isin(mine.state, (SLIP, SLIP_OPEN)))
    lag = np.exp(-2j * np.pi * order * np.arange(N) / N)
    scale = np.abs(mine.x[1]).max()
    for h in range(harmonics + 1):
        expected = np.concatenate([mine.x[h] * lag[j] ** h for j in range(N)], axis=1)
        assert np.abs(ring.x[h] - expected).max() < 1e-7 * scale
    np.testing.assert_array_equal(ring.state, np.tile(mine.state, N))
    work = N * mine.dissipation.sum(axis=1)
    np.testing.assert_allclose(ring.dissipation.sum(axis=1), work, rtol=1e-7)


def test_one_diameter_for_all_harmonics_is_another_structure():
    # The wave's own diameters reproduce the ring; that of the first harmonic for all does not.
    one, hertz = sector(1, 0.5, 2), [0.17, 0.21]
    wave = frequency_response(one, hertz, Options(5))
    same = frequency_response(one, hertz, Options(5, harmonic_diameters="sector"))
    np.testing.assert_array_equal(wave.harmonic_diameters, [0, 1, 2, 3, 4, 0])
    np.testing.assert_array_equal(same.harmonic_diameters, [0, 1, 1, 1, 1, 1])
    assert same.converged.all()
    assert np.abs(same.x[2] - wave.x[2]).max() > 0.05 * np.abs(wave.x[2]).max()
