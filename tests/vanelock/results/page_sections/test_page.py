"""The page of a run, its answers, and two runs compared: on the real scene, coarsely."""

import csv
import json
import re
import shutil

import h5py
import numpy as np
import pytest

from tests.vanelock.results.one_file import in_one_file
from vanelock import compare_runs, nonlinear, parse_study, run_study
from vanelock.common.errors import InputError
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Done, Event, Notice
from vanelock.quantities.sensitivities import Sensitivities
from vanelock.rom import System

STUDY = """
name = "page <of> a run"
[mesh]
size = "coarse"
[joints.interlock]
wear_coefficient = 2e-15
[response]
frequencies = [246, 250, 253, 256, 260, 264, 269, 275]
harmonics = 2
[outputs]
shapes = false
loops = false
animations = false
gauges = [{ aerofoil = 2, span = 0.1, chord = 0.5 }]
"""


def run(folder, text=STUDY):
    heard: list[Event] = []
    run_study(parse_study(text), folder, heard.append, text)
    return heard


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("page")
    run(where)
    return where


def table(path):
    """Columns of a CSV file, its notes left out."""
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


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


def test_governing_margin_is_the_smallest_of_the_nodes_that_count(folder):
    with h5py.File(folder / "results.h5") as file:
        answers = dict(file["response/nominal/answers"].attrs)
    nodes = table(folder / "figures" / "fatigue_nominal.csv")
    n = [float(row["n"]) for row in nodes if row["clear"] == "1"]
    assert answers["goodman_reserve"] == pytest.approx(min(n), rel=1e-4)
    row = min(nodes, key=lambda r: float(r["n"]) if r["clear"] == "1" else np.inf)
    used = float(row["amplitude (MPa)"]) / 250 + max(float(row["mean (MPa)"]), 0) / 900
    assert 1 / used == pytest.approx(min(n), rel=1e-4)
    assert answers["place"].startswith(row["feature"])


def test_gauge_is_stressed_as_its_strain_says(folder):
    """Along the span near a root the stress is uniaxial but for a few per cent: E times strain."""
    with h5py.File(folder / "results.h5") as file:
        group = file["response/nominal"]
        (stress,) = group["answers"].attrs["gauge_alternating_stress"]
        point = int(np.flatnonzero(group["frequency"][()] == group.attrs["peak_frequency"])[0])
        harmonics = group["gauge"][point, :, 0]
    angle = np.linspace(0, 2 * np.pi, 2001)
    strain = (np.exp(1j * np.outer(angle, [1, 2])) @ harmonics[1:]).real
    assert stress == pytest.approx(170e9 * np.abs(strain).max(), rel=0.06)


def test_contacts_dissipate_what_the_response_says_and_wear_by_archard(folder):
    with h5py.File(folder / "results.h5") as file:
        answers = dict(file["response/nominal/answers"].attrs)
    rows = [
        r for r in table(folder / "figures" / "wear_nominal.csv") if "interlock" in r["contact"]
    ]
    energy = [float(row["energy (µJ/cycle)"]) for row in rows]
    assert sum(energy) == pytest.approx(1e6 * answers["friction_work"], rel=1e-5)
    for row in rows:
        depth = float(row["worn volume (mm^3/h)"]) / float(row["area (mm^2)"]) * 1e3
        assert float(row["worn depth (µm/h)"]) == pytest.approx(depth, rel=1e-4)


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


def test_page_holds_the_answers_and_every_section(folder):
    page = (folder / "report.html").read_text("utf-8")
    assert "page &lt;of&gt; a run" in page
    for title in (
        "Summary",
        "Inputs",
        "Gauges and hysteresis",
        "Fatigue",
        "Energy and damping",
        "Wear of the joints",
        "Figures",
        "Convergence and errors",
        "Model",
        "Provenance",
        "All settings",
    ):
        assert re.search(rf"<h2[^>]*>\s*{title}", page), title
    with h5py.File(folder / "results.h5") as file:
        peak = file["response/nominal"].attrs["peak_amplitude"]
    assert f"{1e6 * peak:.3g} µm" in page
    assert "not material data" in page


def test_page_is_written_again_only_when_it_shows_something_else(folder):
    before = (folder / "report.html").stat().st_mtime_ns
    heard = run(folder)
    assert not [e for e in heard if isinstance(e, Done) and not e.cached]
    assert (folder / "report.html").stat().st_mtime_ns == before
    stronger = STUDY + "[material.vane]\nfatigue_limit = 300e6\n"
    heard = run(folder, stronger)
    drawn = {e.stage for e in heard if isinstance(e, Done) and not e.cached}
    assert "report.html" in drawn
    assert not any(name.startswith(("response", "stress", "rom")) for name in drawn)
    run(folder, STUDY.replace("[outputs]", "[outputs]\nreport = false"))
    assert not (folder / "report.html").exists()
    run(folder)


def test_two_runs_are_compared(folder, tmp_path, monkeypatch):
    other = tmp_path / "other"
    shutil.copytree(folder, other)
    with in_one_file(other / "results.h5") as file:
        settings = json.loads(file["provenance"].attrs["settings"])
        settings["joints"]["interlock"]["mu"] = 0.4
        file["provenance"].attrs["settings"] = json.dumps(settings)
        case = file["response/nominal"]
        case.attrs["peak_amplitude"] *= 1.5
        case["amplitude"][...] *= 1.5
        file.attrs["complete"] = False
    monkeypatch.chdir(tmp_path)
    heard: list[Event] = []
    found = compare_runs(folder, other, listener=heard.append)
    assert found.inputs == [("joints.interlock.mu", "0.3", "0.4")]
    peak = found.results[0]
    assert peak.what == "peak"
    assert peak.change == pytest.approx(0.5)
    assert any(isinstance(e, Notice) and "not complete" in e.text for e in heard)
    where = tmp_path / f"compare_{folder.name}_other"
    rows = table(where / "compare.csv")
    peak_row = next(row for row in rows if row["what"] == "peak")
    assert float(peak_row["relative difference"]) == pytest.approx(0.5)
    curve = found.pairs[0].other.amplitude / found.pairs[0].one.amplitude
    assert curve == pytest.approx(1.5)
    assert "joints.interlock.mu" in (where / "compare.html").read_text("utf-8")


def test_comparison_stays_out_of_the_runs(folder, tmp_path):
    shutil.copytree(folder, tmp_path / "other")
    with pytest.raises(InputError, match=r"--output .*page.*: lies in the run's folder"):
        compare_runs(folder, tmp_path / "other", folder / "page")
    with pytest.raises(InputError, match="the same folder as"):
        compare_runs(folder, folder, tmp_path / "page")
