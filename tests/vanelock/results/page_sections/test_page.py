"""Pages of golden runs: their answers, inputs and warnings, and two runs compared."""

import json
import re
import shutil

import h5py
import numpy as np
import pytest

from tests.small_study import SMALL
from tests.vanelock.results.one_file import card, in_one_file, on_page, plain
from vanelock import compare_runs, nonlinear, parse_study, run_study
from vanelock.commands.compare import compared
from vanelock.commands.stored.contents import load_run
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Done, Event, Notice
from vanelock.quantities.sensitivities import Sensitivities
from vanelock.results.page_sections.inputs import inputs
from vanelock.rom import System

pytestmark = pytest.mark.usefixtures("undrawn")


def run(folder, text):
    heard: list[Event] = []
    run_study(parse_study(text), folder, heard.append, text)
    return heard


@pytest.fixture(scope="module")
def folder(golden):
    return golden("default").folder


def test_answers_are_what_an_independent_check_of_the_peak_finds(folder):
    with h5py.File(folder / "results.h5") as file:
        response = Response.load(file["response/nominal"])
        system = System.load(file["response/nominal/system"])
        monitor = file["response/nominal"].attrs["peak_frequency"]
        answers = dict(file["response/nominal/answers"].attrs)
    point = int(np.flatnonzero(response.frequency == monitor)[0])
    audit = nonlinear.audit_response(system, response, [point])
    period = 1 / response.frequency[point]
    assert answers["input_work"] == pytest.approx(audit.excitation_power[0] * period)
    assert answers["friction_work"] == pytest.approx(audit.friction_power.sum() * period)
    ratio = answers["input_work"] / (4 * np.pi * answers["stored_energy"])
    assert answers["damping_ratio"] == pytest.approx(ratio)
    assert answers["damping_ratio"] > 0.003  # of the structure alone


def test_gauge_is_stressed_as_its_strain_says(golden):
    """Along the span near a root the stress is uniaxial but for a few per cent: E times strain."""
    with h5py.File(golden("accuracy").folder / "results.h5") as file:
        group = file["response/nominal"]
        (stress,) = group["answers"].attrs["gauge_alternating_stress"]
        point = int(np.flatnonzero(group["frequency"][()] == group.attrs["peak_frequency"])[0])
        harmonics = group["gauge"][point, :, 0]
    angle = np.linspace(0, 2 * np.pi, 2001)
    orders = np.arange(1, len(harmonics))
    strain = (np.exp(1j * np.outer(angle, orders)) @ harmonics[1:]).real
    assert stress == pytest.approx(170e9 * np.abs(strain).max(), rel=0.06)


def test_what_moves_the_peak_obeys_dimensional_analysis(folder):
    """Moduli and springs with the load raise the square of the frequency in proportion."""
    with h5py.File(folder / "results.h5") as file:
        found = Sensitivities.load(file["response/nominal/sensitivities"])
    assert not found.reason
    amplitude = dict(zip(found.keys, found.amplitude, strict=True))
    frequency = dict(zip(found.keys, found.frequency, strict=True))
    interference = [key for key in found.keys if key.endswith("interference")]
    displaces = ["excitation", *interference]
    resists = ["excitation", *(k for k in found.keys if k.endswith((".E", ".kn", ".kt")))]
    assert len(resists) == 7
    assert sum(amplitude[key] for key in displaces) == pytest.approx(1, abs=1e-6)
    assert sum(amplitude[key] for key in resists) == pytest.approx(0, abs=1e-6)
    assert sum(frequency[key] for key in resists) == pytest.approx(0.5, abs=1e-4)


SECTIONS = [
    "Summary",
    "Inputs",
    "What moves the peak",
    "Energy, damping and wear indicators",
    "Fatigue",
    "Figures",
    "Convergence and errors",
    "Model",
    "Provenance",
    "All settings",
]


@pytest.mark.parametrize(
    ("name", "more"), [("default", ["Hysteresis"]), ("accuracy", ["Hysteresis", "Strain gauges"])]
)
def test_page_holds_the_answers_and_every_section(golden, name, more):
    folder = golden(name).folder
    page = (folder / "report.html").read_text("utf-8")
    found = [each.strip() for each in re.findall(r"<h2[^>]*>(.*?)</h2>", page, re.S)]
    assert [each for each in found if each in {*SECTIONS, *more}] == sorted(
        [*SECTIONS, *more], key=found.index
    )
    assert {*SECTIONS, *more} <= {*found}
    with h5py.File(folder / "results.h5") as file:
        peak = file["response/nominal"].attrs["peak_amplitude"]
    assert f"{1e6 * peak:.3g} µm" in page
    assert "not material data" in page


