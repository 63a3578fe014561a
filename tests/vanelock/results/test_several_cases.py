"""Golden runs: page, terminal and CSV say of each case what the results hold of it."""

import csv
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from tests.vanelock.pipeline.test_progress import summary
from tests.vanelock.results.pages import card, number, on_page, plain
from vanelock import parse_study
from vanelock.results.page import _speed
from vanelock.stages.response.summary import Peak

CASES = {
    f"mu={mu},force={force}N": f"μ = {mu}, force = {force} N"
    for mu in (0.15, 0.3)
    for force in (10, 20)
}


@pytest.fixture(scope="module")
def ran(golden):
    return golden("sweep")


@pytest.fixture(scope="module")
def results(ran):
    """By case: its attributes, and those of its answers."""
    with h5py.File(ran.folder / "results.h5") as file:
        groups = {name: file["response"][name] for name in CASES}
        return {n: (dict(each.attrs), dict(each["answers"].attrs)) for n, each in groups.items()}


@pytest.fixture(scope="module")
def page(ran):
    return (ran.folder / "report.html").read_text("utf-8")


def slug(name):
    return name.replace("=", "").replace(",", "_")


def written(path):
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    return [{k: number(v) for k, v in row.items()} for row in csv.DictReader(lines)]


def test_the_answers_are_those_of_the_largest_peak(page, results):
    """Here not of the first case, nor the first by name."""
    name = max(results, key=lambda name: results[name][0]["peak_amplitude"])
    assert name == "mu=0.15,force=20N"
    case, _ = results[name]
    value, note = card(page, "Largest peak")
    assert float(value.split()[0]) == pytest.approx(1e6 * case["peak_amplitude"], rel=5e-3)
    assert note.startswith(CASES[name])
    note = card(page, "Frequency")[1]
    assert "rpm at engine order 1" in note
    assert f"{100 * case['position']:.0f} % of the shift" in note
    _, rows = on_page(page, "All cases at their largest")
    assert [row[0] for row in rows] == list(CASES.values())


def test_a_rotor_speed_is_the_frequency_over_the_engine_order():
    study = parse_study("[excitation]\nengine_order = -3")
    case = SimpleNamespace(ring=(40, study.excitation.engine_order))
    content: Any = SimpleNamespace(errors={"a": None}, cases={"a": case})
    found = summary(case="a", peak=Peak(3, 250.0, 1e-5, False), position=0.25)
    assert _speed(content, found) == (
        "5,000 rpm at engine order 3; 25 % of the shift from free to stuck"
    )


def test_rotor_speeds_are_frequencies_over_the_engine_order(golden):
    ran = golden("everything")
    with h5py.File(ran.folder / "results.h5") as file:
        assert "campbell" in file["response/nominal"]
        peak = file["response/nominal"].attrs["peak_amplitude"]
    crossings = written(ran.folder / "figures" / "campbell_crossings.csv")
    assert {row["engine order"] for row in crossings} == {1, 2}
    for row in crossings:
        speed = 60 * row["frequency (Hz)"] / row["engine order"]
        assert row["rotor speed (rpm)"] == pytest.approx(speed)
    circles = written(ran.folder / "figures" / "campbell_circles.csv")
    own = [row for row in circles if row["nonlinear"] == 1]
    assert max(row["amplitude (µm)"] for row in own) == pytest.approx(1e6 * peak, rel=1e-6)
    for row in own:  # of engine order 1, as the load
        assert row["rotor speed (rpm)"] == pytest.approx(60 * row["frequency (Hz)"])
    for row in ran.rows("crossings"):
        speed = 60 * row["frequency_hz"] / row["engine_order"]
        assert row["speed_rpm"] == pytest.approx(speed)


def test_each_case_is_swept_in_both_directions(ran):
    """Without a jump both find the same."""
    for found in ran.summaries:
        assert [sweep.direction for sweep in found.sweeps] == ["up", "down"]
        with h5py.File(ran.folder / "results.h5") as file:
            case = file["response"][found.case]
            assert case["jumps"].shape == case["lower/jumps"].shape == (0, 4)
            two = {each.attrs["direction"]: each["amplitude"][()] for each in (case, case["lower"])}
        assert set(two) == {"up", "down"}
        np.testing.assert_allclose(two["down"], two["up"], rtol=1e-6)
    assert not any("sweep" in line for line in ran.table("cases").notes)


def test_warnings_stand_in_the_table_on_the_page_and_in_the_results(ran, results, page):
    warned = {name: list(case["warnings"]) for name, (case, _) in results.items()}
    (name,) = [name for name, lines in warned.items() if lines]
    (line,) = warned[name]
    assert "in one direction, is not determined: it can hold" in line
    assert ran.table("cases").notes == [f"warning: {name}: {line}."]
    assert f"{CASES[name]}: {line}." in plain(page)
