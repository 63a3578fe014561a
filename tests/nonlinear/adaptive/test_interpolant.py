"""The curve between points, and what it says of its own error."""

import numpy as np
import pytest

from vanelock.nonlinear.adaptive.interpolant import Interpolant


def _resonance(x):
    """A peak of unit height and half-width at 0, and its slope."""
    return 1 / np.sqrt(1 + x**2), -x / (1 + x**2) ** 1.5


@pytest.mark.parametrize("points", [9, 15, 25])
def test_estimated_error_is_no_less_than_the_true_one_and_not_far_more(points):
    x = np.sinh(np.linspace(-2, 2, points))
    curve = Interpolant(x, *_resonance(x))
    estimated = curve.uncertainty()
    fine = x[:-1, None] + np.diff(x)[:, None] * np.linspace(0, 1, 40)
    true = np.abs(curve.at(fine.ravel()).reshape(fine.shape) - _resonance(fine)[0]).max(axis=1)
    assert estimated.max() > true.max()
    assert estimated.max() < 80 * true.max()


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