def test_files_are_written_again_only_when_they_show_something_else(golden, tmp_path):
    known = golden("default")
    folder = tmp_path / "default"
    shutil.copytree(known.folder, folder)
    drawn = [path for path in folder.rglob("*.*") if path.parent.name in ("figures", "shapes")]
    before = {path: path.stat().st_mtime_ns for path in [*drawn, folder / "report.html"]}
    assert len(before) > 20
    heard = run(folder, known.text)
    assert not [e for e in heard if isinstance(e, Done) and not e.cached]
    assert {path: path.stat().st_mtime_ns for path in before} == before
    few = "[material.vane]\nfatigue_limit = 300e6\n[outputs]\nshow = ['report']\n"
    heard = run(folder, known.text + few)
    drawn_again = {e.stage for e in heard if isinstance(e, Done) and not e.cached}
    assert drawn_again == {"figures/haigh_nominal.png", "report.html"}
    nodes = (folder / "figures" / "fatigue_nominal.csv").read_text("utf-8")
    assert "fatigue limit 300 MPa, tensile strength 900 MPa" in nodes
    run(folder, known.text + few.replace("['report']", "[]"))
    assert not (folder / "report.html").exists()
    left = {path.name for path in (folder / "figures").iterdir()}
    assert left == {"response.png", "response.csv", "preload.png", "preload.csv"}


DOUBTFUL = f"""{SMALL}mesh.correction = "none"
response = {{ frequencies = [266, 268], harmonics = 1 }}
outputs = {{ show = ["report"] }}
sweep."joints.hook.mu" = [0.3, 0.4]
"""


def test_what_is_doubtful_is_said_and_withheld(tmp_path):
    """The peak lies lower, and friction works at the interlock alone."""
    heard = run(tmp_path, DOUBTFUL)
    edge = "the largest point is at the end of the frequency range; a peak may lie beyond"
    same = "joints.hook.mu has no effect: cases that differ in it alone are the same"
    (table,) = [each for each in heard if isinstance(each, Table) and each.key == "cases"]
    page = (tmp_path / "report.html").read_text("utf-8")
    assert f"warning: all cases: {edge}." in table.notes
    assert f"warning: {same}" in table.notes
    assert edge in page
    assert same in page
    assert page.count(">withheld<") == 2  # safety factor and optimum friction
    with h5py.File(tmp_path / "results.h5") as file:
        warned = [list(file[f"response/{case}"].attrs["warnings"]) for case in ("mu=0.3", "mu=0.4")]
    assert [lines[0] for lines in warned] == [edge, edge]


def test_two_runs_are_compared(folder, tmp_path, monkeypatch):
    other = tmp_path / "other"
    shutil.copytree(folder, other)
    with in_one_file(other / "results.h5") as file:
        settings = json.loads(file["provenance"].attrs["settings"])
        settings["joints"]["interlock"]["mu"] = 0.4
        file["provenance"].attrs["settings"] = json.dumps(settings)
        case = file["response/nominal"]
        about = json.loads(case["about"][()])
        about["summary"]["peak"]["amplitude"] *= 1.5
        case["about"][...] = json.dumps(about)
        case["curves/curve/0"][1] *= 1.5
        file.attrs["complete"] = False
    monkeypatch.chdir(tmp_path)
    heard: list[Event] = []
    inputs, results = compare_runs(folder, other, listener=heard.append)
    assert inputs.rows == [("joints.interlock.mu", "0.3", "0.4")]
    peak = next(row for row in results.rows if row[1] == "peak")
    assert peak[-1] == "+50 %"
    assert any(isinstance(e, Notice) and "not complete" in e.text for e in heard)
    runs = load_run(folder), load_run(other)
    one, two = compared(*runs)[-1].traces
    assert two.y / one.y == pytest.approx(1.5)
    where = tmp_path / f"compare_{folder.name}_other"
    assert "joints.interlock.mu" in (where / "compare.html").read_text("utf-8")


def test_comparison_stays_out_of_the_runs(folder, golden, tmp_path):
    with pytest.raises(InputError, match=r"--output .*page.*: lies in the run's folder"):
        compare_runs(folder, golden("sweep").folder, folder / "page")
    with pytest.raises(InputError, match="the same folder as"):
        compare_runs(folder, folder, tmp_path / "page")


HOT = 'temperature.vane = 605\nmaterial.vane.E = [[20, "200 GPa"], [620, "155 GPa"]]\n'
GROWN = (
    "temperature.casing = 600\nmaterial.casing.expansion = 1e-5\nmaterial.vane.expansion = 1.3e-5\n"
)


@pytest.mark.parametrize(
    ("text", "words"),
    [(HOT, "modulus alone: thermal expansion"), (HOT + GROWN, "growth of the vane against")],
)
def test_thermal_expansion_is_left_out_where_none_is_given(text, words):
    study = parse_study(text)
    said = str(inputs(study, [study]).blocks[-1])
    assert "Temperature acts" in said
    assert words in said


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
    with h5py.File(ran.folder / "results.h5") as file:
        groups = {name: file["response"][name] for name in CASES}
        return {n: (dict(each.attrs), dict(each["answers"].attrs)) for n, each in groups.items()}


@pytest.fixture(scope="module")
def page(ran):
    return (ran.folder / "report.html").read_text("utf-8")


def test_the_answers_are_those_of_the_largest_peak(page, results):
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


def test_each_case_is_swept_in_both_directions(ran):
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
