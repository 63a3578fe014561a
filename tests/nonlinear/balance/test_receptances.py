"""Receptances tabulated over a range against those of all modes, and modes that are left out."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import first_frequency, random_system, stuck_stiffness
from vanelock.common.errors import InputError
from vanelock.nonlinear import SLIP, SLIP_OPEN, Force, Options, frequency_response, harmonic_modes
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.receptance_tables import Tabulated, balances


def checked(system, lowest):
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


def test_interpolated_receptances_are_those_of_all_modes():
    system = random_system(9, size=60)
    source = checked(system, first_frequency(system))
    assert isinstance(source, Tabulated)
    assert any(table.far.low for table in source.tables)


@pytest.mark.parametrize("beta", [0.02, 0.5, 2.0, 10.0])
def test_receptances_are_exact_with_overdamped_modes(beta):
    system = random_system(9, size=60, damping_ratio=None)
    damped = {
        k: replace(one, C=beta * stuck_stiffness(system, k)) for k, one in system.diameters.items()
    }
    checked(replace(system, diameters=damped), first_frequency(system))


@pytest.mark.parametrize("joints", ["stuck", "open"])
def test_systems_that_share_modes_share_tables_and_their_bits(joints):
    one = replace(random_system(9, size=60, harmonics=2), damping_joints=joints)
    forces = {h: replace(f, vector=1.7 * f.vector) for h, f in one.force.items()}
    other = replace(one, force=forces, contacts=replace(one.contacts, mu=0.4 * one.contacts.mu))
    modes = harmonic_modes(one, 2).diameters
    low, high = 2 * np.pi * first_frequency(one) * np.array([0.6, 1.6])
    first, second, alone = (
        balances(structure(system, 2, stuck=shared), low, high, 100)
        for system, shared in ((one, modes), (other, modes), (other, None))
    )
    assert isinstance(first, Tabulated)
    assert isinstance(second, Tabulated)
    for h in (1, 2):
        first.balance(1.1 * low).columns.all(h)  # all at once, which the second asks for in parts
        assert first.tables[h - 1].far.columns is second.tables[h - 1].far.columns
        shared, own = (source.balance(1.2 * low) for source in (second, alone))
        np.testing.assert_array_equal(shared.linear, own.linear)
        for components in (np.array([2]), np.array([2, 5])):
            got, expected = (each.columns.compute[h](components) for each in (shared, own))
            np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize(
    ("joints", "beyond", "greatest"),
    [("stuck", 6.0, 0.3), ("stuck", 16.0, 0.05), ("open", 6.0, 0.004)],
)
def test_estimated_truncation_is_the_error_made(joints, beyond, greatest):
    system = random_system(7, size=60, preload=10.0, damping_ratio=0.01)
    system = replace(system, damping_joints=joints)
    hertz = first_frequency(system) * np.array([0.3, 0.8, 1.2, 2.0])
    full, cut = (
        frequency_response(system, hertz, Options(3, static_beyond=each), find_jumps=False)
        for each in (None, beyond)
    )
    assert full.converged.all()
    assert np.isin(full.state, (SLIP, SLIP_OPEN)).any()
    assert np.all(full.truncation == 0.0)
    largest = np.abs(full.contact[:, 1:]).max(axis=(1, 2, 3))
    made = np.abs(cut.contact[:, 1:] - full.contact[:, 1:]).max(axis=(1, 2, 3)) / largest
    assert 0.2 * greatest < cut.truncation.max() < greatest
    # To first order: the larger the error, the less is it known.
    np.testing.assert_allclose(cut.truncation, made, rtol=0.1 + 3 * greatest)


def test_cut_off_structure_under_an_unbalance_is_the_same_from_tables():
    # Few frequencies are summed mode by mode; many come from tables.
    system = random_system(7, size=60, preload=10.0)
    system = replace(system, force={1: Force(system.force[1].vector, omega_power=2)})
    hertz = first_frequency(system) * np.linspace(1.2, 2.0, 60)
    tabulated, summed = (
        frequency_response(system, each, Options(1, static_beyond=3.0), find_jumps=False)
        for each in (hertz, hertz[[-20, -1]])
    )
    np.testing.assert_allclose(summed.contact[1], tabulated.contact[-1], atol=1e-8)
    assert np.abs(summed.contact[1, 1:]).max() > 1e-2


def test_truncation_is_refused_where_modes_are_coupled():
    system = random_system(7, damping_ratio=None)
    damped, rng = {}, np.random.default_rng(0)
    for k, one in system.diameters.items():
        factor = rng.normal(size=one.K.shape)
        damped[k] = replace(one, C=1e-3 * factor @ factor.T)
    system = replace(system, diameters=damped)
    with pytest.raises(InputError, match="static_beyond: given with a C that couples the modes"):
        frequency_response(system, [1.0], Options(1, static_beyond=10.0))
