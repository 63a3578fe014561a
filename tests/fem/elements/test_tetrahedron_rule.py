"""The tetrahedron's quadrature rule against moments in closed form."""

from itertools import product
from math import factorial

import numpy as np
import pytest

from vanelock.fem.elements.reference import tetrahedron_rule


def moment(a, b, c):
    """Of x^a y^b z^c over the reference tetrahedron."""
    return factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3)


def test_moments_to_degree_five_are_exact_and_no_further():
    (x, y, z), weights = tetrahedron_rule()[0].T, tetrahedron_rule()[1]
    assert len(weights) == 14
    assert weights.min() > 0
    for a, b, c in product(range(6), repeat=3):
        if a + b + c <= 5:
            assert weights @ (x**a * y**b * z**c) == pytest.approx(moment(a, b, c), abs=1e-16)
    assert abs(weights @ x**6 - moment(6, 0, 0)) > 1e-6


def test_points_lie_inside_and_the_rule_is_symmetric():
    points, weights = tetrahedron_rule()
    full = np.column_stack([1 - points.sum(axis=1), points])
    assert full.min() > 0
    rows = {tuple(np.round([*place, w], 12)) for place, w in zip(full, weights, strict=True)}
    for order in ([1, 0, 2, 3], [1, 2, 3, 0]):
        turned = np.column_stack([full[:, order], weights])
        assert {tuple(np.round(row, 12)) for row in turned} == rows
