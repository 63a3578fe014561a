"""Harmonic balance of one sector against the whole ring integrated in time.

The integration follows every sector's own contacts. It assumes neither that the motion is periodic
nor that the sectors repeat each other, so it tests the balance, the nodal diameters of its
harmonics, and whether the wave that it finds is stable.
"""

import time
from dataclasses import dataclass

import numpy as np
import pytest

from tests.conftest import FULL
from tests.nonlinear.systems import coefficients, solved_response
from tests.verification.nonlinear.spring_rings import (
    FollowedRing,
    loaded,
    spring_ring,
    worst_of,
    worst_ring,
)
from tests.verification.vane import highest
from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    Options,
    TimeResponse,
    frequency_response,
    time_response,
)

H_MAX = 15
PERIODS = 300 if FULL else 150
ORDERS = (1, 3, 5, 9)
GENTLE, HIGHEST = 0.25, 11  # share of the vane's force, and H, of its comparison


@dataclass(frozen=True)
class Comparison:
    """A balance with more and more harmonics against time integration from its last one."""

    ratio: float
    steady: TimeResponse
    by_coefficient: list[float]
    by_history: list[float]

    @property
    def left(self):
        """Whether the ring, which first follows the wave, leaves it in the end: it is unstable."""
        apart = self.steady.departure
        return apart[0] < 2e-3 and apart[-1] > 10 * apart[0]

    def is_of(self, kind):
        """Whether all contacts slip and none opens, or some open in every period."""
        state = self.steady.state
        return np.any(state == SLIP_OPEN) if kind == "lift" else np.all(state == SLIP)


def lags(system, found, harmonics):
    """(H + 1, N, 1, 1) turn of every harmonic of a wave from the first sector to each."""
    order = np.arange(harmonics + 1)[:, None] * system.engine_order / system.sectors
    return np.exp(-2j * np.pi * order * np.arange(found.contact.shape[1]))[:, :, None, None]


def errors(system, found, responses, of="contact"):
    """Differences of coefficients 0 ... H and of the history, relative to the first harmonic."""
    whole = getattr(found, of)
    lag, scale = lags(system, found, len(whole) - 1), np.abs(whole[1]).max()
    coefficients, history = [], []
    for response in responses:
        padded = np.zeros((len(whole), 1, *whole.shape[2:]), complex)
        padded[: response.harmonics + 1, 0] = getattr(response, of)[0]
        apart = np.abs(whole - lag * padded)
        coefficients.append(apart[: response.harmonics + 1].max() / scale)
        history.append(apart.sum(axis=0).max() / scale)  # what truncation leaves out included
    return coefficients, history


def compare(seed, kind):
    system, frequency = worst_ring(seed, kind)
    responses = [frequency_response(system, [frequency], Options(H)) for H in ORDERS]
    assert all(response.converged.all() for response in responses)
    steady = time_response(
        system, frequency, PERIODS, 512, H_MAX, start=(responses[-1], 0), tolerance=1e-7
    )
    assert steady.unsolved == 0
    return Comparison(worst_of(seed)[kind][0], steady, *errors(system, steady, responses))


SAMPLE = {"slip": (0, 3), "lift": (4, 8)}
UNSTABLE = 1  # a ring with lift-off that leaves the wave


@pytest.mark.parametrize("kind", ["slip", "lift"])
def test_sector_balance_is_the_steady_motion_of_the_ring(kind, record):
    found = []
    for seed in range(24) if FULL else SAMPLE[kind]:
        if kind in worst_of(seed) and (kind == "lift" or worst_of(seed)[kind][0] <= 0.5):
            found.append(compare(seed, kind))
    left = sum(one.left for one in found)
    record("rings", len(found))
    record("left, the wave being unstable", int(left))
    assert left <= 0.15 * len(found)
    found = [one for one in found if not one.left and one.is_of(kind)]
    record("steady and of this kind", len(found))
    assert len(found) >= (12 if FULL else 2)
    for one in found:
        assert one.steady.defect[-1] < 1e-5
        assert one.by_history == sorted(one.by_history, reverse=True)
    if kind == "slip":
        worst = max(one.ratio for one in found)
        record("peak / stuck peak", f"<= {worst:.2f}")
        assert worst <= 0.5
    for i, H in enumerate(ORDERS):
        coefficient = max(one.by_coefficient[i] for one in found)
        history = max(one.by_history[i] for one in found)
        record(f"error at H = {H}", f"{coefficient:.1e}, of the history {history:.1e}")
    assert max(one.by_coefficient[-1] for one in found) < 1e-3
    assert max(one.by_history[-1] for one in found) < 1e-3


