"""Two cases at engine order 2: page, terminal and CSV say of each what the results hold of it."""

import csv
import html
import pickle
import re
from dataclasses import replace

import h5py
import numpy as np
import pytest

from vanelock import parse_study, run_study
from vanelock.commands.run.cases import OngoingRun
from vanelock.common.tables import Table
from vanelock.pipeline.progress import Event

STUDY = """
name = "two cases"
[mesh]
size = "coarse"
[excitation]
engine_order = 2
[joints.interlock]
wear_coefficient = 2e-15
[response]
frequencies = [248, 254, 260, 266]
harmonics = 2
[sweep]
"joints.interlock.mu" = [0.3, 0.03]
[campbell]
engine_orders = [2]
[outputs]
shapes = false
loops = false
animations = false
"""
CASES = {"mu=0.3": "μ = 0.3", "mu=0.03": "μ = 0.03"}
LIMIT, STRENGTH = 250.0, 900.0  # MPa, the defaults


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """The run's folder, the tables that it printed, and what it kept for its pictures."""
    folder = tmp_path_factory.mktemp("cases")
    heard: list[Event] = []
    kept = []

    class Kept(OngoingRun):
        def all_cases(self):
            kept.append(self)
            return super().all_cases()

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("vanelock.commands.run.study.OngoingRun", Kept)
        run_study(parse_study(STUDY), folder, heard.append, STUDY)
    return folder, [event for event in heard if isinstance(event, Table)], kept[0].shown


def test_a_run_keeps_no_product_of_a_case(ran):
    """Each is some 20 to 5,000 kB, and a sweep may have 100,000 cases."""
    shown = replace(ran[2], linear={}, campbell={})
    assert len(pickle.dumps(shown)) < 1500 * len(CASES)


@pytest.fixture(scope="module")
def results(ran):
    """By case: its attributes, those of its answers, and its arrays."""
    found = {}
    with h5py.File(ran[0] / "results.h5") as file:
        for name in CASES:
            group = file["response"][name]
            arrays = {
                key: item[()] for key, item in group.items() if isinstance(item, h5py.Dataset)
            }
            arrays["wear coefficient"] = 2e-15
            found[name] = dict(group.attrs), dict(group["answers"].attrs), arrays
    return found


@pytest.fixture(scope="module")
def page(ran):
    return (ran[0] / "report.html").read_text("utf-8")


def plain(text):
    text = html.unescape(re.sub(r"<[^>]*>", " ", text))
    return text.replace("\xa0", " ").replace("−", "-").strip()


def number(cell):
    return float(cell.replace(",", "")) if re.fullmatch(r"-?[\d.,e+-]+", cell) else cell


