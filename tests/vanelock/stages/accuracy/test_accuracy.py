"""A run to an accuracy: the smallest study, against the same scene with more of everything."""

import json
import shutil

import pytest

from vanelock import load_system, open_results, parse_study
from vanelock.commands.converge.converge import converge_study
from vanelock.common.tables import Table
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Done
from vanelock.rom import System
from vanelock.stages.accuracy.budget import Budget
from vanelock.stages.accuracy.choose_mesh import Round
from vanelock.stages.accuracy.errors import Errors, Source
from vanelock.stages.accuracy.errors import _warnings as errors_of

pytestmark = pytest.mark.usefixtures("undrawn")

ACCURACY = 0.06  # less looks for resonances at nodal diameters further ahead, here at all


@pytest.fixture
def asked(golden):
    run = golden("accuracy")
    return run.folder, run.summaries, run.events, run.text


def tables(heard, key):
    return [event for event in heard if isinstance(event, Table) and event.key == key]


def tried_by(folder, case):
    """Harmonics kept by a case, or tried to judge them."""
    with open_results(folder / "results.h5") as file:
        return Response.load(file[f"response/{case}"]).estimates.tried


def test_the_errors_are_listed_by_source(asked):
    folder, cases, heard, _ = asked
    shown = tables(heard, "errors")
    assert len(shown) == len(cases) == 1
    for table in shown:
        rows = {row[0]: row for row in table.shown}
        assert list(rows) == ["mesh", "modes", "harmonics", "frequencies", "total"]
        counted = [rows[name] for name in ("modes", "harmonics", "frequencies")]
        assert sum(row[1] for row in counted) == pytest.approx(rows["total"][1])
        assert sum(row[3] for row in counted) == pytest.approx(ACCURACY)
        assert rows["total"][1] < ACCURACY
        assert rows["mesh"][3] is None
        assert "mesh.size is given" in rows["mesh"][5]
        # Five per cent too stiff, of which a quarter of what is taken off remains in doubt.
        assert 0.01 < rows["mesh"][2] < ACCURACY
        assert rows["mesh"][2] < rows["mesh"][1] < 4 * rows["mesh"][2]
    with open_results(folder / "results.h5") as file:
        response = Response.load(file["response/nominal"])
    assert response.estimates is not None
    assert response.error.shape == (response.points,)
    assert response.estimates.harmonics.max() == response.harmonics


def test_only_nodal_diameters_in_use_are_reduced_and_kept(asked):
    folder, cases, heard, _ = asked
    tried = {case.case: tried_by(folder, case.case) for case in cases}
    assert all(0 <= tried[case.case] - case.harmonics <= 2 for case in cases)
    H = max(tried.values())
    reduced = {
        e.stage for e in heard if isinstance(e, Done) and e.stage.startswith("rom casing, ND")
    }
    assert reduced == {f"rom casing, ND {k}" for k in range(min(H, 8) + 1)}
    for case in cases:
        system = load_system(folder / "results.h5", case.case)
        assert sorted(system.diameters) == list(range(min(tried[case.case], 8) + 1))
    with open_results(folder / "results.h5") as file:
        assert {"vane", "casing", "casing_nd0"} <= set(file["rom"])
        System.load(file["system"])


def test_what_was_left_out_is_listed_with_its_evidence(asked):
    folder, cases, heard, _ = asked
    for case, table in zip(cases, tables(heard, "left_out"), strict=True):
        found = {(kind, what): evidence for kind, what, evidence in table.rows}
        joint = next(e for (kind, what), e in found.items() if kind == "joints")
        assert "stuck at every point" in joint
        diameters = next((k, e) for k, e in found.items() if k[0] == "nodal diameters")
        first = tried_by(folder, case.case) + 1
        assert diameters[0][1] == (f"{first} to 8" if first < 8 else "8")
        shares = [float(e.split()[1]) for (kind, _), e in found.items() if kind == "parts"]
        assert sum(shares) == pytest.approx(100, abs=2)
        assert any(kind == "harmonics" for kind, _ in found)


def test_converging_holds_the_settings_at_what_was_chosen(asked, tmp_path):
    folder, (case,), _, text = asked
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    found = converge_study(parse_study(text), tmp_path, only=("response.coupling",))
    assert [o.value for o in found if o.own] == ["coupled"]
    (own,) = [o for o in found if o.own]
    assert own.amplitude == pytest.approx(case.peak.amplitude, rel=ACCURACY)
    assert json.loads((tmp_path / "converge.json").read_text())


def test_a_mesh_that_is_given_and_off_by_more_is_reported():
    nan = float("nan")
    known = Errors(0.01, (Source("mesh", 0.03, 0.02, nan, 0.5, "coarse"),), (), nan)
    given = Budget(0.01, {}, {"mesh": "mesh.size"})
    for frequency, amplitude, lines in ((0.02, 0.001, 1), (0.001, 0.02, 1), (0.009, 0.009, 0)):
        coarse = Round("coarse", (25_000, 8_000), frequency, amplitude)
        warned = errors_of(known, given, [coarse], "")
        assert len(warned) == lines
    (line,) = errors_of(known, given, [Round("", (1, 1), 0.02, 0.03)], "")
    assert "frequencies are off by about 2.0e-02, the peak by about 3.0e-02" in line
    assert "holds for this mesh alone" in line
