"""The data beside the pictures of a run: the numbers of its results, and captions."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vanelock import nonlinear
from vanelock.nonlinear import static_response
from vanelock.results.figures.contacts import (
    Loop,
    _Around,
    _contact_columns,
    _preload_columns,
)
from vanelock.stages.parts.outputs import TANGENTS


def test_preload_columns_are_the_state_at_rest(ring):
    gap = replace(ring, contacts=replace(ring.contacts, v0=np.array([1e-5, -1e-5])))
    rest = static_response(gap)
    columns = _preload_columns(rest, gap.contacts.joint, TANGENTS)
    found = {name: np.asarray(column) for name, column in columns.items()}
    assert found["joint"].tolist() == ["hook", "interlock"]
    assert found["contact"].tolist() == [1, 1]
    assert found["state"][1] == "open"
    assert found["direction 1"].tolist() == ["circumferential", "radial"]
    assert found["direction 2"].tolist() == ["axial", "along the slant"]
    np.testing.assert_array_equal(found["normal force n (N)"], rest.force[0, 0, :, 0].real)
    assert np.isnan(found["friction utilisation |t| / (mu n) (-)"][1])


def test_a_loop_knows_its_bounds(ring):
    hertz = np.array([250.0])
    for coupling in ("coupled", "constant-load"):
        response = nonlinear.frequency_response(
            ring, hertz, nonlinear.Options(1, coupling=coupling)
        )
        loop = Loop(response, 1, ("radial", "axial"))
        n = loop.history[1][:, 0]
        expected = n if coupling == "coupled" else np.full(len(n), response.force[0, 0, 1, 0].real)
        bound = np.asarray(loop.columns()["friction limit mu n (N)"])
        np.testing.assert_allclose(bound, 0.3 * expected)


def test_contacts_are_shown_at_the_peak_and_where_half_as_much_moves():
    frequency = np.array([250.0, 251, 252, 253, 254, 255])
    amplitude = np.array([1.0, 4, 10, 7, 5.2, np.nan])
    response: Any = SimpleNamespace(
        frequency=frequency,
        converged=np.isfinite(amplitude),
        state=np.array([0, 1, 2, 0, 3, 0])[:, None],
        dissipation=1e-6 * np.arange(6.0)[:, None],
    )
    found = _Around.of(response, amplitude, 2)
    assert found.headings == ("below the peak", "at the peak", "above the peak")
    assert found.frequency.tolist() == [251, 252, 254]
    assert found.state[:, 0].tolist() == [1, 2, 3]
    assert _Around.of(response, amplitude, 0).headings == ("at the peak", "above the peak")
    columns = _contact_columns(found, ("hook",), [7], np.ones((1, 3)))
    assert np.asarray(columns["at"]).tolist() == list(found.headings)
    assert np.asarray(columns["frequency (Hz)"]).tolist() == [251, 252, 254]
    assert np.asarray(columns["energy per cycle (µJ)"]) == pytest.approx([1.0, 2.0, 4.0])
    assert np.asarray(columns["state"]).tolist() == [
        "slips",
        "open all the time",
        "slips and opens",
    ]
    two = _Around(("at the peak", "above the peak"), np.ones(2), np.eye(2, dtype=int), np.eye(2))
    columns = _contact_columns(two, ("hook", "lock"), [7, 9], np.arange(6.0).reshape(2, 3))
    assert np.asarray(columns["joint"]).tolist() == ["hook", "lock"] * 2
    assert np.asarray(columns["y (mm)"]).tolist() == [1e3, 4e3] * 2
    assert np.asarray(columns["energy per cycle (µJ)"]).tolist() == [1e6, 0, 0, 1e6]
