"""Receptances of all modes, in tables or cut off; damping of a structure with open joints."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import (
    first_frequency,
    proportional,
    random_system,
    solved_response,
    stuck_stiffness,
    with_contacts,
)
from tests.refusals import refused
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    Contact,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    stability,
    stuck_modes,
)
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


@pytest.mark.parametrize(("joints", "beyond", "greatest"), [
    ("stuck", 6.0, 0.3), ("stuck", 16.0, 0.05), ("open", 6.0, 0.004)
])  # fmt: skip
def test_estimated_truncation_is_the_error_made(joints, beyond, greatest):
    system = random_system(7, size=60, preload=10.0, damping_ratio=0.01)
    system = replace(system, damping_joints=joints)
    hertz = first_frequency(system) * np.array([0.3, 0.8, 1.2, 2.0])
    full, cut = (
        solved_response(system, hertz, Options(3, static_beyond=each)) for each in (None, beyond)
    )
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
        solved_response(system, each, Options(1, static_beyond=3.0))
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


ZETA = 0.02


def ring(seed=3, **more):
    """Four contacts that open and two that "free" leaves closed."""
    joint = ("pad", "pad", "seat", "pad", "seat", "pad")
    system = random_system(seed, damping_ratio=ZETA, **more)
    system = with_contacts(system, joint=joint, always_closed=("seat",))
    return replace(system, damping_joints="open")


def matrices(system, k):
    """K with the seat closed, K with all, M, and C by its definition."""
    seat = np.repeat(np.array(system.contacts.joint) == "seat", 3)
    one = system.at(k)
    b = system.contact_rows(k).reshape(-1, len(one.K))[seat]
    free = one.K + (b.conj().T * system.contacts.stiffness.reshape(-1)[seat]) @ b
    return free, stuck_stiffness(system, k), one.M, proportional(free, one.M, ZETA)


def receptance(system, k, s):
    """D̃⁻¹ by the modes."""
    modes = stuck_modes(system, k)
    return np.asarray(modes.shapes @ modes.solve(s, modes.shapes.conj().T))


def test_dynamic_stiffness_is_that_in_full_coordinates():
    system = ring()
    for k in system.diameters:
        free, stuck, M, C = matrices(system, k)
        resonance = np.sqrt(la.eigvalsh(free, M)[1])  # of the open structure: springs do nothing
        for s in (0.0, 0.4, resonance, 5.0):
            expected = la.inv(stuck - s**2 * M + 1j * s * C)
            atol = 1e-11 * np.abs(expected).max()
            np.testing.assert_allclose(receptance(system, k, s), expected, atol=atol)


def test_without_contacts_that_open_both_are_the_same():
    system = with_contacts(ring(), always_closed=("seat", "pad"))
    both = [replace(system, damping_joints=joints) for joints in ("open", "stuck")]
    a, b = (solved_response(one, [0.1, 0.14], Options(3)) for one in both)
    np.testing.assert_array_equal(a.contact, b.contact)


def test_rigid_motions_of_the_free_structure_are_not_damped():
    # A mass that hangs in its contact alone: nothing viscous is left.
    contact = Contact(tangential=0, kt=4.0, mu=1.0, preload=1.0)
    system = System.from_matrices([[1.0]], [[0.0]], [contact], damping_ratio=0.1)
    modes = stuck_modes(system, 0)
    assert modes.damping.tolist() == [0.0]
    assert modes.poles().tolist() == [0.0]
    np.testing.assert_allclose(receptance(system, 0, 1.0), [[1 / 3]], rtol=1e-12)
    np.testing.assert_allclose(receptance(system, 0, 0.0), [[1 / 4]], rtol=1e-12)


def test_massless_motion_that_only_opening_contacts_hold_is_refused():
    own = np.zeros((1, 3, 2))
    own[0, :, 1] = 1
    one = Diameter(K=np.diag([1.0, 0.0]), M=np.diag([1.0, 0.0]), own=own)
    contacts = Contacts([1.0], [[1.0, 1.0]], [1.0], [1.0])
    system = System(1, 0, {0: one}, contacts, damping_ratio=0.1, damping_joints="open")
    refused("they alone hold has no mass.*damping/joints", stuck_modes, system, 0)


def test_exponents_of_a_stuck_ring_are_its_eigenvalues():
    system = with_contacts(ring(sectors=4, preload=1e3), mu=np.full(6, 50.0))
    hertz = 0.2
    response = solved_response(system, [hertz], Options(1))
    found = stability(system, response, count=4)
    exponents = []
    for k in range(3):
        _, stuck, M, C = matrices(system, k)
        lower = np.hstack([-la.solve(M, stuck), -la.solve(M, C)])
        exponents.append(la.eigvals(np.vstack([np.eye(len(M), 2 * len(M), len(M)), lower])))
    every = np.concatenate([*exponents, *(one.conj() for one in exponents)])
    turned = every[:, None] + 2j * np.pi * hertz * np.arange(-60, 61)
    for one in found.exponent[0]:
        assert np.abs(turned - one).min() < 1e-10 * np.abs(every).min()
    assert found.growth[0, 0] == pytest.approx(every.real.max(), rel=1e-9)
