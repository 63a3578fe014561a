"""Hysteresis of a sweep against the closed form of an oscillator that hits a stop."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from tests.nonlinear.systems import GAP_DAMPING, GAP_FORCE, gap_oscillator
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    OPEN,
    SLIP_OPEN,
    Contact,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    hysteresis,
)
from vanelock.nonlinear.fourier import TURN
from vanelock.nonlinear.newton.newton import solve

DAMPING, FORCE = GAP_DAMPING, GAP_FORCE
LOW, HIGH = 0.9, 1.25


def frequencies_of(X):
    """The two frequencies, rad/s, at which its first harmonic has the amplitude X; or none."""

    def integrals(mean):
        gap = 1 - mean
        if gap >= X:
            return 0.0, 0.0
        touch = np.arccos(gap / X)
        zero = (X * np.sin(touch) - gap * touch) / np.pi
        first = X * (touch / 2 + np.sin(2 * touch) / 4) - gap * np.sin(touch)
        return zero, 2 / np.pi * first

    mean = brentq(lambda mean: mean + integrals(mean)[0], -X, 0.0, xtol=1e-15)
    spring = 1 + integrals(mean)[1] / X
    middle = spring - DAMPING**2 / 2
    root = middle**2 - spring**2 + (FORCE / X) ** 2
    if root < 0:
        return np.full(2, np.nan)
    squares = middle + np.sqrt(root) * np.array([-1, 1])
    return np.sqrt(np.where(squares > 0, squares, np.nan))


@cache
def closed_folds():
    """(ω, X) of the upper fold, near the tip of the peak, and of the lower one."""
    X = np.linspace(1.0, 8.0, 4001)
    both = np.array([frequencies_of(x) for x in X])
    both = both[np.isfinite(both[:, 0])]
    X = X[: len(both)]
    tip = X[-1]
    side = int(np.argmax(both.max(axis=0)))
    options = {"xatol": 1e-12}
    high = X[np.argmax(both[:, side])]
    near = (high - 0.02, min(tip, high + 0.02))
    top = minimize_scalar(
        lambda x: -frequencies_of(x)[side], bounds=near, method="bounded", options=options
    )
    bottom = minimize_scalar(
        lambda x: frequencies_of(x)[1], bounds=(1.0, 1.5), method="bounded", options=options
    )
    return (-top.fun, top.x), (bottom.fun, bottom.x)


@pytest.fixture(scope="module")
def both_ways():
    return hysteresis(gap_oscillator(), np.linspace(LOW, HIGH, 61) / TURN, Options(1))


@pytest.mark.parametrize("damping", ["C", "ratio"])
def test_branch_is_the_closed_form_with_both_folds(both_ways, damping):
    found = both_ways
    if damping == "ratio":
        # Damped as the mode that does not touch the other spring.
        system = gap_oscillator(C=None, damping_ratio=DAMPING / 2)
        found = hysteresis(system, (LOW / TURN, 1.15 / TURN), Options(1))
    assert found.complete
    assert found.connected
    assert found.branch.converged.all()
    omega, X = TURN * found.branch.frequency, found.branch.amplitude[:, 0, 0]
    for one, amplitude in zip(omega, X, strict=True):
        assert np.nanmin(np.abs(frequencies_of(amplitude) - one)) < 1e-7
    # Drawn as a polygon it is smooth: neighbours differ little.
    assert np.abs(np.diff(omega)).max() < 0.06 * (HIGH - LOW)
    assert np.abs(np.diff(X)).max() < 0.06 * X.max()
    (top, high), (bottom, low) = closed_folds()
    assert found.upper.tolist() == [True, False]
    assert not found.sharp.any()
    np.testing.assert_allclose(omega[found.fold], [top, bottom], rtol=1e-9)
    np.testing.assert_allclose(X[found.fold], [high, low], rtol=1e-5)
    np.testing.assert_allclose(TURN * found.several, [[bottom, top]], rtol=1e-9)
    first, last = found.fold
    assert found.unstable[first + 1 : last].all()
    assert not found.unstable[: first + 1].any()
    assert not found.unstable[last:].any()
    np.testing.assert_array_equal(np.unique(found.passed), [0, 1, 2])
    assert found.branch.state[0, 0] == OPEN
    assert found.branch.state[first, 0] == SLIP_OPEN


@pytest.mark.parametrize("short", [1e-6, 1e-2])
def test_a_fold_beyond_the_range_is_not_of_the_path(short):
    (top, high), _ = closed_folds()
    end = top * (1 - short)
    found = hysteresis(gap_oscillator(), (LOW / TURN, end / TURN), Options(1))
    assert found.complete
    assert not len(found.fold)
    assert TURN * found.branch.frequency[-1] == pytest.approx(end, rel=1e-14)
    assert found.branch.frequency.argmax() == len(found.branch.frequency) - 1
    last = found.branch.amplitude[-1, 0, 0]
    assert np.nanmin(np.abs(frequencies_of(last) - end)) < 1e-7
    assert not found.unstable.any()
    assert short == 1e-2 or last > high  # between the tip and the fold


def test_points_that_miss_the_tolerance_are_reported(monkeypatch):
    def missed(*given, **options):
        return replace(solve(*given, **options), converged=False)

    monkeypatch.setattr("vanelock.nonlinear.continuation.arc_length.refined", missed)
    lost = "vanelock.nonlinear.forced_response.hysteresis.land"
    monkeypatch.setattr(lost, lambda *given: replace(given[1], converged=False))
    with pytest.warns(RuntimeWarning, match="no solution was found at the highest frequency"):
        found = hysteresis(gap_oscillator(), (LOW / TURN, HIGH / TURN), Options(1))
    assert (~found.branch.converged).sum() > 3
    assert not found.complete


def test_sweeps_differ_between_the_folds_alone(both_ways):
    (top, _), (bottom, _) = closed_folds()
    hertz, found = np.linspace(LOW, HIGH, 61) / TURN, both_ways
    np.testing.assert_allclose(found.up.frequency, hertz, rtol=1e-14)
    np.testing.assert_allclose(found.down.frequency, hertz, rtol=1e-14)
    omega = TURN * hertz
    np.testing.assert_array_equal(found.differ, (omega > bottom) & (omega < top))
    assert found.differ.sum() > 3
    higher = found.up.amplitude[found.differ, 0, 0] / found.down.amplitude[found.differ, 0, 0]
    assert higher.min() > 1.5


def test_impossible_ranges_are_refused():
    with pytest.raises(InputError, match="frequencies: given"):
        hysteresis(gap_oscillator(), [1.0], Options(1))
    with pytest.raises(InputError, match="frequencies: given"):
        hysteresis(gap_oscillator(), (1.0, 1.0), Options(1))


def two_masses():
    """Two unit masses in a chain, a stiff spring behind a gap at the first (Krack and Gross, 2019).

    Example 3 of the program NLvib that comes with their book on harmonic balance: period-one
    solutions fold, double their period and become quasi-periodic between 0.5 and 0.8 rad/s.
    """
    K = np.array([[1.0, -1.0], [-1.0, 2.0]])
    stop = Contact(normal=0, kn=100.0, gap=1.0)
    return System.from_matrices(np.eye(2), K, [stop], C=0.03 * K, force={1: 0.1})


def test_a_contact_that_opens_wide_is_followed_in_a_few_hundred_points():
    found = hysteresis(two_masses(), [0.6 / TURN, 0.77 / TURN], Options(3))
    assert found.complete
    assert found.connected
    assert found.ended == ""
    assert found.branch.converged.all()
    assert len(found.branch.frequency) < 400
    assert found.upper.tolist() == [True, False]
    # Where one solution exists a sweep by frequency finds the same; above, it may jump off early.
    alone = TURN * found.branch.frequency < 0.65
    picked = np.flatnonzero(alone & (found.passed == 0))[::8]
    swept = frequency_response(two_masses(), found.branch.frequency[picked], Options(3))
    np.testing.assert_allclose(swept.amplitude, found.branch.amplitude[picked], rtol=1e-7)


def test_a_path_that_ends_early_says_where_and_why(monkeypatch):
    monkeypatch.setattr("vanelock.nonlinear.forced_response.hysteresis._LIMIT", 20)
    with pytest.warns(RuntimeWarning, match="hysteresis: the path ended at") as warned:
        found = hysteresis(gap_oscillator(), [LOW / TURN, HIGH / TURN], Options(1))
    assert not found.complete
    assert not found.connected
    assert str(warned[0].message) == f"hysteresis: {found.ended}"
    assert warned[0].filename == __file__
    at = f"{found.branch.frequency[-1]:g} Hz of {LOW / TURN:g} ... {HIGH / TURN:g}, after 20 points"
    assert at in found.ended
    assert found.ended.endswith("it goes on, but 20 points are the most")


@pytest.mark.parametrize("more", [0.0, -1e-4])
def test_a_path_goes_on_where_another_branch_crosses_it(more):
    """It does not turn back there, though the sign of det P may change.

    Rounding decides which branch goes on: the same one, on which stability is lost once, or the
    other, on which it is not.
    """
    springs = [1.75, 0.59, 1.74, 0.75]
    chain = np.diag(np.add(springs[:-1], springs[1:]))
    chain -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    K = np.kron(np.eye(2), chain)  # three masses, each of two directions
    own = np.zeros((3, 3, 6))
    own[[0, 2], 0, 0], own[1, 0, 1] = -1.0, 1.0
    own[[0, 2], 1, 3], own[1, 1, 4] = 1.0, 1.0
    diameter = Diameter(K=K, M=np.eye(6), C=0.03 * K, own=own)
    contacts = Contacts([7.8] * 3, [[5.5] * 2] * 3, [0.3] * 3, [0.1, -0.1, 0.1])
    force = {1: Force([0.15 * (1 + more), 0, 0, 0, 0, 0])}
    system = System(1, 0, {0: diameter}, contacts, force)
    found = hysteresis(system, [0.8 / TURN, 2.2 / TURN], Options(1))
    assert found.complete
    assert found.upper.tolist() == [True, False]
    assert len(found.several) == 1
    crossed = np.flatnonzero(np.diff(found.unstable) != 0) + 1
    fallen = np.setdiff1d(crossed, np.concatenate([found.fold, found.fold + 1]))
    assert len(fallen) <= 1
    assert (np.diff(found.branch.frequency[found.fold[-1] :]) > 0).all()
