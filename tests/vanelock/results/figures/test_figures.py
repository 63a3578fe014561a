"""The data beside the pictures of a run: the numbers of its results, and captions."""

import csv
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from tests.small_study import HOOK, INTERLOCK
from vanelock import load_component, nonlinear
from vanelock.nonlinear import Response, static_response
from vanelock.pipeline.progress import Finished
from vanelock.results.figures.contacts.contacts import Around
from vanelock.results.figures.contacts.contacts import columns as contact_columns
from vanelock.results.figures.contacts.loops import Loop
from vanelock.results.figures.contacts.preload import columns as preload_columns
from vanelock.stages.parts.places import TANGENTS


def read(path):
    """Columns of a CSV file by their headers, text as it stands."""
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("# ")]
    header, *rows = csv.reader(lines)
    assert len(set(header)) == len(header)
    return {name: [row[i] for row in rows] for i, name in enumerate(header)}


def numbers(cells):
    return np.array([float(cell) for cell in cells if cell])


def test_preload_columns_are_the_state_at_rest(ring):
    gap = replace(ring, contacts=replace(ring.contacts, v0=np.array([1e-5, -1e-5])))
    rest = static_response(gap)
    columns = preload_columns(rest, gap.contacts.joint, TANGENTS)
    found = {name: np.asarray(column) for name, column in columns.items()}
    assert found["joint"].tolist() == ["hook", "interlock"]
    assert found["contact"].tolist() == [1, 1]
    assert found["state"][1] == "open"
    assert found["direction 1"].tolist() == ["circumferential", "radial"]
    assert found["direction 2"].tolist() == ["axial", "along the slant"]
    np.testing.assert_array_equal(found["normal force n (N)"], rest.force[0, 0, :, 0].real)
    assert np.isnan(found["friction utilisation |t| / (mu n) (-)"][1])


def test_data_beside_the_pictures_are_the_results(golden):
    known = golden("default")
    figures = known.folder / "figures"
    with h5py.File(known.folder / "results.h5") as file:
        response, free, stuck = (
            Response.load(file[f"response/{name}"]) for name in ("nominal", "free", "stuck")
        )
        rest = file["response/nominal/preload/force"][0, 0].real
    table = read(figures / "response.csv")
    # The monitored component is the one that moves most where the interlock is free.
    component = int(free.amplitude[:, 0].max(axis=0).argmax())
    for name, found in (("linear, free", free), ("linear, stuck", stuck), ("H = 3", response)):
        own = [i for i, curve in enumerate(table["curve"]) if name in curve]
        frequency, amplitude = (
            numbers([table[head][i] for i in own]) for head in ("frequency (Hz)", "amplitude (µm)")
        )
        np.testing.assert_allclose(amplitude, 1e6 * found.amplitude[:, 0, component], rtol=1e-15)
        np.testing.assert_array_equal(frequency, found.frequency)
    table = read(figures / "loop_nominal.csv")
    peak = int(response.amplitude[:, 0, component].argmax())
    own = response.dissipation[peak] * (np.arange(HOOK + INTERLOCK) >= HOOK)  # the interlock's
    u, f = nonlinear.contact_loop(response, peak, int(own.argmax()))
    np.testing.assert_allclose(
        numbers(table["displacement, along the slant (µm)"]), 1e6 * u[:, 2], rtol=1e-14
    )
    np.testing.assert_array_equal(numbers(table["friction force, along the slant (N)"]), f[:, 2])
    table = read(figures / "preload.csv")
    np.testing.assert_allclose(numbers(table["normal force n (N)"]), rest[:, 0], rtol=1e-12)
    finished = known.events[-1]
    assert isinstance(finished, Finished)
    names = {str(figures / name) for name in ("response.csv", "preload.csv")}
    assert names <= set(finished.summary["pictures"])


def test_contacts_beside_their_picture_are_the_results(golden):
    known = golden("default")
    with h5py.File(known.folder / "results.h5") as file:
        response = Response.load(file["response/nominal"])
    masters = load_component(known.folder / "results.h5", "vane").masters
    peak = known.summaries[0].peak
    table = read(known.folder / "figures" / "contacts_nominal.csv")
    sides = {"below the peak": -1, "at the peak": 0, "above the peak": 1}
    assert set(table["at"]) == set(sides)
    words = np.array(["sticks", "slips", "opens", "slips and opens"])
    for at, side in sides.items():
        own = [i for i, where in enumerate(table["at"]) if where == at]
        mine = {head: [column[i] for i in own] for head, column in table.items()}
        (hertz,) = {float(cell) for cell in mine["frequency (Hz)"]}
        point = int(np.abs(response.frequency - hertz).argmin())
        assert hertz == pytest.approx(response.frequency[point])
        assert np.sign(point - peak.point) == side
        energy = numbers(mine["energy per cycle (µJ)"])
        np.testing.assert_allclose(energy, 1e6 * response.dissipation[point], rtol=1e-14)
        assert mine["state"] == words[response.state[point]].tolist()
        place = masters.position(np.array(mine["node of the vane (from 0)"], int))
        np.testing.assert_allclose(numbers(mine["x (mm)"]), 1e3 * place[:, 0])
        np.testing.assert_allclose(numbers(mine["z (mm)"]), 1e3 * place[:, 2])
        assert mine["joint"] == ["hook"] * HOOK + ["interlock"] * INTERLOCK


def test_a_loop_knows_its_bounds(ring):
    hertz = np.array([250.0])
    for coupling in ("coupled", "constant-load"):
        response = nonlinear.frequency_response(
            ring, hertz, nonlinear.Options(1, coupling=coupling)
        )
        loop = Loop(response, 1)
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
    found = Around.of(response, amplitude, 2)
    assert found.headings == ("below the peak", "at the peak", "above the peak")
    assert found.frequency.tolist() == [251, 252, 254]
    assert found.state[:, 0].tolist() == [1, 2, 3]
    assert Around.of(response, amplitude, 0).headings == ("at the peak", "above the peak")
    columns = contact_columns(found, ("hook",), [7], np.ones((1, 3)))
    assert np.asarray(columns["at"]).tolist() == list(found.headings)
    assert np.asarray(columns["frequency (Hz)"]).tolist() == [251, 252, 254]
    assert np.asarray(columns["energy per cycle (µJ)"]) == pytest.approx([1.0, 2.0, 4.0])
    two = Around(("at the peak", "above the peak"), np.ones(2), np.eye(2, dtype=int), np.eye(2))
    columns = contact_columns(two, ("hook", "lock"), [7, 9], np.arange(6.0).reshape(2, 3))
    assert np.asarray(columns["joint"]).tolist() == ["hook", "lock"] * 2
    assert np.asarray(columns["y (mm)"]).tolist() == [1e3, 4e3] * 2
    assert np.asarray(columns["energy per cycle (µJ)"]).tolist() == [1e6, 0, 0, 1e6]
