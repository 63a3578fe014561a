"""The contact law against theory, an independent marching and finite differences."""

import numpy as np
import pytest

from tests.nonlinear.systems import (
    alike_contacts,
    coefficients,
    drawn_contacts,
    jenkins_element,
    march,
)
from tests.refusals import refused
from vanelock.nonlinear import Contacts
from vanelock.nonlinear.contact.law import OPEN, SLIP, SLIP_OPEN, STUCK, contact_law
from vanelock.nonlinear.fourier import to_complex


def forces(contacts, u, w):
    """(H + 1, c, 3) coefficients of the contact forces."""
    return to_complex(contacts.stiffness[:, :, None] * (u - w))


def test_jenkins_loop_has_its_closed_form():
    kn, kt, mu, n0, U = 2e6, 3e6, 0.3, 50.0, 2e-5
    contacts, limit = alike_contacts(kn, kt, mu), mu * n0
    u = np.zeros((1, 3, 3))
    u[0, 0, 0] = n0 / kn
    u[0, 1, 1] = U
    u[0, 2, 2] = 0.4 * limit / kt  # the other direction sticks
    found = contact_law(contacts, 1)(u)
    assert found.state[0] == SLIP
    stiffness, work = jenkins_element(U, kt, limit)
    np.testing.assert_allclose(found.dissipation[0], work, rtol=1e-13)
    force = forces(contacts, u, found.w)[:, 0, 1]
    np.testing.assert_allclose(force[1], stiffness * U, rtol=1e-13)
    np.testing.assert_allclose(force[0], 0, atol=1e-13 * limit)
    np.testing.assert_array_equal(found.w[0, 2], 0)


def test_normal_force_of_an_opening_contact_has_its_closed_form():
    # n = kn max(a + b cos θ, 0) is kn (a + b cos θ) on |θ| < θ₁ = arccos(-a/b).
    kn, a, b = 2e6, -1e-6, 4e-6
    contacts, u = alike_contacts(kn, 1e6, 0.0), np.zeros((1, 3, 5))
    u[0, 0, :2] = a, b
    n = forces(contacts, u, contact_law(contacts, 2)(u).w)[:, 0, 0]
    edge = np.arccos(-a / b)
    mean = kn / np.pi * (a * edge + b * np.sin(edge))
    first = 2 * kn / np.pi * (a * np.sin(edge) + b * (edge / 2 + np.sin(2 * edge) / 4))
    second = a * np.sin(2 * edge) + b * (np.sin(edge) + np.sin(3 * edge) / 3)
    np.testing.assert_allclose(n, [mean, first, kn / np.pi * second], atol=1e-14)


def test_contact_that_slid_once_carries_the_force_of_the_nearest_slider_position():
    # u between 3 and 5 with a limit of 1.5: the slider must end in [5 - 1.5, 3 + 1.5] and started
    # at 0, so it rests at 3.5, whatever the origin of time.
    u = np.zeros((3, 3, 3))
    u[:, 0, 0] = 3.0
    u[:, 1, 0] = 4.0, -4.0, 1.2
    for phase in (0.0, 1.0, 4.0):
        u[:, 1, 1], u[:, 1, 2] = np.cos(phase), np.sin(phase)
        found = contact_law(alike_contacts(mu=0.5, count=3), 1)(u)
        np.testing.assert_array_equal(found.state, STUCK)
        np.testing.assert_allclose(found.w[:, 1, 0], [3.5, -3.5, 0.7], atol=1e-15)
        np.testing.assert_array_equal(found.w[:, 1, 1:], 0)
        np.testing.assert_array_equal(found.dissipation, 0)


@pytest.mark.parametrize("harmonics", [0, 1, 2, 5])
def test_coefficients_agree_with_marching(harmonics):
    contacts, u = drawn_contacts(harmonics, 200, seed=harmonics)
    found = contact_law(contacts, harmonics)(u)
    exact, errors = forces(contacts, u, found.w), []
    for count in (2000, 8000):
        marched = coefficients(march(contacts, to_complex(u), count), harmonics)
        errors.append(np.abs(marched - exact).max(axis=(0, 2)))
    # Marching is of first order where contacts touch down and of second order elsewhere.
    touching = found.state == SLIP_OPEN
    assert np.max(errors[1], where=~touching, initial=0) < 1e-4
    assert np.max(errors[1]) < 1e-2
    if harmonics:
        assert errors[1][touching].mean() < 0.4 * errors[0][touching].mean()
        assert errors[1][~touching].mean() < 0.1 * errors[0][~touching].mean()


def drawn_on_a_grid(harmonics, count, part, lifts):
    """Whole amplitudes at phases of multiples of π/part: events and tangencies on any grid.

    Without lift-off half of the v are constant, and of the others every third touches zero.
    """
    rng = np.random.default_rng([harmonics, part])
    contacts = alike_contacts(mu=rng.choice([0.5, 1.0, 2.0], count), count=count)
    u = np.zeros((count, 3, 2 * harmonics + 1))
    u[:, :, 0] = rng.integers(-2, 3, (count, 3))
    size = rng.integers(-2, 3, (count, 3, harmonics))
    phase = np.pi / part * rng.integers(0, 2 * part, (count, 3, harmonics))
    u[:, :, 1::2], u[:, :, 2::2] = size * np.cos(phase), size * np.sin(phase)
    if not lifts:
        u[:, 0, 0] = np.abs(size[:, 0]).sum(axis=1) + rng.integers(0, 3, count)
        u[::2, 0, 1:] = 0.0
        u[:, 0, 0] += u[:, 0, 0] == 0
    return contacts, u


