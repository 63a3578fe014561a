"""The curve that is drawn through the points of a response."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from vanelock.stages.response.responses import PARTS, drawn


def response(f, slope, converged=True) -> Any:
    lost = np.full(len(f), converged)
    return SimpleNamespace(
        frequency=f, converged=lost, estimates=SimpleNamespace(slope=np.asarray(slope))
    )


def test_a_curve_with_slopes_is_drawn_round():
    f = np.linspace(0.0, 3.0, 7)
    found, amplitude, converged = drawn(response(f, np.cos(f)), 2 + np.sin(f))
    assert len(found) == 6 * PARTS + 1
    np.testing.assert_allclose(amplitude, 2 + np.sin(found), atol=3e-4)
    assert converged.all()
    assert set(f) <= set(found)


def test_a_jump_is_drawn_straight():
    f = np.arange(4.0)
    a = np.array([1.0, 1.0, 2.0, 2.0])
    found, amplitude, _ = drawn(response(f, [0.0, 50.0, 50.0, 0.0]), a)
    inside = (found >= 1) & (found <= 2)
    np.testing.assert_allclose(amplitude[inside], found[inside])


def test_points_alone_where_one_is_lost_or_nothing_is_known_of_slopes():
    f = np.arange(4.0)
    lost = response(f, np.zeros(4), False)
    assert drawn(lost, f) == (lost.frequency, f, lost.converged)
    bare: Any = SimpleNamespace(frequency=f, converged=np.ones(4, bool), estimates=None)
    assert drawn(bare, f)[0] is f
