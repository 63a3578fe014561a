"""The curve between points, and what it says of its own error."""

import numpy as np
import pytest

from vanelock.nonlinear.adaptive.interpolant import Interpolant


def _resonance(x):
    """A peak of unit height and half-width at 0, and its slope."""
    return 1 / np.sqrt(1 + x**2), -x / (1 + x**2) ** 1.5


def test_a_cubic_is_its_own_curve():
    rng = np.random.default_rng(0)
    cubic = np.polynomial.Polynomial(rng.normal(size=4))
    x = np.sort(rng.uniform(size=7))
    curve = Interpolant(x, cubic(x), cubic.deriv()(x))
    fine = np.linspace(-0.5, 1.5, 50)
    inside = (fine > x[0]) & (fine < x[-1])
    np.testing.assert_allclose(curve.at(fine)[inside], cubic(fine)[inside], atol=1e-13)
    assert curve.uncertainty().max() < 1e-13


@pytest.mark.parametrize("points", [9, 15, 25])
def test_estimated_error_is_no_less_than_the_true_one_and_not_far_more(points):
    x = np.sinh(np.linspace(-2, 2, points))
    curve = Interpolant(x, *_resonance(x))
    estimated = curve.uncertainty()
    fine = x[:-1, None] + np.diff(x)[:, None] * np.linspace(0, 1, 40)
    true = np.abs(curve.at(fine.ravel()).reshape(fine.shape) - _resonance(fine)[0]).max(axis=1)
    assert estimated.max() > true.max()
    assert estimated.max() < 80 * true.max()


def test_points_are_wanted_until_peak_and_curve_are_known():
    share = 1e-3
    x = np.array([-8.0, -5.0, -2.2, 1.1, 4.0, 8.0])
    for _ in range(12):
        y, slope = _resonance(x)
        wanted = Interpolant(x, y, slope).wanted(share, 1e-3)
        if not len(wanted):
            break
        x = np.sort(np.append(x, wanted))
    y, slope = _resonance(x)
    fine = np.linspace(-8, 8, 2000)
    assert 1 - y.max() < share
    assert np.abs(Interpolant(x, y, slope).at(fine) - _resonance(fine)[0]).max() < share
    assert len(x) < 40
    # Where neighbours are as close as they may be, a jump is left alone.
    jump = Interpolant(
        np.array([0.0, 1.0, 1.001, 2.0]), np.array([0.0, 0.0, 1.0, 1.0]), np.zeros(4)
    )
    assert not np.any((jump.wanted(share, 0.01) > 1.0) & (jump.wanted(share, 0.01) < 1.001))


def test_no_curve_is_trusted_across_a_gap_where_it_is_high():
    # Two peaks: seen from points that miss the narrow one, the curve is smooth.
    x = np.linspace(-8, 8, 17)
    y, slope = _resonance(x / 8)
    curve = Interpolant(x, y, slope / 8)
    assert not len(curve.wanted(0.05, 1e-3))
    wanted = curve.wanted(0.05, 1e-3, 0.5)
    np.testing.assert_allclose(wanted, x[:-1] + 0.5)


def test_every_high_maximum_is_located():
    # Two maxima, the lower one between points: it may turn out the higher one.
    x = np.array([-3.0, -2.5, -2.0, -1.5, -1.0, -0.5, 0.0, 0.6, 1.3, 2.0, 2.5, 3.0])
    lower = 0.95 * np.exp(-((x - 1.0) ** 2))
    higher = np.exp(-((x + 2.0) ** 2))
    curve = Interpolant(x, lower + higher, -2 * (x - 1.0) * lower - 2 * (x + 2.0) * higher)
    (place,) = curve.wanted(0.05, 1e-3)
    assert abs(place - 1.0) < 0.02


def test_unknown_slopes_are_taken_from_neighbours():
    x = np.linspace(-2, 2, 41)
    y, slope = _resonance(x)
    slope[20] = np.nan
    curve = Interpolant(x, y, slope)
    fine = np.linspace(-2, 2, 200)
    np.testing.assert_allclose(curve.at(fine), _resonance(fine)[0], atol=1e-3)
    places, values = curve.tops()
    assert abs(places[values.argmax()]) < 0.05
