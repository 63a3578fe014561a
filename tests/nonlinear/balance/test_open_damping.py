"""Damping of the structure whose joints are open, given beside springs that stick."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import (
    proportional,
    random_system,
    stuck_stiffness,
    with_contacts,
)
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contact,
    Contacts,
    Diameter,
    Options,
    System,
    frequency_response,
    stability,
    stuck_modes,
)

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
    a, b = (frequency_response(one, [0.1, 0.14], Options(3), find_jumps=False) for one in both)
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
    with pytest.raises(InputError, match="they alone hold has no mass.*damping/joints"):
        stuck_modes(system, 0)


def test_exponents_of_a_stuck_ring_are_its_eigenvalues():
    system = with_contacts(ring(sectors=4, preload=1e3), mu=np.full(6, 50.0))
    hertz = 0.2
    response = frequency_response(system, [hertz], Options(1), find_jumps=False)
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
