"""Receptances tabulated over a range of frequencies against those summed over all modes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from vanelock.nonlinear import System, harmonic_modes
from vanelock.nonlinear.balance.balance import Structure, structure
from vanelock.nonlinear.balance.receptance_tables import Tabulated, balances

Make = Callable[..., System]
Lowest = Callable[[System], float]


def checked(system: System, lowest: float) -> Structure | Tabulated:
    """What gives the balances around the lowest frequency, Hz, its receptances checked."""
    prepared = structure(system, 3)
    low, high = 2 * np.pi * lowest * np.array([0.6, 1.6])
    source = balances(prepared, low, high, 100)
    for omega in np.linspace(low, high, 7):
        for h in range(4):
            expected = prepared.balance(omega).columns.all(h)
            error = np.abs(source.balance(omega).columns.all(h) - expected).max()
            assert error < 1e-13 * np.abs(expected).max()
    return source


def test_interpolated_receptances_are_those_of_all_modes(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(9, size=60)
    table = checked(system, first_frequency(system))
    assert isinstance(table, Tabulated)
    assert any(each.low for each in table.tables)


@pytest.mark.parametrize("beta", [0.02, 0.5, 2.0, 10.0])
def test_receptances_are_exact_with_overdamped_modes(
    random_system: Make, first_frequency: Lowest, beta: float
) -> None:
    system = random_system(9, size=60, damping_ratio=None)
    damped = {}
    for k, matrices in system.diameters.items():
        B = system.contact_rows(k).reshape(-1, len(matrices.K))
        stuck = matrices.K + (B.conj().T * system.contacts.stiffness.reshape(-1)) @ B
        damped[k] = replace(matrices, C=beta * stuck)
    checked(replace(system, diameters=damped), first_frequency(system))


@pytest.mark.parametrize("joints", ["stuck", "open"])
def test_systems_that_share_modes_share_tables_and_their_bits(
    random_system: Make, first_frequency: Lowest, joints: str
) -> None:
    one = replace(random_system(9, size=60, harmonics=2), damping_joints=joints)
    forces = {h: replace(f, vector=1.7 * f.vector) for h, f in one.force.items()}
    other = replace(one, force=forces, contacts=replace(one.contacts, mu=0.4 * one.contacts.mu))
    modes = harmonic_modes(one, 2).diameters
    low, high = 2 * np.pi * first_frequency(one) * np.array([0.6, 1.6])
    first, second, alone = (
        balances(structure(system, 2, stuck=known), low, high, 100)
        for system, known in ((one, modes), (other, modes), (other, None))
    )
    assert isinstance(first, Tabulated)
    assert isinstance(second, Tabulated)
    for h in (1, 2):
        first.balance(1.1 * low).columns.all(h)  # all at once, which the second asks for in parts
        assert first.tables[h - 1].columns is second.tables[h - 1].columns
        wanted = np.array([2, 5])
        shared, own = (each.balance(1.2 * low) for each in (second, alone))
        np.testing.assert_array_equal(shared.linear, own.linear)
        for components in (wanted[:1], wanted):
            got, expected = (each.columns.compute[h](components) for each in (shared, own))
            np.testing.assert_array_equal(got, expected)
