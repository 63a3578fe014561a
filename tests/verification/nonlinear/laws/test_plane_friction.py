"""Isotropic friction and two independent directions: work of a cycle, error, peaks of the vane."""

import numpy as np
import pytest

from tests.conftest import FULL
from tests.nonlinear.contact.sampled_plane import sampled_plane
from tests.verification.nonlinear.spring_rings import loaded
from tests.verification.vane import highest, second_mode
from vanelock.nonlinear import SLIP, SLIP_OPEN, Options
from vanelock.nonlinear.contact.isotropic_law import slider_places
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.fourier import basis
from vanelock.rom import Contacts

RATIOS = (1.05, 1.2, 1.5, 2.0, 3.0, 5.0, 10.0, 100.0)  # of the amplitude to r = μ n/kt
KN, KT, MU, LOAD = 2e6, 3e6, 0.3, 50.0
LIMIT = MU * LOAD
R = LIMIT / KT


def cycle(first, second, friction):
    """Work of a cycle under constant load, one-sided coefficients of u1 and u2 given."""
    made = Contacts(np.array([KN]), np.array([[KT, KT]]), np.array([MU]), np.zeros(1))
    u = np.zeros((1, 3, 3))
    u[0, 0, 0] = LOAD / KN
    u[0, 1, 1:] = first.real, first.imag
    u[0, 2, 1:] = second.real, second.imag
    return contact_law(made, 1, friction=friction)(u).dissipation[0]


def orthogonal_work(*amplitudes):
    """Two Jenkins elements: 4 μ n (U - r) each, once it slips."""
    return sum(4 * LIMIT * max(abs(U) - R, 0.0) for U in amplitudes)


def radial_return(first, second, count):
    """Work of the third lap in small steps."""
    turn = np.exp(2j * np.pi * np.arange(count) / count)
    path = np.column_stack([(first * turn).real, (second * turn).real])
    w, work = np.zeros(2), 0.0
    for i in range(3 * count):
        if i == 2 * count:
            work = 0.0
        x, y = path[i % count] - w
        size = np.hypot(x, y)
        if size > R:
            step = size - R
            work += LIMIT * step
            w += step / size * np.array([x, y])
    return work


PATHS = {  # shares of u1 and u2 in the amplitude, the semi-major axis
    "straight along t1": (1.0, 0.0),
    "straight at 45 degrees": (np.sqrt(0.5), np.sqrt(0.5)),
    "circle": (1.0, -1j),
    "ellipse 2:1 along t1": (1.0, -0.5j),
    "ellipse 2:1 at 45 degrees": (np.sqrt(0.5) * (1 - 0.5j), np.sqrt(0.5) * (1 + 0.5j)),
}


@pytest.mark.parametrize("name", PATHS)
def test_work_of_a_cycle(name, record):
    shares = [complex(share) for share in PATHS[name]]
    quotients = []
    for ratio in RATIOS:
        first, second = (ratio * R * share for share in shares)
        both = cycle(first, second, "orthogonal")
        expected = orthogonal_work(first, second)
        np.testing.assert_allclose(both, expected, rtol=1e-12, atol=1e-12 * LIMIT * R)
        plane = cycle(first, second, "isotropic")
        if name == "circle":
            theory, rtol = 2 * np.pi * LIMIT * R * np.sqrt(ratio**2 - 1), 1e-7
        elif name.startswith("straight"):
            theory, rtol = 4 * LIMIT * R * (ratio - 1), 1e-7
        else:
            theory, rtol = radial_return(first, second, 20000 if FULL else 6000), 2e-3
        np.testing.assert_allclose(plane, theory, rtol=rtol)
        quotients.append(both / plane)
    shown = ", ".join(f"{q:.2f} at {x:g}" for x, q in zip(RATIOS, quotients, strict=True))
    record("work of two independent directions / isotropic, at U/r", shown)
    # Two directions see less of a two-dimensional path than its length while slip is small, and
    # have up to √2 times the friction force when it is large.
    if name == "circle":
        crossing = (16 + np.pi**2) / (16 - np.pi**2)
        np.testing.assert_array_equal(np.array(quotients) < 1, np.array(RATIOS) < crossing)
        assert quotients[0] < 0.21
        np.testing.assert_allclose(quotients[-1], 4 / np.pi, rtol=0.02)
    elif name == "straight at 45 degrees":
        crossing = 1 / (np.sqrt(2) - 1)
        np.testing.assert_array_equal(np.array(quotients) < 1, np.array(RATIOS) < crossing)
        assert quotients[1] == 0
        np.testing.assert_allclose(quotients[-1], np.sqrt(2), rtol=0.02)
    elif name == "straight along t1":
        np.testing.assert_allclose(quotients, 1, rtol=1e-4)
    else:
        assert min(quotients) < 0.9
        assert quotients[-1] > 1.1


