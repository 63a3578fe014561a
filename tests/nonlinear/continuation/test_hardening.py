"""Contacts soft at first, and what they become."""

import numpy as np
import pytest

from tests.nonlinear.systems import first_frequency, random_system
from vanelock.nonlinear import Contacts
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.continuation.globalisation import _Hardening
from vanelock.nonlinear.newton.newton import solve


def family_of(system, hertz, harmonics=2):
    balance = structure(system, harmonics).balance(2 * np.pi * hertz)
    return _Hardening(balance, contact_law(system.contacts, harmonics), 1e-2)


@pytest.fixture(name="system")
def system_fixture():
    return random_system(2, preload=0.1)


def test_rate_is_that_of_finite_differences(system):
    family = family_of(system, first_frequency(system))
    w = 0.3 * np.random.default_rng(1).normal(size=family.balance.linear.shape)
    u, rows, step = family.balance.displacement(w), np.arange(w.size), 1e-6
    for p in (0.1, 0.8):
        rate = family.rate(p, w, family.law(p)(u), rows).reshape(w.shape)
        ahead, behind = (family.law(p + s)(u).w for s in (step, -step))
        scale = np.abs(rate).max()
        np.testing.assert_allclose(rate, (ahead - behind) / (2 * step), atol=1e-8 * scale)


def test_soft_contacts_are_those_of_a_system_with_soft_springs(system):
    # The same force on the structure: s K_c (u - W) = K_c (u - W_s).
    family = family_of(system, first_frequency(system))
    u = 0.3 * np.random.default_rng(1).normal(size=family.balance.linear.shape)
    share = 0.1
    given = system.contacts
    soft = Contacts(share * given.kn, share * given.kt, given.mu, given.v0)
    expected = soft.stiffness[:, :, None] * (u - contact_law(soft, 2)(u).w)
    found = given.stiffness[:, :, None] * (u - family.law(0.5)(u).w)
    np.testing.assert_allclose(found, expected, atol=1e-14 * np.abs(expected).max())
    np.testing.assert_array_equal(family.law(1.0)(u).w, contact_law(given, 2)(u).w)


def test_path_of_hardening_contacts_ends_at_the_solution(system):
    family = family_of(system, 1.2 * first_frequency(system))
    start = np.zeros_like(family.balance.linear)
    begun = solve(family, start, 0.0, limit=40)
    assert begun.converged
    arc = follow(family, begun, 1.0)
    assert arc.solution is not None
    # Newton's iteration on the problem itself stays where the path ended.
    again = solve(fixed(family.balance, family.friction), arc.solution.w, 0.0)
    assert again.converged
    assert again.iterations <= 1
    np.testing.assert_allclose(again.u, arc.solution.u, atol=1e-9 * np.abs(again.u).max())