def by_central_differences(ring, response, periods):
    """By period, how far the contacts of a spring ring leave a wave: another integrator."""
    wave, apart = ring.wave(response), []
    (z, _), expected = ring.start(wave), wave @ ring.B
    for _ in range(periods):
        history, z = ring.period(z)
        q = coefficients(history, len(wave) - 1) @ ring.B
        apart.append(np.abs(q - expected).max() / np.abs(expected[1:]).max())
    return np.array(apart)


@pytest.mark.parametrize(
    ("seed", "kind", "periods"), [(0, "lift", 15), (UNSTABLE, "lift", 60 if FULL else 45)]
)
def test_another_integrator_stays_with_the_wave_and_leaves_it_alike(seed, kind, periods, record):
    # Ring 0 settles on the wave. Ring 1 leaves it, whichever way it is integrated: an unstable
    # solution, in which the sectors cease to repeat each other.
    _, force, frequency = worst_of(seed)[kind]
    system = spring_ring(seed, force)
    response = frequency_response(system, [frequency], Options(9))
    found = time_response(system, frequency, periods, 512, 9, start=(response, 0)).departure
    ring = FollowedRing(seed, force, frequency, 8000 if FULL else 4000)
    other = by_central_differences(ring, response, periods)
    record("departure", f"{found[0]:.1e} to {found[-1]:.1e}")
    record("by central differences", f"{other[0]:.1e} to {other[-1]:.1e}")
    if seed == UNSTABLE:
        assert found[-1] > 10 * found[0]
        assert found[-1] == pytest.approx(other[-1], rel=0.2)
    else:
        assert found[-1] < 0.2 * found[0]
        np.testing.assert_allclose(found, other, rtol=0.1, atol=2e-5)


NEAR = (255.0, 280.0) if FULL else (268.0, 294.0)


INERTIA = 60  # modes of each nodal diameter that keep their inertia


@pytest.mark.parametrize("beside", (-1.5, 0.0, 1.5) if FULL else (0.0,))
def test_vane_stays_with_the_balance(ring_of_vanes, beside, record):
    system = loaded(ring_of_vanes, GENTLE)
    frequency = highest(system, NEAR)[0] + beside
    orders = (1, 3, 5, 9, HIGHEST)
    responses = [frequency_response(system, [frequency], Options(H)) for H in orders]
    assert all(response.converged.all() for response in responses)
    interlock = np.array(system.contacts.joint) == "interlock"
    assert np.all(np.isin(responses[-1].state[0, interlock], (SLIP, SLIP_OPEN)))
    periods = 50 if FULL else 8
    found = time_response(
        system, frequency, periods, 256, HIGHEST, start=(responses[-1], 0), modes=INERTIA
    )
    assert found.unsolved == 0
    matrix = system.at(1).K.astype(complex)
    began = time.perf_counter()
    for _ in range(5):
        np.linalg.solve(matrix, system.force[1].vector)
    unit = (time.perf_counter() - began) / 5
    record("frequency", f"{frequency:.2f} Hz")
    record(f"departure at H = {HIGHEST} in {periods} periods", f"{max(found.departure):.1e}")
    of_contacts, of_outputs = (
        errors(system, found, responses, of)[0] for of in ("contact", "output")
    )
    for H, contact, output in zip(orders, of_contacts, of_outputs, strict=True):
        record(f"H = {H}", f"contacts {contact:.1e}, outputs {output:.1e}")
    cost = found.seconds / periods
    record("a period", f"{cost:.2f} s, {cost / unit:.0f} dense complex solves")
    assert np.all(found.departure < 1e-3)
    assert of_contacts[0] > of_contacts[1] > of_contacts[2] > of_contacts[3]


def test_vane_at_full_force_leaves_the_balance_at_any_step(ring_of_vanes, record):
    vane = ring_of_vanes
    frequency, _ = highest(vane, NEAR)
    response = solved_response(vane, [frequency], Options(9))
    rates = []
    for steps in (256, 512) if FULL else (128, 192):
        found = time_response(
            vane, frequency, 11, steps, 9, start=(response, 0), modes=INERTIA
        ).departure
        rates.append((found[10] / found[6]) ** 0.25)
        record(f"{steps} steps", f"{found[0]:.1e} to {found[-1]:.1e}")
    record("growth a period", ", ".join(f"{rate:.2f}" for rate in rates))
    assert min(rates) > 1.2
    assert rates[0] == pytest.approx(rates[1], rel=0.1)
