"""How near neighbouring aerofoils come."""

import numpy as np
import pytest

from vanelock.mesh.checks.dimensions import _gap


@pytest.mark.parametrize("step", [0.5, 1.5, 2.5, 4.0])
def test_circles_are_a_diameter_nearer_than_their_middles(step: float) -> None:
    """By how much they cross, too, wherever they stand."""
    angle = 2 * np.pi * np.arange(400) / 400
    circle = np.column_stack([3 + np.cos(angle), -7 + np.sin(angle)])
    assert _gap(circle, step) == pytest.approx(step - 2, abs=1e-4)
