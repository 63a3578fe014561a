"""Isotropic friction against theory and radial return in small steps."""

import numpy as np
import pytest

from tests.nonlinear.systems import alike_contacts, drawn_contacts, jenkins_element
from vanelock.common.errors import InputError
from vanelock.nonlinear import Contacts
from vanelock.nonlinear.contact.disc_slider import HELD, pursue
from vanelock.nonlinear.contact.isotropic_law import slider_places
from vanelock.nonlinear.contact.law import SLIP, SLIP_OPEN, STUCK, contact_law
from vanelock.nonlinear.fourier import TURN, to_complex, to_real


def plane_law(contacts, harmonics):
    return contact_law(contacts, harmonics, friction="isotropic")


def radial_return(contacts, u, count, laps):
    """Sliders (count, c, 2) in the last lap, by catching up with the disc."""
    wave = np.exp(1j * TURN * np.outer(np.arange(count), np.arange(u.shape[2] // 2 + 1)) / count)
    q = np.einsum("th,hcd->tcd", wave, to_complex(u)).real
    reach = contacts.alpha[:, 0] * np.maximum(q[:, :, 0], 0.0)
    w, path = np.zeros((len(u), 2)), np.empty((count, len(u), 2))
    for s in np.tile(np.arange(count), laps):
        away = q[s, :, 1:] - w
        size = np.hypot(*away.T)
        share = np.divide(reach[s], size, out=np.ones_like(size), where=size > reach[s])
        w = path[s] = q[s, :, 1:] - share[:, None] * away
    return path


def test_step_is_the_limit_of_radial_return_in_small_steps():
    # A step is exact for a disc whose centre moves straight and whose radius changes linearly.
    rng = np.random.default_rng(5)
    out, rates, slipped = np.empty(2), np.empty((2, 8)), 0
    for _ in range(25):
        r0, r1 = rng.uniform(0.3, 1.5, 2)
        a, b, angle = rng.normal(size=2), 2 * rng.normal(size=2), rng.uniform(0, 2 * np.pi)
        start = a + rng.uniform(0, 1) ** 0.2 * r0 * np.array([np.cos(angle), np.sin(angle)])
        kind, work = pursue(start, a, b, r0, r1, out, rates)
        ends = []
        for steps in (2000, 4000):
            w = start.copy()
            for s in np.arange(1, steps + 1) / steps:
                centre, radius = a + s * (b - a), r0 + s * (r1 - r0)
                away = centre - w
                if (size := np.hypot(*away)) > radius:
                    w = centre - radius / size * away
            ends.append(w)
        np.testing.assert_allclose(out, 2 * ends[1] - ends[0], atol=3e-6)  # of first order
        slipped += kind != HELD
        assert work >= 0
    assert 12 < slipped < 25


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 4, 2.0])
def test_straight_path_is_the_closed_form_loop_whatever_its_direction(angle):
    kn, kt, mu, n0, U = 2e6, 3e6, 0.3, 50.0, 2e-5
    u, along = np.zeros((1, 3, 3)), np.array([np.cos(angle), np.sin(angle)])
    u[0, 0, 0], u[0, 1:, 1] = n0 / kn, U * along
    found = plane_law(alike_contacts(kn, kt, mu), 1)(u)
    stiffness, work = jenkins_element(U, kt, mu * n0)
    np.testing.assert_allclose(found.dissipation[0], work, rtol=1e-9)
    force = kt * to_complex(u - found.w)[1, 0, 1:]
    np.testing.assert_allclose(force @ along, stiffness * U, rtol=1e-9)
    np.testing.assert_allclose(force @ [-along[1], along[0]], 0, atol=1e-9 * mu * n0)


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


def test_law_does_not_know_the_axes_of_the_plane():
    contacts, u = drawn_contacts(3, 100, 3, plane=True)
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    turned = u.copy()
    turned[:, 1:] = np.einsum("ij,cjh->cih", turn, u[:, 1:])
    one, other = plane_law(contacts, 3)(u), plane_law(contacts, 3)(turned)
    np.testing.assert_array_equal(one.state, other.state)
    np.testing.assert_allclose(one.dissipation, other.dissipation, rtol=1e-9, atol=1e-12)
    expected = np.einsum("ij,cjh->cih", turn, one.w[:, 1:])
    np.testing.assert_allclose(other.w[:, 1:], expected, atol=1e-11)


@pytest.mark.parametrize("radius", [0.3, 0.7, 0.95])
def test_a_circle_is_followed_on_a_smaller_one(radius):
    # The slider moves towards the disc's centre, so that u - w is tangent to its own circle.
    u = np.diag([1.0, 1.0, -1.0])
    angles = np.linspace(-3.0, 9.0, 101)
    w = slider_places(u, radius, angles)
    p = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    # Between the nodes of a step the direction is less accurate than at its end, the distance not.
    np.testing.assert_allclose(np.hypot(*w.T), np.sqrt(1 - radius**2), rtol=5e-8)
    np.testing.assert_allclose(np.hypot(*(p - w).T), radius, rtol=1e-9)
    np.testing.assert_allclose(((p - w) * w).sum(axis=1), 0, atol=5e-8)


def test_places_are_those_of_radial_return_in_small_steps():
    contacts, u = drawn_contacts(3, 30, 8, plane=True)
    state = plane_law(contacts, 3)(u).state
    moves = np.isin(state, (SLIP, SLIP_OPEN))
    assert {SLIP, SLIP_OPEN} <= set(state)
    each = contacts.kn[moves], contacts.kt[moves], contacts.mu[moves], contacts.v0[moves]
    contacts, u, angles = Contacts(*each), u[moves], TURN * np.arange(1000) / 1000
    alpha = contacts.alpha[:, 0]
    places = np.array([slider_places(*one, angles) for one in zip(u, alpha, strict=True)])
    off = []
    for count in (3000, 12000):  # of first order
        path = radial_return(contacts, u, count, 6)
        apart = np.abs(path[:: count // 1000].swapaxes(0, 1) - places).max(axis=(1, 2))
        off.append(apart / np.abs(u).max(axis=(1, 2)))
    assert off[1].max() < 2e-3
    assert np.median(off[1]) < 0.3 * np.median(off[0])


def test_different_stiffness_in_the_two_directions_is_refused():
    contacts = Contacts(np.ones(2), np.array([[1.0, 1.0], [1.0, 2.0]]), np.ones(2), np.ones(2))
    with pytest.raises(InputError, match=r"friction: given 'isotropic': contact 1 has kt \(1, 2\)"):
        plane_law(contacts, 1)
    with pytest.raises(InputError, match="allowed: orthogonal, isotropic"):
        contact_law(contacts, 1, friction="round")
