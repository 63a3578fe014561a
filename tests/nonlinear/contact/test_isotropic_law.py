"""Isotropic friction against theory and radial return in small steps."""

import numpy as np
import pytest

from tests.nonlinear.systems import alike_contacts, drawn_contacts
from vanelock.common.errors import InputError
from vanelock.nonlinear import Contacts
from vanelock.nonlinear.contact.law import STUCK, contact_law
from vanelock.nonlinear.fourier import to_complex, to_real


def plane_law(contacts, harmonics):
    return contact_law(contacts, harmonics, friction="isotropic")


@pytest.mark.parametrize("harmonics", [1, 5])
def test_located_law_is_continuous_where_events_pass_the_ends_of_steps(harmonics):
    # A shift in time turns the coefficients and moves all events alike.
    contacts, u = drawn_contacts(harmonics, 40, 70 + harmonics, plane=True)
    law, moved = plane_law(contacts, harmonics), []
    for shift in np.linspace(0.0, 0.5, 41):
        turn = np.exp(1j * np.arange(harmonics + 1) * shift)[:, None, None]
        moved.append(to_complex(law(to_real(to_complex(u) * turn)).w) / turn)
    apart = np.abs(np.array(moved) - moved[0]).max(axis=(0, 1, 3)) / np.abs(u).max(axis=(1, 2))
    assert np.median(apart) < 1e-8
    assert apart.max() < 2e-5


def test_contact_that_slid_at_assembly_rests_at_the_nearest_common_point():
    # The discs' centres run on a line at a distance from zero; where they have common points the
    # slider rests at the one nearest to zero, found here by trying many.
    rng = np.random.default_rng(8)
    grid = np.stack(np.meshgrid(*2 * [np.linspace(-3, 3, 241)], indexing="ij"), -1).reshape(-1, 2)
    held = 0
    for _ in range(30):
        u = np.zeros((1, 3, 3))
        u[0, 0, 0], u[0, 1:, 0] = rng.uniform(0.5, 2.0), rng.uniform(-2, 2, 2)
        u[0, 1:, 1:], u[0, 0, 1:] = 0.6 * rng.normal(size=(2, 2)), 0.2 * rng.normal(size=2)
        found = plane_law(alike_contacts(), 1)(u)
        angle = 2 * np.pi * np.arange(512) / 512
        v, x, y = u[0] @ np.array([np.ones(512), np.cos(angle), -np.sin(angle)])
        common = grid
        for few in (slice(0, None, 32), slice(None)):  # most places fail at once
            outside = np.hypot(common[:, :1] - x[few], common[:, 1:] - y[few]) - v[few]
            common = common[outside.max(axis=1) <= 0.0]
        assert (found.state[0] == STUCK) == (len(common) > 0)
        if not len(common):
            continue
        held += 1
        w = found.w[0, 1:, 0]
        np.testing.assert_array_equal(found.w[0, :, 1:], 0)
        assert (np.hypot(w[0] - x, w[1] - y) - v).max() < 1e-12
        nearest = np.hypot(*common.T).min()
        assert nearest - 0.036 < np.hypot(*w) < nearest + 1e-12
    assert held >= 10


@pytest.mark.parametrize("ratio", [1e-2, 1e-7, 1e-12, 1e-16, 1e-30])
def test_contact_in_phase_with_its_load_slides_as_in_one_direction(ratio):
    # Nothing is damped: u and v turn back at the same instants, where λ vanishes. The law of one
    # direction is another one and exact; where μ n/kt vanishes beside the motion, w = u.
    u = np.zeros((1, 3, 3))
    u[0, :2] = [[0.9790803, 3.6106976, 6.7e-9], [-0.4395402, -4.5107143, -8.4e-9]]
    contacts = alike_contacts(mu=ratio)
    for v0 in (u[0, 0, 0], 9.0):
        u[0, 0, 0] = v0
        one, plane = contact_law(contacts, 1)(u), plane_law(contacts, 1)(u)
        np.testing.assert_array_equal(plane.state, one.state)
        np.testing.assert_allclose(plane.w, one.w, rtol=0, atol=1e-12)
        work = one.dissipation if ratio > 1e-14 else np.zeros(1)
        np.testing.assert_allclose(plane.dissipation, work, rtol=1e-4)


def test_different_stiffness_in_the_two_directions_is_refused():
    contacts = Contacts(np.ones(2), np.array([[1.0, 1.0], [1.0, 2.0]]), np.ones(2), np.ones(2))
    with pytest.raises(InputError, match=r"friction: given 'isotropic': contact 1 has kt \(1, 2\)"):
        plane_law(contacts, 1)
    with pytest.raises(InputError, match="allowed: orthogonal, isotropic"):
        contact_law(contacts, 1, friction="round")
