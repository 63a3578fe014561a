"""Where statements hold on a plane, from planes made by hand."""

import numpy as np
import pytest

from vanelock.published.evidence import (
    error,
    falls,
    higher_and_lower,
    share,
    slight,
)
from vanelock.published.maps.map_figures import holds, orders, plane_columns
from vanelock.published.maps.plane import Method
from vanelock.published.statements import agrees


def test_statements_hold_where_the_numbers_say_so(plane):
    found = holds(plane)
    assert orders(plane) == [1, 3, 5]
    rows = [[True] * 2, [True] * 2, [False] * 2]
    np.testing.assert_array_equal(found["peak falls with friction"], rows)
    assert found["peak falls with interference"].all()
    uncoupled = found["uncoupled: higher f, lower A"]
    np.testing.assert_array_equal(uncoupled, rows)
    assert not found["constant-load: higher f, lower A"].any()
    assert found["H = 3 changes < 10%"].all()
    assert found["H = 5 changes < 1%"].all()


def test_bounds_bind(plane):
    assert not slight(plane, 1, 3, 0.049).any()
    assert slight(plane, 1, 3, 0.051).all()
    assert not slight(plane, 3, 5, 0.0019).any()


def test_unknown_cells_hold_nothing(plane):
    plane.amplitude[1, 0] = np.nan
    assert not falls(plane.of(Method(1))[0], 0)[0, 0]
    assert not higher_and_lower(plane, "uncoupled")[1, 0]
    assert not slight(plane, 1, 3, 1.0)[1, 0]


def test_shares_are_of_the_cells_that_every_method_knows(plane):
    some = slight(plane, 1, 3, 1.0)
    some[0] = False
    assert share(plane, some) == pytest.approx(4 / 6)
    plane.amplitude[0, 0, 2] = np.nan
    assert share(plane, some) == pytest.approx(4 / 5)
    plane.amplitude[:] = np.nan
    assert np.isnan(share(plane, some))


def test_errors_are_relative_to_the_best(plane):
    np.testing.assert_allclose(error(plane, Method(1), Method(5)), 1 / 1.052 - 1)


def test_columns_have_a_row_for_each_cell_and_method(plane):
    columns = {name: np.asarray(column) for name, column in plane_columns(plane).items()}
    assert {len(column) for column in columns.values()} == {30}
    row = 5 * 3 + 1  # mu = 0.3, v = 2 um is cell 3: uncoupled
    assert columns["friction coefficient"][row] == 0.3
    assert columns["interference (µm)"][row] == pytest.approx(2)
    assert columns["method"][row] == "uncoupled, H = 1"
    assert columns["peak (µm)"][row] == pytest.approx(12)


def test_judging():
    assert agrees(True, True) == "yes"
    assert agrees(True, False) == "partly"
    assert agrees(False) == "no"
