"""Golden runs: page, terminal and CSV say of each case what the results hold of it."""

import csv
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from tests.vanelock.pipeline.test_progress import summary
from tests.vanelock.results.pages import card, number, on_page, plain
from tests.vanelock.stages.conftest import STEEL
from vanelock import fem, mesh, parse_study
from vanelock.results.page_sections.summary import _speed
from vanelock.stages.response.summary import Peak

CASES = {
    f"mu={mu},force={force}N": f"μ = {mu}, force = {force} N"
    for mu in (0.15, 0.3)
    for force in (10, 20)
}
LIMIT, STRENGTH = 250.0, 900.0  # MPa, the defaults


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


def position(row):
    return [row[f"{axis} (mm)"] for axis in "xyz"]


def largest(results):
    """The case of the largest peak: here not the first one, nor the first by name."""
    found = max(results, key=lambda name: results[name][0]["peak_amplitude"])
    assert found == "mu=0.15,force=20N"
    return found


def test_each_line_of_the_summary_is_that_case_s(page, results):
    head, rows = on_page(page, "All cases at their largest")
    columns = {
        "peak µm": lambda case, _: 1e6 * case["peak_amplitude"],
        "at Hz": lambda case, _: case["peak_frequency"],
        "relative to free": lambda case, _: case["of_free"],
        "relative to stuck": lambda case, _: case["of_stuck"],
        "damping ratio %": lambda _, answers: 100 * answers["damping_ratio"],
        "dissipated µJ": lambda _, answers: 1e6 * answers["friction_work"],
        "slip %": lambda case, _: 100 * case["slipping"],
        "open %": lambda case, _: 100 * case["opening"],
        "vibratory stress MPa": lambda _, answers: 1e-6 * answers["alternating_stress"],
        "HCF safety factor": lambda _, answers: answers["goodman_reserve"],
    }
    assert head[1:] == [*columns]
    assert [row[0] for row in rows] == list(CASES.values())
    for row, (case, answers) in zip(rows, results.values(), strict=True):
        expected = [value(case, answers) for value in columns.values()]
        assert row[1:] == pytest.approx(expected, rel=1e-3)
    assert rows[0][9] != pytest.approx(rows[1][9], rel=0.02)  # or one could stand for the other


def test_the_answers_are_those_of_the_largest_peak(page, results):
    name = largest(results)
    case, answers = results[name]
    value, note = card(page, "Largest peak")
    assert float(value.split()[0]) == pytest.approx(1e6 * case["peak_amplitude"], rel=5e-3)
    assert note.startswith(CASES[name])
    value, note = card(page, "Frequency")
    assert float(value.split()[0]) == pytest.approx(case["peak_frequency"], abs=0.006)
    rpm = float(note.partition(" rpm")[0].split()[-1].replace(",", ""))
    assert rpm == pytest.approx(60 * case["peak_frequency"], abs=0.6)
    assert "rpm at engine order 1" in note
    assert f"{100 * case['position']:.0f} % of the shift" in note
    assert card(page, "Equivalent damping")[0] == f"{100 * answers['damping_ratio']:.2g} %"
    friction = 100 * answers["friction_work"] / answers["input_work"]
    assert card(page, "Share of friction")[0] == f"{friction:.0f} %"
    assert float(card(page, "Critical stress")[0].split()[0]) == pytest.approx(
        1e-6 * answers["alternating_stress"], rel=5e-3
    )
    assert float(card(page, "HCF safety factor")[0].split()[-1]) == pytest.approx(
        answers["goodman_reserve"], rel=5e-3
    )


def test_a_rotor_speed_is_the_frequency_over_the_engine_order():
    study = parse_study("[excitation]\nengine_order = -3")
    planned = SimpleNamespace(case=SimpleNamespace(name="a", given=study))
    case = SimpleNamespace(planned=planned)
    content: Any = SimpleNamespace(errors={"a": None}, cases={"a": case})
    found = summary(case="a", peak=Peak(3, 250.0, 1e-5, False), position=0.25)
    assert _speed(content, found) == (
        "5,000 rpm at engine order 3; 25 % of the shift from free to stuck"
    )


def test_reserves_follow_from_the_stresses_in_their_rows(page, ran, results):
    name = largest(results)
    head, rows = on_page(page, "Worst location of each feature")
    assert head[2:] == [
        "alternating MPa",
        "mean MPa",
        "n, hydrostatic mean",
        "n, von Mises mean",
        "vibratory stress margin",
    ]
    nodes = written(ran.folder / "figures" / f"fatigue_{slug(name)}.csv")
    different = 0
    for row in rows:
        alternating, mean, n, other, growth = row[2:]
        assert 1 / n == pytest.approx(alternating / LIMIT + max(mean, 0) / STRENGTH, rel=2e-2)
        rest = 1 - max(mean, 0) / STRENGTH
        assert growth == pytest.approx(rest * LIMIT / alternating, rel=2e-2)
        r, angle, z = (float(each) for each in row[1].split(","))
        place = [r * np.cos(np.radians(angle)), r * np.sin(np.radians(angle)), z]
        apart = [np.linalg.norm(np.subtract(position(each), place)) for each in nodes]
        node = nodes[int(np.argmin(apart))]
        if min(apart) > 0.2:  # a place on the casing
            continue
        assert node["amplitude (MPa)"] == pytest.approx(alternating, rel=1e-3)
        signed = max(node["signed mean (MPa)"], 0)
        assert 1 / other == pytest.approx(alternating / LIMIT + signed / STRENGTH, rel=2e-2)
        different += abs(other / n - 1) > 5e-3
    assert different  # the two rules differ, or their columns could change places


