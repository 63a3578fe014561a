"""The least of a peak along a parameter."""

import numpy as np
import pytest

from vanelock.published.maps.optimum import Ridge


def ridge(amplitude, parameter=None, converged=None):
    values = np.asarray(amplitude, float)
    along = np.geomspace(0.1, 10, len(values)) if parameter is None else parameter
    known = np.ones(len(values), bool) if converged is None else converged
    none = np.full(len(values), np.nan)
    return Ridge("mu", 1, along, values, none, known, none)


def test_the_least_lies_between_the_points():
    mu = np.geomspace(0.1, 10, 12)
    found = ridge(2 + np.log(mu / 0.77) ** 2, mu).best
    assert found is not None
    assert found == pytest.approx((0.77, 2.0, False), rel=1e-9)


def test_a_least_at_the_end_is_said_to_be_there():
    found = ridge([5, 4, 3, 2]).best
    assert found is not None
    assert found[2]


def test_lost_points_do_not_count():
    amplitude = np.array([5, 4, 0.1, 3, 4, 5.0])
    found = ridge(amplitude, converged=amplitude > 1).best
    assert found is not None
    assert found[1] > 2
    assert ridge(amplitude, converged=amplitude > 4.5).best is None
