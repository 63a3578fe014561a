"""Isotropic friction against theory, radial return in small steps and finite differences."""

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear.contact.disc_slider import HELD, pursue
from vanelock.nonlinear.contact.law import OPEN, SLIP, SLIP_OPEN, STUCK, Law, contact_law
from vanelock.nonlinear.fourier import to_complex
from vanelock.rom.system.system import Contacts

Floats = NDArray[np.float64]


def plane_law(made: Contacts, harmonics: int, constant_load: bool = False) -> Law:
    return contact_law(made, harmonics, None, "isotropic", constant_load)


def draw(harmonics: int, count: int, seed: int) -> tuple[Contacts, Floats]:
    """Contacts of every kind, closed, opening and open, μ from none to large."""
    rng = np.random.default_rng(seed)
    kt = rng.uniform(0.5, 2, count)
    made = Contacts(
        kn=rng.uniform(0.5, 2, count),
        kt=np.column_stack([kt, kt]),
        mu=rng.choice([0.0, 0.1, 0.3, 1.0, 3.0], count),
        v0=np.zeros(count),
    )
    falling = np.repeat(np.arange(harmonics + 1), 2)[1:].clip(1)
    u = rng.normal(size=(count, 3, 2 * harmonics + 1)) / falling
    u[:, 0, 0] += rng.uniform(-1, 3, count)
    return made, u


def radial_return(made: Contacts, u: Floats, count: int, laps: int) -> tuple[Floats, Floats]:
    """Slider (count, c, 2) in the last lap and friction work (c,), by catching up with the disc."""
    h = np.arange(to_complex(u).shape[0])
    wave = np.exp(2j * np.pi * np.outer(np.arange(count), h) / count)
    q = np.einsum("th,hcd->tcd", wave, to_complex(u)).real
    kt = made.kt[:, 0]
    reach = made.mu * made.kn * np.maximum(q[:, :, 0], 0.0) / kt
    w, path, work = np.zeros((len(kt), 2)), np.empty((count, len(kt), 2)), np.zeros(len(kt))
    for _ in range(laps):
        work[:] = 0.0
        for s in range(count):
            away = q[s, :, 1:] - w
            size = np.hypot(away[:, 0], away[:, 1])
            share = np.divide(reach[s], size, out=np.ones_like(size), where=size > reach[s])
            new = q[s, :, 1:] - share[:, None] * away
            work += kt * reach[s] * np.hypot(*(new - w).T)
            w = path[s] = new
    return path, work


def one_contact(
    kn: float, kt: float, mu: float, harmonics: int, n0: float
) -> tuple[Contacts, Floats]:
    made = Contacts(np.array([kn]), np.array([[kt, kt]]), np.array([mu]), np.zeros(1))
    u = np.zeros((1, 3, 2 * harmonics + 1))
    u[0, 0, 0] = n0 / kn
    return made, u


def test_step_is_the_limit_of_radial_return_in_small_steps() -> None:
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
                size = np.hypot(*away)
                if size > radius:
                    w = centre - radius / size * away
            ends.append(w)
        extrapolated = 2 * ends[1] - ends[0]  # catching up is of first order
        np.testing.assert_allclose(out, extrapolated, atol=3e-6)
        slipped += kind != HELD
        assert work >= 0
    assert 12 < slipped < 25


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 4, 2.0])
def test_straight_path_is_the_closed_form_loop_whatever_its_direction(angle: float) -> None:
    kn, kt, mu, n0, U = 2e6, 3e6, 0.3, 50.0, 2e-5
    made, u = one_contact(kn, kt, mu, 1, n0)
    u[0, 1, 1], u[0, 2, 1] = U * np.cos(angle), U * np.sin(angle)
    found = plane_law(made, 1)(u)
    limit = mu * n0
    area = 4 * limit * (U - limit / kt)
    np.testing.assert_allclose(found.dissipation[0], area, rtol=1e-9)
    force = kt * to_complex(u - found.w)[1, 0, 1:]
    along = force @ [np.cos(angle), np.sin(angle)]
    psi = np.arccos(1 - 2 * limit / (kt * U))
    in_phase = kt * U / np.pi * (psi - 0.5 * np.sin(2 * psi))
    np.testing.assert_allclose(along.real, in_phase, rtol=1e-9)
    np.testing.assert_allclose(along.imag, area / (np.pi * U), rtol=1e-9)
    np.testing.assert_allclose(force @ [-np.sin(angle), np.cos(angle)], 0, atol=1e-9 * limit)


@pytest.mark.parametrize("harmonics", [1, 5])
def test_located_law_is_continuous_where_events_pass_the_ends_of_steps(harmonics: int) -> None:
    # A shift in time turns the coefficients and moves all events alike.
    made, u = draw(harmonics, 40, seed=70 + harmonics)
    law, h = plane_law(made, harmonics), np.arange(harmonics + 1)
    moved = []
    for shift in np.linspace(0.0, 0.5, 41):
        turned = np.zeros_like(u)
        q = to_complex(u) * np.exp(1j * h * shift)[:, None, None]
        turned[..., 0], turned[..., 1::2] = q[0].real, np.moveaxis(q[1:].real, 0, -1)
        turned[..., 2::2] = np.moveaxis(q[1:].imag, 0, -1)
        w = to_complex(law(turned).w) * np.exp(-1j * h * shift)[:, None, None]
        moved.append(w)
    apart = np.abs(np.array(moved) - moved[0]).max(axis=(0, 1, 3)) / np.abs(u).max(axis=(1, 2))
    assert np.median(apart) < 1e-8
    assert apart.max() < 2e-5


