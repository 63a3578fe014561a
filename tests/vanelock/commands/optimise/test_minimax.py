"""The smallest largest value against known minima: smooth, at a ridge, at a bound; starts."""

import numpy as np
import pytest

from vanelock.commands.optimise.objective import Functions, minimax
from vanelock.commands.optimise.search import spread


def test_starts_spread_over_the_bounds():
    low, high = np.array([0.0, 10.0]), np.array([1.0, 30.0])
    places = spread(low, high, 30)
    assert ((low < places) & (places < high)).all()
    share = (places - low) / (high - low)
    quarters = 2 * (share[:, 0] > 0.5) + (share[:, 1] > 0.5)
    assert np.bincount(quarters.astype(int), minlength=4).min() >= 6


WIDE = np.full(2, -3.0), np.full(2, 3.0)


def rosen(x):
    value = 1 + (1 - x[0]) ** 2 + 10 * (x[1] - x[0] ** 2) ** 2
    slope = [-2 * (1 - x[0]) - 40 * x[0] * (x[1] - x[0] ** 2), 20 * (x[1] - x[0] ** 2)]
    return Functions(np.array([value]), np.array([slope]))


def cb2(x):
    """Charalambous and Bandler's second: 1.9522245 at (1.139, 0.900)."""
    a, b = x
    value = [a**2 + b**4, (2 - a) ** 2 + (2 - b) ** 2, 2 * np.exp(b - a)]
    e = 2 * np.exp(b - a)
    slope = [[2 * a, 4 * b**3], [2 * a - 4, 2 * b - 4], [-e, e]]
    return Functions(np.array(value), np.array(slope))


def solved(*given):
    found = minimax(*given)
    assert found is not None
    return found


def test_a_smooth_valley():
    found = solved(rosen, np.array([-1.2, 1.0]), WIDE, 1e-9, 200)
    np.testing.assert_allclose(found.x, [1, 1], atol=1e-3)
    assert found.settled


def test_a_corner_of_three_functions():
    tried = []

    def counted(x):
        tried.append(x)
        return cb2(x)

    found = solved(counted, np.array([2.0, 2.0]), WIDE, 1e-9)
    assert found.functions.largest == pytest.approx(1.9522245, rel=1e-6)
    assert len(tried) < 30


def test_bounds_hold_and_lost_places_are_left():
    def slope(x):
        if x[0] < 0.2:
            return None
        return Functions(np.array([1 + x[0]]), np.array([[1.0]]))

    found = solved(slope, np.array([1.0]), (np.array([0.0]), np.array([3.0])), 1e-6)
    assert 0.2 <= found.x[0] < 0.201
    high = solved(
        lambda x: Functions(np.array([9 - x[0]]), np.array([[-1.0]])),
        np.array([1.0]),
        (np.array([0.0]), np.array([2.5])),
        1e-6,
    )
    assert abs(high.x[0] - 2.5) <= np.spacing(2.5)
    assert minimax(lambda x: None, np.array([1.0]), (np.zeros(1), np.ones(1)), 1e-6) is None
