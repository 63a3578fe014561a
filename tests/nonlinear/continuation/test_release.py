"""Contacts held by force, and what becomes of them when the force is taken away."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import first_frequency, random_system
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.continuation.globalisation import _released
from vanelock.nonlinear.newton.newton import solve


def family_of(system, hertz, harmonics=2):
    """The release of a system at a frequency."""
    balance = structure(system, harmonics).balance(2 * np.pi * hertz)
    return _released(balance, contact_law(system.contacts, harmonics))


@pytest.fixture(name="family")
def family_fixture():
    system = random_system(2, preload=0.1)
    return family_of(system, first_frequency(system))


def test_all_stick_where_held_and_are_themselves_in_the_end(family):
    u = family.balance.linear
    assert np.abs(family.friction(u).w).max() > 0.1 * np.abs(u).max()
    np.testing.assert_array_equal(family.law(1.0)(u).w, 0)
    for found, own in (
        (family.law(0.0)(u).w, family.friction(u).w),
        (family.law(0.0)(u).jacobian, family.friction(u).jacobian),
    ):
        np.testing.assert_allclose(found, own, atol=1e-12 * np.abs(own).max())


def test_rate_is_that_of_finite_differences(family):
    u, step = family.balance.linear, 1e-6
    rates = []
    for p in (0.02, 0.3):
        deviation = family.law(p)(u)
        rows = np.arange(u.size)
        rate = family.rate(p, deviation.w, deviation, rows).reshape(u.shape)
        ahead, behind = (family.law(p + s)(u).w for s in (step, -step))
        scale = np.abs(rate).max()
        np.testing.assert_allclose(rate, (ahead - behind) / (2 * step), atol=1e-5 * scale)
        rates.append(rate)
    assert np.abs(rates[0][:, 0]).max() > 0  # some are open


@pytest.mark.parametrize("seed", range(4))
def test_release_leads_to_the_solution_that_newton_finds_at_once(seed):
    system = random_system(seed, preload=0.3, contacts=5)
    rng = np.random.default_rng(seed)
    contacts = replace(
        system.contacts,
        mu=10 ** rng.uniform(-3, -1, 5),
        kt=system.contacts.kt * 10 ** rng.uniform(0, 4, (5, 1)),
    )
    family = family_of(replace(system, contacts=contacts), first_frequency(system))
    still = np.zeros_like(family.balance.linear)
    at_once = solve(fixed(family.balance, family.friction), still, 0.0)
    assert at_once.converged
    held = solve(family, still, 1.0)
    assert held.converged
    led = follow(family, held, 0.0, limit=600, effort=3000, shortest=1e-6).solution
    assert led is not None
    scale = np.abs(at_once.w).max()
    assert scale > 0.1 * np.abs(family.balance.linear).max()
    np.testing.assert_allclose(led.w, at_once.w, atol=1e-8 * scale)
