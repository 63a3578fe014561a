"""Wear over cycles against closed forms, and against SciPy's integration of the same rates."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tests.conftest import FULL
from tests.nonlinear.systems import even, jenkins_element, solved_response, with_contacts
from tests.verification.nonlinear.spring_rings import worst_ring
from vanelock.nonlinear import (
    Contact,
    Dwell,
    Options,
    System,
    peak_response,
    wear_history,
)
from vanelock.nonlinear.peaks.peak import CurvePoint, Resonance

RINGS, GROUPS = (20, 10) if FULL else (2, 2)
SHARP = 17
"""The ring whose peak ceases to be sharp on the way, where the reference here loses it."""
STEPS = (0.2, 0.1, 0.05, 0.025, 0.0125)[: 5 if FULL else 4]
SHARE = 0.4 if FULL else 0.15
"""Of the first interference, what would be worn at the first rate."""
ARCHARD = 1e-3
"""k / A, 1/N, of masses and springs of order 1."""


def sliding(kt, mu, load):
    """A mass on a spring and a Jenkins element, pressed by a force on a free normal coordinate."""
    contact = Contact(tangential=0, normal=1, mu=mu, kt=kt, kn=2.0, preload=1.0)
    return System.from_matrices(
        np.eye(2), np.diag([1.0, 0.0]), [contact], force={0: 1.0}, static_force={1: load}
    )


@pytest.mark.parametrize("at_peak", [False, True])
@pytest.mark.parametrize(("kt", "limit"), [(0.6, 0.9), (2.0, 1.1), (5.0, 1.5)])
def test_a_jenkins_oscillator_at_constant_load_wears_linearly(kt, limit, at_peak, record, below):
    mu, load = 0.5, limit / 0.5
    system = sliding(kt, mu, load)
    U = limit / kt / (1 - np.pi / (4 * limit))  # at the peak 1 = 4 μn/π (1 - μn/(kt U))
    if at_peak:
        low, high = np.sqrt([0.7, 1 + 1.05 * kt]) / (2 * np.pi)
        dwell = Dwell(3e4, near=(low, high))
    else:
        omega = np.sqrt(1.03 * (1 + jenkins_element(U, kt, limit)[0].real))

        def balance(U):
            return abs(1 - omega**2 + jenkins_element(U, kt, limit)[0]) * U - 1

        U = brentq(balance, 1.0001 * limit / kt, 1e3, xtol=1e-14, rtol=1e-14)
        dwell = Dwell(3e4, frequency=omega / (2 * np.pi))
    found = wear_history(system, dwell, ARCHARD, 1.0, Options(1), ("x0", 0))
    assert found.status == "cycles done"
    assert found.cycles[-1] == 3e4
    np.testing.assert_allclose(found.amplitude, U, rtol=1e-8)
    np.testing.assert_allclose(found.rest_load, load, rtol=1e-10)
    worn = found.interference[0, 0] - found.interference[:, 0]
    expected = ARCHARD * 4 * load * (U - limit / kt) * found.cycles
    error = np.abs(worn[1:] / expected[1:] - 1).max()
    record("depth over preload's", f"{worn[-1] / (load / 2.0):.0f}")
    below("error", error, 1e-8)


def pressed(U, mu):
    """A contact dragged by U, back and forth, whatever it resists, pressed by a spring."""
    stiff = 1e10
    contact = Contact(tangential=0, normal=1, mu=mu, kt=1.0, kn=2.0, preload=2.0)
    return System.from_matrices(np.eye(2), np.diag([stiff, 1.0]), [contact], force={0: stiff * U})


@pytest.mark.parametrize("U", [2.0, 1e5])
def test_a_spring_loaded_contact_wears_ever_slower(U, record):
    """With n = s v0, s = kn ks / (kn + ks): dv0/dN = -(k/A) 4 n (U - μ n / kt).

    That is logistic, and e^{-bN} for large U.
    """
    mu, s, v0 = 0.5, 2.0 / 3.0, 1.0
    system, b = pressed(U, mu), 4 * ARCHARD * s * U
    dwell = Dwell(2.0 / b, frequency=1e-3)
    share = mu * s * v0 / U
    end = v0 / (share + (1 - share) * np.exp(2.0))
    if U > 1e4:
        assert end == pytest.approx(v0 * np.exp(-2.0), rel=1e-5)
    errors, solved = [], []
    for step in STEPS:
        found = wear_history(system, dwell, ARCHARD, 1.0, Options(1), step=step)
        assert found.status == "cycles done"
        errors.append(abs(found.interference[-1, 0] / end - 1))
        solved.append(found.solved)
    orders = np.log2([a / b for a, b in pairwise(errors)])
    record(
        "error by step", ", ".join(f"{s:g}: {e:.1e}" for s, e in zip(STEPS, errors, strict=True))
    )
    record("order", ", ".join(f"{each:.2f}" for each in orders))
    record("vibrations", ", ".join(map(str, solved)))
    assert np.all(np.abs(orders - 2) < 0.25)
    assert errors[STEPS.index(0.05)] < 1.5e-3


def drawn(seed):
    """A random ring under the load that friction damps most, its frequency, options and k / A."""
    random = np.random.default_rng(2000 + seed)
    system, hertz = worst_ring(seed, ("slip", "lift")[seed % 2])
    friction = str(random.choice(["orthogonal", "isotropic"]))
    system = even(system) if friction == "isotropic" else system
    depth = ARCHARD * random.uniform(0.2, 1, system.contacts.count)
    return system, float(hertz), Options(int(random.choice([1, 3])), friction=friction), depth


def worn(system, v0):
    return with_contacts(system, v0=np.array(v0))


def compared(system, dwell, options, depth, rate, output=None):
    """Errors of a wear history at two steps against SciPy's integration of rates.

    Relative to the largest depth; with the history at the first step, and the share of the cycles
    that is compared.
    """
    begin = wear_history(system, replace(dwell, cycles=1e-9), depth, 1.0, options, output)
    cycles = SHARE * system.contacts.v0[0] / begin.rate.max()
    whole = wear_history(system, replace(dwell, cycles=cycles), depth, 1.0, options, output)
    asked = cycles
    if whole.jump.any():  # where a peak is lost rates jump: until shortly before
        cycles = 0.8 * whole.cycles[whole.jump.argmax() - 1]
    dwell = replace(dwell, cycles=cycles)
    found = [wear_history(system, dwell, depth, 1.0, options, output, s) for s in (0.05, 0.0125)]
    assert all(each.status == "cycles done" for each in found)
    v0 = system.contacts.v0
    known = solve_ivp(lambda _, v0: -rate(v0), (0, cycles), v0, rtol=1e-7, atol=1e-8)
    assert known.success
    change = np.abs(known.y[:, -1] - v0).max()
    errors = [np.abs(h.interference[-1] - known.y[:, -1]).max() / change for h in found]
    return errors, found[0], cycles / asked


class PeakRate:
    """Rate of wear at the peak nearest to the last one, of a system prepared anew each time."""

    def __init__(self, system, options, depth, component):
        self.system, self.options, self.component = system, options, component
        self.depth = depth / system.contacts.mu

    def begin(self, first):
        """Set out from a peak that a sweep found."""
        self.v0, omega = self.system.contacts.v0, 2 * np.pi * float(first.frequency[0])
        solution = self.options.prepare(self.system, 1.0, 1).solver.point(omega, [])
        bend = -((2 * np.pi * float(first.width[0])) ** -2.0)
        self.peak = CurvePoint(solution, 0.0, bend, 0.0, 0, False)
        self(self.v0)
        assert self.peak.amplitude == pytest.approx(first.amplitude[0], rel=1e-9)

    def __call__(self, v0):
        """The rate at an interference, by way of short steps."""
        way = np.linspace(0, 1, 1 + int(np.ceil(np.abs(v0 - self.v0).max() / 0.02)))[1:, None]
        for place in self.v0 + way * (v0 - self.v0) if len(way) else [v0]:
            ready = self.options.prepare(worn(self.system, place), 1.0, 1)
            find = Resonance(ready.solver.family, self.component, 1e-10).peak
            found = find(self.peak.solution.omega, self.peak.solution.w, self.peak.bend)
            assert found is not None
            self.peak, self.v0 = found, place
        return self.depth * self.peak.solution.deviation.dissipation


def record_errors(errors, shares, record):
    """Record and judge the errors at both steps of some rings."""
    worst, order = np.max(errors, axis=0), np.log(np.divide(*np.transpose(errors))) / np.log(4)
    record("rings", f"{len(errors)}")
    record("share of cycles", ", ".join(f"{each:.2f}" for each in shares))
    record("error at 5 %", f"{worst[0]:.1e}")
    record("error at 1.25 %", f"{worst[1]:.1e}")
    record("order", ", ".join(f"{each:.2f}" for each in order))
    assert worst[0] < 1e-2
    assert worst[1] < 1e-3


@pytest.mark.parametrize("group", range(GROUPS))
def test_rings_at_a_frequency_wear_as_integrated(group, record):
    errors, shares = [], []
    for seed in range(group, RINGS, GROUPS):
        system, hertz, options, depth = drawn(seed)

        def rate(v0, system=system, hertz=hertz, options=options, depth=depth):
            found = solved_response(worn(system, v0), [hertz], options)
            return depth * found.dissipation[0] / system.contacts.mu

        dwell = Dwell(1.0, frequency=hertz)
        each, _, share = compared(system, dwell, options, depth, rate)
        errors.append(each)
        shares.append(share)
    record_errors(errors, shares, record)


@pytest.mark.parametrize("group", range(GROUPS))
def test_rings_at_the_peak_wear_as_integrated(group, record, below):
    errors, shares, apart = [], [], 0.0
    for seed in range(group, RINGS, GROUPS):
        if seed == SHARP:
            continue  # by itself below
        system, hertz, options, depth = drawn(seed)
        near = (0.8 * hertz, 1.15 * hertz)
        first = peak_response(system, "force", [1.0], near, options)
        output = first.output, first.direction
        component = system.output_names.index(first.output), first.direction
        rate = PeakRate(system, options, depth, component)
        rate.begin(first)
        dwell = Dwell(1.0, near=near)
        each, found, share = compared(system, dwell, options, depth, rate, output)
        errors.append(each)
        shares.append(share)
        rate(found.interference[-1])  # both must have followed the same peak
        apart = max(apart, abs(rate.peak.amplitude / found.amplitude[-1] - 1))
    record_errors(errors, shares, record)
    below("last peak", apart, 1e-8)


def test_a_sharp_peak_that_turns_smooth_is_the_one_that_a_sweep_finds(record, below):
    """Rates of every state, each at a peak swept afresh, in place of an integration of them."""
    system, hertz, options, depth = drawn(SHARP)
    near = (0.8 * hertz, 1.15 * hertz) if FULL else (0.93 * hertz, 1.07 * hertz)
    first = peak_response(system, "force", [1.0], near, options)
    output, begin = (first.output, first.direction), depth * first.response.dissipation[0]
    cycles = 0.4 * system.contacts.v0[0] / (begin / system.contacts.mu).max()
    dwell = Dwell(float(cycles), near=near)
    steps = (0.05, 0.0125) if FULL else (0.1, 0.05)
    found = [wear_history(system, dwell, depth, 1.0, options, output, step) for step in steps]
    coarse, fine = (each.interference[-1] for each in found)
    amplitude, rate, sharp = 0.0, 0.0, []
    last = len(found[0].cycles) - 1
    for i in range(last + 1) if FULL else (0, last):
        v0, swept = found[0].interference[i], first
        if i > 0:
            swept = peak_response(worn(system, v0), "force", [1.0], near, options, output)
        amplitude = max(amplitude, abs(found[0].amplitude[i] / swept.amplitude[0] - 1))
        expected = depth * swept.response.dissipation[0] / system.contacts.mu
        rate = max(rate, np.abs(found[0].rate[i] / expected - 1).max())
        sharp.append(bool(swept.sharp[0]))
    gap = np.abs(coarse - fine).max() / np.abs(system.contacts.v0 - fine).max()
    record("sharp, of all", f"{sum(sharp)} of {len(sharp)}")
    below("amplitude", amplitude, 1e-8)
    below("rate", rate, 1e-8)
    below(f"{steps[0]:.0%} against {steps[1]:.2%}", gap, 1e-2)
    assert sharp[0]
    assert not sharp[-1]


@pytest.mark.parametrize("at_peak", [False, True])
def test_several_dwells_are_one_of_the_sum(at_peak, below):
    system, hertz, options, depth = drawn(0)
    near = (0.8 * hertz, 1.15 * hertz)
    where = {"near": near} if at_peak else {"frequency": hertz}
    whole = wear_history(system, Dwell(300.0, **where), depth, 1.0, options)
    assert whole.status == "cycles done"
    assert whole.cycles[-1] == 300.0
    # Cut where it made steps, nothing else happens; elsewhere, other steps of the same rule.
    kept = whole.cycles[[2, 4]]
    for parts, apart in ((np.diff([0, *kept, 300.0]), 1e-9), ((101.0, 57.0, 142.0), 5e-3)):
        cut = wear_history(system, [Dwell(p, **where) for p in parts], depth, 1.0, options)
        assert cut.cycles[-1] == pytest.approx(300.0, rel=1e-12)
        np.testing.assert_array_equal(np.unique(cut.dwell), [0, 1, 2])
        ends = [cut.cycles[cut.dwell == i].max() for i in range(3)]
        np.testing.assert_allclose(ends, np.cumsum(parts), rtol=1e-12)
        change = whole.interference[0] - whole.interference[-1]
        gap = np.abs(cut.interference[-1] - whole.interference[-1]).max() / change.max()
        below("difference", gap, apart)
