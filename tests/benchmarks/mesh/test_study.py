"""Arithmetic of the mesh study."""

import numpy as np
import pytest

from benchmarks.mesh import families, reference, study
from vanelock.mesh import Part
from vanelock.mesh.generate import mesher


def test_limit_of_a_power():
    order = reference.ORDER
    values = [3.0 + 0.7 * h**order for h in (0.4, 0.2)]
    assert reference.extrapolated(*values) == pytest.approx(3.0, abs=1e-14)
    values = [3.0 + 0.7 * h**2.0 for h in (0.4, 0.2)]
    assert reference.extrapolated(*values, 2.0) == pytest.approx(3.0, abs=1e-14)


def test_dofs_and_time_for_an_error_follow_power_laws():
    exact = np.arange(1.0, 11.0)
    rows = [
        families.Row("", "", n, 0, np.array([9.0, 0.25, 0.25, 0.5]) * n, exact * (1 + 10 / n))
        for n in (100, 400, 1600)
    ]
    dofs, spent = study.needed(rows, exact, 0.05)
    assert dofs == pytest.approx(200)
    assert spent == pytest.approx(200)  # meshing left out
    assert study.needed(rows, exact, 1e-3) is None
    assert study.needed(rows, exact, 0.2) is None


def test_straightened_sides_are_chords(lattice):

    def bent(p):
        return np.column_stack([p[:, 0], p[:, 1], p[:, 2] + 0.2 * p[:, 0] ** 2])

    curved = lattice((2, 1, 1), bent, "tetra10", True)
    part = Part("bar", curved.points, curved.cells, "tetra10", {}, {}, 1)
    straight = families.straightened(part)
    linear = families.linear(part)
    ends = part.points[part.cells[:, :4]]
    for middle, (a, b) in enumerate(mesher.EDGES, start=4):
        chord = 0.5 * (ends[:, a] + ends[:, b])
        np.testing.assert_allclose(straight.points[part.cells[:, middle]], chord, atol=1e-15)
    np.testing.assert_array_equal(linear.points[linear.cells], ends)
    assert abs(straight.points - part.points).max() > 0.01  # 0.2 / 16 where x spans half
