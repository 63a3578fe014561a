"""Paths along loads, soft and held contacts: rates by differences, and where paths lead."""

import math
from itertools import islice

import numpy as np
import pytest

from tests.nonlinear.peaks.test_peak import jenkins
from tests.nonlinear.systems import first_frequency, random_system, with_contacts
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation import arc_length
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.families import Frequencies, fixed
from vanelock.nonlinear.continuation.globalisation import _released
from vanelock.nonlinear.continuation.path import SolutionPath
from vanelock.nonlinear.newton.newton import solve


def balance_of(system, factor=1.0):
    omega = 2 * np.pi * factor * first_frequency(system)
    return structure(system, 2).balance(omega)


def released(system, **law):
    """Contacts held by force, which is taken away."""
    return _released(balance_of(system), contact_law(system.contacts, 2, **law))


@pytest.mark.parametrize("seed", range(4))
def test_release_leads_to_the_solution_that_newton_finds_at_once(seed):
    system, rng = random_system(seed, preload=0.3, contacts=5), np.random.default_rng(seed)
    mu, stiffer = 10 ** rng.uniform(-3, -1, 5), 10 ** rng.uniform(0, 4, (5, 1))
    family = released(with_contacts(system, mu=mu, kt=system.contacts.kt * stiffer))
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


@pytest.mark.parametrize(("jump", "kink"), [(0.0, False), (0.0, True), (1.0, True)])
def test_a_quantity_that_jumps_is_located_unless_the_path_jumps(monkeypatch, jump, kink):
    system = jenkins(force=3.0)
    family = Frequencies(structure(system, 1), contact_law(system.contacts, 1))
    begun = solve(family, np.zeros((1, 3, 3)), 0.9)
    before, after = islice(SolutionPath(family, begun, 1.2), 2)
    first, last = before.solution.parameter, after.solution.parameter
    middle = 0.3 * first + 0.7 * last

    def moved(*given, **options):
        found = solve(*given, **options)
        aside = jump * np.ptp([before.solution.w, after.solution.w], axis=0)
        vars(found)["w"] = found.w + (aside if found.parameter > middle else 0.0)
        return found

    def quantity(solution, tangent=None):
        left = middle - solution.parameter
        return math.copysign(1.0, left) if kink else float(left)

    monkeypatch.setattr(arc_length, "solve", moved)
    ends = (quantity(before.solution), quantity(after.solution))
    found = arc_length.locate(family, before, after, quantity, ends)
    if jump:
        assert found is None
    else:
        assert found is not None
        assert found.solution.parameter == pytest.approx(middle, rel=1e-10)