@pytest.mark.parametrize(("harmonics", "part", "lifts"), [
    (1, 8, True), (2, 12, False), (3, 12, True), (4, 8, True), (5, 12, False)
])  # fmt: skip
def test_events_on_the_grid_that_brackets_them_are_found(harmonics, part, lifts):
    contacts, u = drawn_on_a_grid(harmonics, 500, part, lifts)
    found = contact_law(contacts, harmonics)(u)
    assert np.any(found.state == (SLIP_OPEN if lifts else SLIP))
    assert np.all(found.dissipation >= -1e-12)
    marched = coefficients(march(contacts, to_complex(u), 3000), harmonics)
    error = np.abs(marched - forces(contacts, u, found.w)).max(axis=(0, 2))
    error /= np.abs(u).max(axis=(1, 2), initial=1.0)
    assert error.max() < 1e-2  # the marching's own error, of first order at touch-downs


def test_slip_is_seen_where_the_bound_has_a_level_instant_midway():
    # u rises from -2π/3 to 2π/3 with slope 0 at 0, exactly midway; between bounds at u ± 2 the
    # slider goes from u_min + 2 to u_max - 2 and back.
    u = np.zeros((1, 3, 5))
    u[0, 0, 0] = 1.0
    u[0, 1] = -2.0, 0.0, -2.0, 0.0, 1.0  # -2 + 2 sin θ - sin 2θ
    found = contact_law(alike_contacts(mu=2.0), 2)(u)
    angle = 2 * np.pi * (np.arange(100000) + 0.5) / 100000 - np.pi
    history = -2 + 2 * np.sin(angle) - np.sin(2 * angle)
    top, bottom = -4 + 1.5 * np.sqrt(3), -1.5 * np.sqrt(3)
    rises = np.abs(angle) < 2 * np.pi / 3
    w = np.where(rises, np.maximum(history - 2, bottom), np.minimum(history + 2, top))
    expected = (w * np.exp(-1j * np.arange(3)[:, None] * angle)).mean(axis=1) * [1, 2, 2]
    np.testing.assert_allclose(to_complex(found.w[0, 1]), expected, atol=1e-8)
    assert found.state[0] == SLIP
    np.testing.assert_allclose(found.dissipation, 2 * 2.0 * (top - bottom), rtol=1e-12)


def test_contact_that_only_touches_zero_is_closed():
    # v = 1 - cos(hθ + φ) is never negative, whatever rounding says of the instants v = 0.
    phase = np.pi / 12 * np.arange(24)
    for harmonics, h in ((1, 1), (3, 1), (3, 2), (5, 4)):
        u = np.zeros((24, 3, 2 * harmonics + 1))
        u[:, 0, 0] = 1.0
        u[:, 0, 2 * h - 1], u[:, 0, 2 * h] = -np.cos(phase), np.sin(phase)
        found = contact_law(alike_contacts(count=24), harmonics)(u)
        np.testing.assert_allclose(found.w[:, 0], 0.0, atol=1e-14)
        np.testing.assert_allclose(found.dissipation, 0.0, atol=1e-14)


@pytest.mark.parametrize(
    ("law", "harmonics"),
    [(law, h) for law in ("located", "sampled") for h in (0, 1, 3, 5)]
    + [(law, h) for law in ("plane", "plane, constant load") for h in (0, 1, 5)],
)
def test_jacobian_is_the_derivative(law, harmonics):
    plane, constant = law.startswith("plane"), "constant" in law
    contacts, u = drawn_contacts(harmonics, 200, 20 + harmonics, plane)
    if constant:  # the mean of v is held; near zero its sign would decide
        u[:, 0, 0] += np.sign(u[:, 0, 0]) * 0.01
    samples, friction = 64 if law == "sampled" else None, "isotropic" if plane else "orthogonal"
    deviation = contact_law(contacts, harmonics, samples, friction, constant)
    found = deviation(u)
    if harmonics and not constant:
        assert set(found.state) == {STUCK, SLIP, OPEN, SLIP_OPEN}
    assert np.any(found.w[found.state == STUCK]), "some stuck contacts slid at assembly"
    rng, step = np.random.default_rng(1), 1e-6
    for _ in range(3):
        direction = rng.normal(size=u.shape)
        ends = deviation(u + step * direction).w, deviation(u - step * direction).w
        measured = (ends[0] - ends[1]) / (2 * step)
        exact = np.einsum("cdkej,cej->cdk", found.jacobian, direction)
        error = np.abs(measured - exact).max(axis=(1, 2)) / np.abs(exact).max(initial=1.0)
        # A difference across an event that appears or vanishes within the step means nothing.
        # In the plane located events' is not the derivative of their collocation, but as accurate.
        assert np.sort(error)[-6 if plane else -3] < (2e-5 if plane else 1e-7)
        assert np.median(error) < (1e-8 if plane else 1e-9)


def plane_law(contacts, harmonics):
    return contact_law(contacts, harmonics, friction="isotropic")


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
    refused(r"friction: given 'isotropic': contact 1 has kt \(1, 2\)", plane_law, contacts, 1)
    refused("allowed: orthogonal, isotropic", contact_law, contacts, 1, friction="round")
