"""The data beside the pictures of a run: the numbers of its results, and captions that tell it."""

import csv
from dataclasses import replace

import h5py
import numpy as np
import pytest

from vanelock import nonlinear
from vanelock.nonlinear import Response, static_response
from vanelock.study import parse_study, run_study
from vanelock.study.loop_exhibits import Loop
from vanelock.study.preload_exhibits import columns as preload_columns
from vanelock.study.progress import Event, Finished

STUDY = """
[mesh]
size = "coarse"
[response]
frequencies = [262, 266, 270]
harmonics = 2
[outputs]
shapes = false
"""


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
    columns = preload_columns(rest, gap.contacts.joint)
    found = {name: np.asarray(column) for name, column in columns.items()}
    assert found["joint"].tolist() == ["hook", "interlock"]
    assert found["contact"].tolist() == [1, 1]
    assert found["state"][1] == "open"
    np.testing.assert_array_equal(found["normal force n (N)"], rest.force[0, 0, :, 0].real)
    assert np.isnan(found["|t| / (mu n) (-)"][1])


@pytest.mark.slow
def test_data_beside_the_pictures_are_the_results(tmp_path):
    heard: list[Event] = []
    run_study(parse_study(STUDY), tmp_path, heard.append)
    with h5py.File(tmp_path / "results.h5") as file:
        response, free, stuck = (
            Response.load(file[f"response/{name}"]) for name in ("nominal", "free", "stuck")
        )
    table = read(tmp_path / "figures" / "response.csv")
    # The monitored component is the one that moves most where the interlock is free.
    component = int(free.amplitude[:, 0].max(axis=0).argmax())
    for name, found in (("linear, free", free), ("linear, stuck", stuck), ("H = 2", response)):
        (label,) = (head for head in table if head.startswith("amplitude") and name in head)
        amplitude = numbers(table[label])
        np.testing.assert_allclose(amplitude, 1e6 * found.amplitude[:, 0, component], rtol=1e-15)
        label = label.replace("amplitude (µm)", "frequency (Hz)")
        np.testing.assert_array_equal(numbers(table[label]), found.frequency)
    table = read(tmp_path / "figures" / "loop_nominal.csv")
    peak = int(response.amplitude[:, 0, component].argmax())
    own = response.dissipation[peak] * (np.arange(66) >= 56)  # the interlock's
    u, f = nonlinear.contact_loop(response, peak, int(own.argmax()))
    np.testing.assert_allclose(numbers(table["sliding u2 (µm)"]), 1e6 * u[:, 2], rtol=1e-14)
    np.testing.assert_array_equal(numbers(table["friction force t2 (N)"]), f[:, 2])
    told = heard[-1]
    assert isinstance(told, Finished)
    names = {str(tmp_path / "figures" / name) for name in ("response.csv", "preload.csv")}
    assert names <= set(told.summary["pictures"])
    written = {path: path.stat().st_mtime_ns for path in (tmp_path / "figures").iterdir()}
    run_study(parse_study(STUDY), tmp_path)
    assert {path: path.stat().st_mtime_ns for path in written} == written
    run_study(parse_study(STUDY + "loops = false"), tmp_path)
    left = {path.name for path in (tmp_path / "figures").iterdir()}
    assert left == {"response.png", "response.csv", "preload.png", "preload.csv"}


def test_a_loop_knows_its_bounds(ring):
    hertz = np.array([250.0])
    for coupling in ("coupled", "constant-load"):
        response = nonlinear.frequency_response(ring, hertz, harmonics=1, coupling=coupling)
        loop = Loop(response, 1)
        n = loop.history[1][:, 0]
        expected = n if coupling == "coupled" else np.full(len(n), response.force[0, 0, 1, 0].real)
        bound = np.asarray(loop.columns()["bound of friction mu n (N)"])
        np.testing.assert_allclose(bound, 0.3 * expected)