@pytest.mark.parametrize("harmonics", [1, 3, 5])
def test_error_by_number_of_samples(harmonics, record):
    count, steps = (200, 100_000) if FULL else (30, 10_000)
    rng = np.random.default_rng([11, harmonics])
    kt = rng.uniform(0.5, 2, count)
    made = Contacts(
        kn=rng.uniform(0.5, 2, count),
        kt=np.column_stack([kt, kt]),
        mu=rng.choice([0.1, 0.3, 1.0], count),
        v0=np.zeros(count),
    )
    falling = np.repeat(np.arange(harmonics + 1), 2)[1:].clip(1)
    u = rng.normal(size=(count, 3, 2 * harmonics + 1)) / falling
    u[:, 0, 0] += rng.uniform(-1, 4, count)
    state = contact_law(made, harmonics, friction="isotropic")(u).state
    chosen = np.isin(state, (SLIP, SLIP_OPEN))
    u, alpha, opens = u[chosen], (made.mu * made.kn / kt)[chosen], state[chosen] == SLIP_OPEN
    # Marching in small steps by radial return, begun near the periodic path and a lap later on it.
    table = basis(harmonics, 2 * np.pi * np.arange(steps) / steps)
    w = np.array([slider_places(a, b, np.zeros(1))[0] for a, b in zip(u, alpha, strict=True)])
    reference = np.zeros((len(u), 2, 2 * harmonics + 1))
    for i in range(2 * steps):
        phi = table[i % steps]
        now = u @ phi
        away = now[:, 1:] - w
        size, reach = np.hypot(*away.T), alpha * np.maximum(now[:, 0], 0.0)
        share = np.divide(reach, size, out=np.ones_like(size), where=size > reach)
        w = now[:, 1:] - share[:, None] * away
        if i >= steps:
            reference += w[:, :, None] * phi
    reference *= 2 / steps
    reference[:, :, 0] /= 2
    scale = np.abs(u).max(axis=(1, 2))
    record("contacts", f"{np.sum(~opens)} slipping, {np.sum(opens)} opening too")
    record("reference", f"{steps:,} samples")
    chosen_contacts = Contacts(made.kn[chosen], made.kt[chosen], made.mu[chosen], made.v0[chosen])
    medians = []
    for samples in (128, 256, 512, 1024, None):
        if samples is None:
            found = contact_law(chosen_contacts, harmonics, friction="isotropic")(u).w[:, 1:]
        else:
            found = sampled_plane(chosen_contacts, samples, u).w[:, 1:]
        error = np.abs(found - reference).max(axis=(1, 2)) / scale
        record(
            f"{samples} samples" if samples else "located events",
            f"median {np.median(error):.1e}, 95 % {np.quantile(error, 0.95):.1e}, "
            f"largest {error.max():.1e}",
        )
        medians.append(np.median(error))
    assert medians[1] < 2e-4
    assert medians[1] < 0.4 * medians[0]
    assert medians[3] < (1e-5 if FULL else 1e-4)
    assert medians[4] < (1e-5 if FULL else 1e-4)  # marching is of first order


@pytest.mark.parametrize("force", [1.0, 3.0, 10.0, 30.0, 90.0] if FULL else [3.0, 30.0])
def test_peak_of_the_vane(scene, force, record):
    # From micro-slip to gross slip: small slip is damped more by isotropic friction, large slip by
    # two directions.
    system, (free, stuck, _) = loaded(scene.system, force / 30), second_mode(scene.system)
    found = {
        friction: highest(system, (free - 4.0, stuck + 4.0), Options(1, friction=friction))
        for friction in ("orthogonal", "isotropic")
    }
    for friction, (frequency, amplitude) in found.items():
        record(friction, f"{1e6 * amplitude:.4g} um at {frequency:.2f} Hz")
    quotient = found["orthogonal"][1] / found["isotropic"][1]
    record("peak of two independent directions / isotropic", f"{quotient:.3f}")
    assert 0.6 < quotient < 1.5
    if force == 3.0:
        assert quotient > 1.02
    if force == 30.0:
        assert quotient < 0.98
