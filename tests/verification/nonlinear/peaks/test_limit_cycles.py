"""Limit cycles of flutter: closed form of one mass, marching in time, and the modes of a ring."""

import numba
import numpy as np
import pytest
import scipy.linalg as la

from tests.conftest import FULL
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Options,
    System,
    aerodynamic_damping,
    limit_cycles,
)
from vanelock.nonlinear.modes.limit_cycles import _coefficients

STIFFNESS, SPRING, SLIP = 1.0, 0.25, 0.2
INPUTS = (0.1, 0.36, 0.9) if FULL else (0.36,)
"""Work of the air in a cycle over kt U²."""


def one_mass():
    """A mass on a spring and a Jenkins element whose normal load nothing moves."""
    rows = np.zeros((1, 3, 2))
    rows[0, 0, 1] = rows[0, 1, 0] = 1.0
    matrices = Diameter(
        K=np.diag([STIFFNESS, 1.0]), M=np.eye(2), own=rows, output=np.eye(2)[None, [0, 1, 1]]
    )
    contacts = Contacts(np.ones(1), np.full((1, 2), SPRING), np.full(1, 0.5), np.full(1, 4 * SLIP))
    return System(1, 1, {0: matrices}, contacts, {}, ("mass",))


def found(given, harmonics, reach=12.0):
    """Cycles under the work a U² in a cycle, a = `given` kt; amplitudes over slip/kt."""
    influence = {0: 1j * given * SPRING / np.pi}
    size = SLIP / SPRING
    return limit_cycles(one_mass(), 1, influence, (0.3 * size, reach * size), Options(harmonics))


@pytest.mark.parametrize("given", INPUTS)
def test_one_mass_has_the_cycles_of_its_power_balance(given, record):
    """4F (U - F/kt) = a U², of one harmonic: the lower root is stable, the upper one the kick."""
    root = np.sqrt(1 - given)
    expected = 2 / given * np.array([1 - root, 1 + root])
    cycles = found(given, 1, 2 * expected[1])
    sizes = cycles.amplitude * SPRING / SLIP
    np.testing.assert_allclose(sizes, expected, rtol=1e-6)
    assert cycles.amplitude_stable.tolist() == [True, False]
    assert cycles.critical_kick == cycles.amplitude[1]
    assert cycles.linear_damping < 0
    record("cycles", ", ".join(f"{each:.6f}" for each in sizes))
    record("difference", f"{np.abs(sizes / expected - 1).max():.1e}")


def test_nothing_holds_what_the_air_drives_more_than_friction_can_take(record):
    cycles = found(1.01, 1, 200.0)
    assert len(cycles.amplitude) == 0
    assert cycles.critical_kick == 0.0
    record("cycles at a = 1.01 kt", "none")


@numba.njit
def marched(size, input_, count, step, stiffness, spring, slip):
    """Half the peak-to-peak at the end, from a displacement at rest, by Verlet's rule."""
    x, v, w, low, high = size, 0.0, 0.0, np.inf, -np.inf
    for i in range(count):
        a = -stiffness * x - spring * (x - w) + input_ * v
        half = v + 0.5 * step * a
        x += step * half
        w = min(max(w, x - slip / spring), x + slip / spring)
        a = -stiffness * x - spring * (x - w) + input_ * half
        v = half + 0.5 * step * a
        if i > count - 20.0 / step:
            low, high = min(low, x), max(high, x)
    return (high - low) / 2


def test_marching_settles_at_the_stable_cycle_and_leaves_the_other(record):
    """Viscous input of the same work: f = c v, c = a/(π ω), at the frequency of each cycle."""
    cycles = found(0.36, 5)
    omega = 2 * np.pi * cycles.frequency
    sizes = cycles.output[:, 0, 0]
    inputs = 0.36 * SPRING / np.pi / omega
    settled = marched(sizes[0], inputs[0], 4_000_000, 1e-3, STIFFNESS, SPRING, SLIP)
    assert settled == pytest.approx(sizes[0], rel=1e-4)
    record("stable", f"{sizes[0] * SPRING / SLIP:.6f}")
    record("marched", f"{settled * SPRING / SLIP:.6f}")
    ends = [
        marched(share * sizes[1], inputs[1], 2_000_000, 1e-3, STIFFNESS, SPRING, SLIP)
        for share in (0.99, 1.02)
    ]
    assert ends[0] < 0.2 * sizes[1]  # falls back
    assert ends[1] > 2.0 * sizes[1]  # runs away
    record("kick", f"{sizes[1] * SPRING / SLIP:.4f}")
    record("marched from 0.99 and 1.02 of it", "falls back, runs away")


def test_air_damps_the_waves_of_a_ring_as_its_eigenvalues_say(record):
    """All N blades coupled by the air alone, in the time domain."""
    rng, sectors, hertz = np.random.default_rng(3), 11, 260.0
    omega2 = (2 * np.pi * hertz) ** 2
    influence = {
        m: 1e-4 * omega2 * (rng.normal() + 1j * rng.normal()) * 0.3 ** abs(m) for m in range(-2, 3)
    }
    row = np.zeros(sectors, complex)
    for m, value in influence.items():
        row[m % sectors] = value
    ring = la.circulant(row).T  # sector j is pushed by sector j + m
    values = np.sqrt(la.eigvals(omega2 * np.eye(sectors) - ring))
    expected = np.sort(values.imag / values.real)
    damping = np.sort(aerodynamic_damping(influence, sectors, hertz))
    np.testing.assert_allclose(damping, expected, rtol=1e-3, atol=1e-8)
    waves = np.exp(-2j * np.pi * np.outer(np.arange(sectors), np.arange(sectors)) / sectors)
    A = _coefficients(influence, sectors)
    np.testing.assert_allclose(ring @ waves, waves * A, rtol=1e-10, atol=1e-9)
    record("damping by nodal diameter", f"{damping.min():+.1e} to {damping.max():+.1e}")
    record("difference", f"{np.abs(damping - expected).max():.1e}")
