"""Loads that change with the frequency."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vanelock.nonlinear import Force, Options, System, frequency_response
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.families import Frequencies

Make = Callable[..., System]
Lowest = Callable[[System], float]


def test_static_load_that_grows_with_frequency_is_that_load(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(4, preload=0.5)
    hertz = first_frequency(system)
    push = np.random.default_rng(0).normal(size=len(system.at(0).K)).astype(np.complex128)
    omega = 2 * np.pi * hertz
    grown = Force((push / omega**2).astype(np.complex128), omega_power=2)
    growing = replace(system, force={**system.force, 0: grown})
    constant = replace(system, force={**system.force, 0: Force(push)})
    found, expected = (frequency_response(s, [hertz], Options(2)) for s in (growing, constant))
    assert expected.converged.all()
    np.testing.assert_allclose(found.contact, expected.contact, atol=1e-9)
    np.testing.assert_allclose(found.x[0], expected.x[0], atol=1e-9)
    family = Frequencies(structure(growing, 2), contact_law(system.contacts, 2))
    w, step = 0.1 * np.ones((system.contacts.count, 3, 5)), 1e-5 * omega
    rate = family.structure.slope(omega, w)
    ahead, behind = (family.at(omega + s).displacement(w) for s in (step, -step))
    np.testing.assert_allclose(rate, (ahead - behind) / (2 * step), atol=1e-6 * np.abs(rate).max())