def test_contact_that_slid_at_assembly_rests_at_the_nearest_common_point() -> None:
    # The discs' centres run on a line at a distance from zero; where they have common points the
    # slider rests at the one nearest to zero, found here by trying many.
    rng = np.random.default_rng(8)
    grid = np.stack(np.meshgrid(*2 * [np.linspace(-3, 3, 241)], indexing="ij"), -1).reshape(-1, 2)
    held = 0
    for _ in range(30):
        made, u = one_contact(1.0, 1.0, 1.0, 1, rng.uniform(0.5, 2.0))
        u[0, 1:, 0] = rng.uniform(-2, 2, 2)
        u[0, 1:, 1:] = 0.6 * rng.normal(size=(2, 2))
        u[0, 0, 1:] = 0.2 * rng.normal(size=2)
        found = plane_law(made, 1)(u)
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


@pytest.mark.parametrize("constant_load", [False, True])
@pytest.mark.parametrize("harmonics", [0, 1, 5])
def test_jacobian_is_the_derivative(harmonics: int, constant_load: bool) -> None:
    made, u = draw(harmonics, 200, seed=20 + harmonics)
    law = plane_law(made, harmonics, constant_load)
    if constant_load:  # the mean of v is held; near zero its sign would decide
        u[:, 0, 0] += np.sign(u[:, 0, 0]) * 0.01
    found = law(u)
    if harmonics and not constant_load:
        assert set(found.state) == {STUCK, SLIP, OPEN, SLIP_OPEN}
    assert np.any(found.w[found.state == STUCK]), "some stuck contacts slid at assembly"
    rng = np.random.default_rng(1)
    step = 1e-6
    for _ in range(2):
        direction = rng.normal(size=u.shape)
        measured = (law(u + step * direction).w - law(u - step * direction).w) / (2 * step)
        exact = np.einsum("cdkej,cej->cdk", found.jacobian, direction)
        error = np.abs(measured - exact).max(axis=(1, 2)) / np.abs(exact).max(initial=1.0)
        # A difference across an event that appears or vanishes within the step means nothing.
        # That of located events is not the derivative of their collocation, but as accurate.
        assert np.sort(error)[-6] < 2e-5
        assert np.median(error) < 1e-8


@pytest.mark.parametrize("ratio", [1e-2, 1e-7, 1e-12, 1e-16, 1e-30])
def test_contact_in_phase_with_its_load_slides_as_in_one_direction(ratio: float) -> None:
    # Nothing is damped: u and v turn back at the same instants, where λ vanishes. The law of one
    # direction is another one and exact; where μ n/kt vanishes beside the motion, w = u.
    u = np.zeros((1, 3, 3))
    u[0, :2] = [[0.9790803, 3.6106976, 6.7e-9], [-0.4395402, -4.5107143, -8.4e-9]]
    for v0 in (u[0, 0, 0], 9.0):
        u[0, 0, 0] = v0
        made = Contacts(np.ones(1), np.ones((1, 2)), np.array([ratio]), np.zeros(1))
        one, plane = contact_law(made, 1)(u), plane_law(made, 1)(u)
        np.testing.assert_array_equal(plane.state, one.state)
        np.testing.assert_allclose(plane.w, one.w, rtol=0, atol=1e-12)
        work = one.dissipation if ratio > 1e-14 else np.zeros(1)
        np.testing.assert_allclose(plane.dissipation, work, rtol=1e-4)


def test_law_does_not_know_the_axes_of_the_plane() -> None:
    made, u = draw(3, 100, seed=3)
    cosine, sine = np.cos(0.7), np.sin(0.7)
    turned = u.copy()
    turned[:, 1] = cosine * u[:, 1] - sine * u[:, 2]
    turned[:, 2] = sine * u[:, 1] + cosine * u[:, 2]
    law = plane_law(made, 3)
    one, other = law(u), law(turned)
    np.testing.assert_array_equal(one.state, other.state)
    np.testing.assert_allclose(one.dissipation, other.dissipation, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(cosine * one.w[:, 1] - sine * one.w[:, 2], other.w[:, 1], atol=1e-11)


def test_different_stiffness_in_the_two_directions_is_refused() -> None:
    made = Contacts(np.ones(2), np.array([[1.0, 1.0], [1.0, 2.0]]), np.ones(2), np.ones(2))
    with pytest.raises(InputError, match=r"friction: given 'isotropic': contact 1 has kt \(1, 2\)"):
        contact_law(made, 1, friction="isotropic")
    with pytest.raises(InputError, match="allowed: orthogonal, isotropic"):
        contact_law(made, 1, friction="round")