def on_page(page, title):
    """Header cells, with their units, and rows of a table."""
    start = page.index(html.escape(title).replace("&#x27;", "&#39;"))
    whole = page[start : page.index("</table>", start)]
    head = [plain(cell) for cell in re.findall(r"<th[^>]*>(.*?)</th>", whole)]
    rows = [
        [number(plain(cell)) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        for row in re.findall(r"<tr>(.*?)</tr>", whole)
    ]
    return [" ".join(cell.split()) for cell in head], [row for row in rows if row]


def card(page, label):
    """Value and note of an answer."""
    found = re.search(
        rf'<div class="label">{label}</div>\s*<div class="value">(.*?)</div>(.*?)</li>', page, re.S
    )
    assert found is not None
    return plain(found[1]), plain(found[2])


def written(path):
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    return [{k: number(v) for k, v in row.items()} for row in csv.DictReader(lines)]


def position(row):
    return [row[f"{axis} (mm)"] for axis in "xyz"]


def largest(results):
    """The case of the largest peak: here not the first one, nor the first by name."""
    found = max(results, key=lambda name: results[name][0]["peak_amplitude"])
    assert found == "mu=0.03"
    return found


def test_each_line_of_the_summary_is_that_case_s(page, results):
    head, rows = on_page(page, "All cases at their largest")
    assert head[1:] == [
        "peak µm",
        "at Hz",
        "relative to free",
        "relative to stuck",
        "damping ratio %",
        "dissipated µJ",
        "slip %",
        "open %",
        "vibratory stress MPa",
        "HCF safety factor",
    ]
    assert [row[0] for row in rows] == list(CASES.values())
    for row, (case, answers, _) in zip(rows, results.values(), strict=True):
        assert row[1] == pytest.approx(1e6 * case["peak_amplitude"], rel=1e-3)
        assert row[2] == pytest.approx(case["peak_frequency"], rel=1e-3)
        assert row[3] == pytest.approx(case["of_free"], rel=1e-3)
        assert row[4] == pytest.approx(case["of_stuck"], rel=1e-3)
        assert row[5] == pytest.approx(100 * answers["damping_ratio"], rel=1e-3)
        assert row[6] == pytest.approx(1e6 * answers["friction_work"], rel=1e-3)
        assert row[7] == pytest.approx(100 * case["slipping"], rel=1e-3)
        assert row[8] == pytest.approx(100 * case["opening"], rel=1e-3)
        assert row[9] == pytest.approx(1e-6 * answers["alternating_stress"], rel=1e-3)
        assert row[10] == pytest.approx(answers["goodman_reserve"], rel=1e-3)
    assert rows[0][9] != pytest.approx(rows[1][9], rel=0.02)  # or one could stand for the other


def test_the_answers_are_those_of_the_largest_peak(page, results):
    name = largest(results)
    case, answers, _ = results[name]
    value, note = card(page, "Largest peak")
    assert float(value.split()[0]) == pytest.approx(1e6 * case["peak_amplitude"], rel=5e-3)
    assert note.startswith(CASES[name])
    value, note = card(page, "Frequency")
    assert float(value.split()[0]) == pytest.approx(case["peak_frequency"], abs=0.006)
    rpm = float(note.partition(" rpm")[0].split()[-1].replace(",", ""))
    assert rpm == pytest.approx(60 * case["peak_frequency"] / 2, abs=0.6)
    assert "rpm at engine order 2" in note
    assert float(card(page, "Critical stress")[0].split()[0]) == pytest.approx(
        1e-6 * answers["alternating_stress"], rel=5e-3
    )
    assert float(card(page, "HCF safety factor")[0].split()[-1]) == pytest.approx(
        answers["goodman_reserve"], rel=5e-3
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
    nodes = written(ran[0] / "figures" / f"fatigue_{name.replace('=', '')}.csv")
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
    _, rows = on_page(page, "The vane's critical location in each case")
    by_case = {row[0].split(":")[0]: row for row in rows}
    for name, words in CASES.items():
        answers = results[name][1]
        assert by_case[words][2] == pytest.approx(1e-6 * answers["alternating_stress"], rel=1e-3)
        assert by_case[words][4] == pytest.approx(answers["goodman_reserve"], rel=1e-3)


def test_energy_and_damping_of_each_case(page, results):
    head, rows = on_page(page, "Power of one sector at the peak of each case")
    assert head[1] == "power mW"
    for row, (case, answers, _) in zip(rows, results.values(), strict=True):
        power = 1e3 * answers["input_work"] * case["peak_frequency"]
        assert row[1] == pytest.approx(power, rel=1e-3)
        assert row[2] + row[3] == pytest.approx(
            100 * answers["friction_work"] / answers["input_work"], rel=1e-3
        )
        assert sum(row[2:5]) == pytest.approx(100, abs=0.1)
        assert row[5] == pytest.approx(100 * answers["damping_ratio"], rel=1e-3)


def test_wear_is_friction_s_work_over_friction_s_force(page, ran, results):
    """Work ≤ √2 μ ∮ n ds, so slip lies above work / (√2 μ n_max); volume is k ∮ n ds."""
    head, rows = on_page(page, "Joints of one sector at the peak")
    assert head[5:7] == ["slip µm/cycle", "slip m/h"]
    for name, words in CASES.items():
        case, answers, _ = results[name]
        mu, hertz = float(name.split("=")[1]), case["peak_frequency"]
        contacts = written(ran[0] / "figures" / f"wear_{name.replace('=', '')}.csv")
        slipping = [
            row
            for row in contacts
            if "interlock" in row["contact"] and row["energy (µJ/cycle)"] > 0
        ]
        assert slipping
        for row in slipping:
            energy, slip = row["energy (µJ/cycle)"], row["slip (µm/cycle)"]
            assert energy / (2**0.5 * mu * row["largest load (N)"]) <= 1.01 * slip
            assert row["slip (m/h)"] == pytest.approx(1e-6 * slip * hertz * 3600, rel=1e-3)
            worn = row["worn volume (mm^3/h)"]
            load = worn / (1e9 * 2e-15 * 3600 * hertz)  # ∮ n ds, J
            assert mu * load <= 1.01e-6 * energy <= 1.03 * 2**0.5 * mu * load
            assert load <= 1.01e-6 * slip * row["largest load (N)"]
        top = max(row["slip (µm/cycle)"] for row in contacts if row["slip (µm/cycle)"] != "")
        assert top == pytest.approx(1e6 * answers["largest_slip"], rel=1e-4)
        (line,) = [row for row in rows if row[0] == words and row[1] == "interlock"]
        assert line[5] == pytest.approx(max(row["slip (µm/cycle)"] for row in slipping), rel=1e-3)
        assert line[6] == pytest.approx(max(row["slip (m/h)"] for row in slipping), rel=1e-3)
        assert line[3] == pytest.approx(sum(row["energy (µJ/cycle)"] for row in slipping), rel=1e-3)


def test_rotor_speeds_are_frequencies_over_the_engine_order(ran, results):
    folder, tables, _ = ran
    with h5py.File(folder / "results.h5") as file:
        (name,) = file["campbell"]
    stem = f"campbell_{name.replace('=', '')}"
    for row in written(folder / "figures" / f"{stem}_crossings.csv"):
        assert row["rotor speed (rpm)"] == pytest.approx(60 * row["frequency (Hz)"] / 2)
    circles = written(folder / "figures" / f"{stem}_circles.csv")
    for row in circles:
        assert row["rotor speed (rpm)"] == pytest.approx(60 * row["frequency (Hz)"] / 2)
    own = [row["amplitude (µm)"] for row in circles if row["nonlinear"] == 1]
    assert max(own) == pytest.approx(1e6 * results[name][0]["peak_amplitude"], rel=1e-6)
    (crossings,) = [table for table in tables if table.key == "crossings"]
    for row in crossings.record()["rows"]:
        assert row["speed_rpm"] == pytest.approx(60 * row["frequency_hz"] / 2)


def test_the_curves_as_csv_are_the_responses(ran, results):
    rows = written(ran[0] / "figures" / "response.csv")
    for name, words in CASES.items():
        attributes, _, arrays = results[name]
        own = [row for row in rows if row["case"] == name]
        assert {row["curve"].partition(", H")[0] for row in own} == {words}
        assert {row["converged"] for row in own} == {1}
        frequency, amplitude = (
            [row[k] for row in own] for k in ("frequency (Hz)", "amplitude (µm)")
        )
        np.testing.assert_allclose(frequency, arrays["frequency"])
        assert max(amplitude) == pytest.approx(1e6 * attributes["peak_amplitude"], rel=1e-6)
        assert frequency[int(np.argmax(amplitude))] == attributes["peak_frequency"]


def test_the_terminal_s_table_is_of_each_case(ran, results):
    (table,) = [each for each in ran[1] if each.key == "cases"]
    rows = table.record()["rows"]
    for row, (name, (case, _, _)) in zip(rows, results.items(), strict=True):
        assert row["case"] == name
        assert row["mu"] == float(name.split("=")[1])
        assert row["peak_um"] == pytest.approx(1e6 * case["peak_amplitude"])
        assert row["frequency_hz"] == pytest.approx(case["peak_frequency"])
        assert row["of_free"] == pytest.approx(case["of_free"])
        assert row["of_stuck"] == pytest.approx(case["of_stuck"])
        assert row["slipping_percent"] == pytest.approx(100 * case["slipping"])
        assert row["opening_percent"] == pytest.approx(100 * case["opening"])