def test_the_governing_place_of_each_case_is_its_own(page, results):
    _, rows = on_page(page, "The critical location of each case")
    by_case = {row[0].split(":")[0]: row for row in rows}
    for name, words in CASES.items():
        answers = results[name][1]
        assert by_case[words][2] == pytest.approx(1e-6 * answers["alternating_stress"], rel=1e-3)
        assert by_case[words][4] == pytest.approx(answers["goodman_reserve"], rel=1e-3)


def test_energy_and_damping_of_each_case(page, results):
    head, rows = on_page(page, "Power of one sector at the peak of each case")
    assert head[1] == "power mW"
    for row, (case, answers) in zip(rows, results.values(), strict=True):
        power = 1e3 * answers["input_work"] * case["peak_frequency"]
        assert row[1] == pytest.approx(power, rel=1e-3)
        assert row[2] + row[3] == pytest.approx(
            100 * answers["friction_work"] / answers["input_work"], rel=1e-3
        )
        assert sum(row[2:5]) == pytest.approx(100, abs=0.1)
        stored = answers["input_work"] / (4 * np.pi * answers["damping_ratio"])
        assert stored == pytest.approx(answers["stored_energy"])
        assert row[5] == pytest.approx(100 * answers["damping_ratio"], rel=1e-3)


def test_slip_is_bounded_by_friction_s_work(page, ran, results):
    """Work ≤ √2 μ ∮ n ds, so slip lies above work / (√2 μ n_max)."""
    head, rows = on_page(page, "Joints of one sector at the peak")
    assert head[5:7] == ["slip µm/cycle", "slip m/h"]
    for name, words in CASES.items():
        case, answers = results[name]
        mu, hertz = case["mu"], case["peak_frequency"]
        contacts = written(ran.folder / "figures" / f"wear_{slug(name)}.csv")
        slipping = [row for row in contacts if row["energy (µJ/cycle)"] > 0]
        assert len(slipping) > 5
        assert all("interlock" in row["contact"] for row in slipping)
        for row in slipping:
            energy, slip = row["energy (µJ/cycle)"], row["slip (µm/cycle)"]
            assert energy / (2**0.5 * mu * row["largest load (N)"]) <= 1.01 * slip
            assert row["slip (m/h)"] == pytest.approx(1e-6 * slip * hertz * 3600, rel=1e-3)
        top = max(row["slip (µm/cycle)"] for row in contacts)
        assert top == pytest.approx(1e6 * answers["largest_slip"], rel=1e-4)
        (line,) = [row for row in rows if row[0] == words and row[1] == "interlock"]
        assert line[5] == pytest.approx(max(row["slip (µm/cycle)"] for row in slipping), rel=1e-3)
        assert line[6] == pytest.approx(max(row["slip (m/h)"] for row in slipping), rel=1e-3)
        energy = sum(row["energy (µJ/cycle)"] for row in slipping)
        assert line[3] == pytest.approx(energy, rel=1e-3)
        assert energy == pytest.approx(1e6 * answers["friction_work"], rel=1e-4)


def test_worn_volume_is_by_archard(golden):
    """Volume is k ∮ n ds; work lies between μ and √2 μ of that; depth is volume over area."""
    ran = golden("everything")
    with h5py.File(ran.folder / "results.h5") as file:
        hertz = file["response/nominal"].attrs["peak_frequency"]
        mu = file["response/nominal"].attrs["mu"]
    rows = [
        row
        for row in written(ran.folder / "figures" / "wear_nominal.csv")
        if "interlock" in row["contact"] and row["energy (µJ/cycle)"] > 0
    ]
    assert rows
    for row in rows:
        energy, worn = row["energy (µJ/cycle)"], row["worn volume (mm^3/h)"]
        load = worn / (1e9 * 1e-13 * 3600 * hertz)  # ∮ n ds, J
        assert mu * load <= 1.01e-6 * energy <= 1.03 * 2**0.5 * mu * load
        assert load <= 1.01e-6 * row["slip (µm/cycle)"] * row["largest load (N)"]
        depth = worn / row["area (mm^2)"] * 1e3
        assert row["worn depth (µm/h)"] == pytest.approx(depth, rel=1e-4)


def test_rotor_speeds_are_frequencies_over_the_engine_order(golden):
    ran = golden("everything")
    with h5py.File(ran.folder / "results.h5") as file:
        (name,) = file["campbell"]
        peak = file["response/nominal"].attrs["peak_amplitude"]
    stem = f"campbell_{slug(name)}" if name != "nominal" else "campbell"
    crossings = written(ran.folder / "figures" / f"{stem}_crossings.csv")
    assert {row["engine order"] for row in crossings} == {1, 2}
    for row in crossings:
        speed = 60 * row["frequency (Hz)"] / row["engine order"]
        assert row["rotor speed (rpm)"] == pytest.approx(speed)
    circles = written(ran.folder / "figures" / f"{stem}_circles.csv")
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


def test_meshes_on_the_page_are_those_of_the_results(golden):
    folder = golden("default").folder
    head, rows = on_page(
        (folder / "report.html").read_text("utf-8"), "Finite-element meshes of one"
    )
    assert head[:5] == ["part", "nodes", "dofs", "elements", "type"]
    with h5py.File(folder / "results.h5") as file:
        for row in rows:
            part = mesh.Part.load(file["mesh"][row[0]])
            nodes = len(part.points)
            assert row[1:4] == [nodes, 3 * nodes, len(part.cells)]
            M = fem.assemble(replace(part, node_sets={}), STEEL).M  # none is held
            assert row[head.index("mass kg")] == pytest.approx(M.sum() / 3, rel=0.01)
    assert [row[0] for row in rows] == ["vane", "casing"]
