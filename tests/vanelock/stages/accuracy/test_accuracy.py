"""A run to an accuracy: the smallest study; what is settled before its response."""

import json
import shutil
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vanelock import load_system, open_results, parse_study
from vanelock.commands.converge.converge import converge_study
from vanelock.common import process
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.mesh.element_size import element_size
from vanelock.mesh.refinement import casing_dofs, vane_dofs
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Done, silent
from vanelock.pipeline.step import Stages
from vanelock.rom import System
from vanelock.stages.accuracy import choose_mesh, mesh_sizes
from vanelock.stages.accuracy.budget import Budget, budget
from vanelock.stages.accuracy.choose_mesh import Round
from vanelock.stages.accuracy.errors import Errors, Source, _listed_harmonics, error_table
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
    assert [o.value for o in found if o.chosen] == ["coupled"]
    (own,) = [o for o in found if o.chosen]
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


def test_numbers_in_words():
    assert _listed_harmonics([0, 1, 4, 5, 6, 8]) == "0, 1, 4 to 6, 8"
    assert _listed_harmonics([]) == ""


def test_the_sum_is_good_only_where_each_part_is_known():
    nan = float("nan")

    def last(modes, harmonics, source="frequencies"):
        numbers = (("modes", *modes), ("harmonics", *harmonics), (source, 1e-4, 1e-4))
        sources = tuple(Source(name, a, f, 0.005, 0.2, "") for name, a, f in numbers)
        return error_table("nominal", Errors(0.01, sources, (), 250.0), "x").flags[-1]

    assert last((1e-3, 1e-3), (1e-3, 1e-3)) == "good"
    assert last((nan, 1e-3), (1e-3, 1e-3)) == "warn"
    assert last((1e-3, 1e-3), (1e-3, nan)) == "warn"
    assert last((1e-3, nan), (1e-3, nan), "samples") == "good"  # frequencies that are listed
    assert last((1e-3, 0.02), (1e-3, 1e-3)) == "warn"


FREE = "accuracy = 0.05"
RATIO = 1.7
"""Error of the peak's amplitude over that of its frequency."""
NOTHING: Any = None
NOWHERE = Stages(NOTHING, silent)
"""Stages that nothing is asked of."""


def choice_of(text):
    return choose_mesh.choose_mesh(parse_study(text), NOWHERE)


def estimating(monkeypatch, error_of, dofs=lambda size: 27_000 * (0.025 / size) ** 2):
    """Let errors follow from element sizes alone; returns the studies that were asked about."""
    asked = []

    def tried(study, stages):
        asked.append(study)
        size = element_size(study.mesh.size, "vane")
        error = error_of(size)
        if isinstance(error, Exception):
            raise error
        share = np.array([3e-4])
        limits = SimpleNamespace(free_error=share, stuck_error=share, free_mode=0, stuck_mode=0)
        each = int(dofs(size)), int(dofs(element_size(study.mesh.size, "casing")))
        found = choose_mesh.Round(f"{size:g}", each, error, RATIO * error)
        return found, limits

    monkeypatch.setattr(choose_mesh, "_tried", tried)
    return asked


def test_the_first_mesh_within_its_share_is_taken(monkeypatch):
    asked = estimating(monkeypatch, lambda size: 0.02 * (size / 0.03) ** 1.0)
    found = choice_of(FREE)
    share, most = budget(parse_study(FREE)).shares["mesh"], budget(parse_study(FREE)).bearable
    amplitudes = [each.amplitude for each in found.rounds]
    assert [each <= most for each in amplitudes] == [False] * (len(asked) - 1) + [True]
    assert asked[0].mesh.size == "coarse"
    assert len(asked) <= 3
    assert amplitudes[-1] > 0.6 * share  # and not much finer than that
    # What the mesh leaves is shared anew.
    assert found.budget.shares["mesh"] == amplitudes[-1]
    assert sum(found.budget.shares.values()) == pytest.approx(0.05)
    assert found.short == ""
    assert found.study.mesh.size == asked[-1].mesh.size


def test_an_error_a_little_beyond_its_share_is_not_worth_another_mesh(monkeypatch):
    shares = budget(parse_study(FREE))
    assert shares.shares["mesh"] < shares.bearable < 0.05
    beyond = (shares.shares["mesh"] + shares.bearable) / 2 / RATIO
    asked = estimating(monkeypatch, lambda size: beyond)
    found = choice_of(FREE)
    assert len(asked) == 1
    assert found.short == ""
    assert found.budget.shares["mesh"] > shares.shares["mesh"]
    for source in ("harmonics", "frequencies"):
        assert 0.5 < found.budget.shares[source] / shares.shares[source] < 1


def test_the_largest_mesh_is_taken_where_the_share_is_out_of_reach(monkeypatch):
    estimating(monkeypatch, lambda size: 0.07 * (size / 0.025) ** 0.5)
    monkeypatch.setattr(mesh_sizes, "DOFS", 250_000)
    found = choice_of("accuracy = 0.001")
    size = found.study.mesh.size
    assert all(0.003 < each < 0.009 for each in size)
    vane, casing = found.study.vane, found.study.casing
    dofs = vane_dofs(vane, 16, size[0]) + casing_dofs(casing, vane.hook, 16, size[1], 3)
    assert 0.9 * mesh_sizes.DOFS < dofs <= 1.001 * mesh_sizes.DOFS
    assert f"estimated error {found.rounds[-1].amplitude:.1e} at" in found.short
    assert "was its share" in found.short


def test_no_mesh_is_chosen_that_memory_does_not_hold(monkeypatch):
    estimating(monkeypatch, lambda size: 0.07 * (size / 0.025) ** 0.5)
    monkeypatch.setattr(process, "_bounds", lambda: [process._Bound(4e9, 1e9, "a test's memory")])
    most = mesh_sizes.most_dofs()
    assert mesh_sizes.peak_memory(most) == pytest.approx(mesh_sizes.SHARE * 4e9)
    found = choice_of("accuracy = 0.001")
    dofs = mesh_sizes.unknowns(found.study, found.study.mesh.size)
    assert 0.9 * most < dofs <= 1.001 * most
    assert f"none larger than {most:,.0f} fit the memory" in found.short
    assert mesh_sizes.most_dofs(2e9) < most
    assert mesh_sizes.most_dofs(8e9) == most
    with pytest.raises(InputError, match=r"^memory = 1 GB: a coarse mesh takes 1\.\d GB$"):
        mesh_sizes.most_dofs(1e9)


def test_patches_that_a_mesh_cannot_hold_ask_for_a_finer_one(monkeypatch):
    refusal = InputError("vane: the mesh is too coarse to resolve the contact patches")
    asked = estimating(monkeypatch, lambda size: refusal if size > 0.022 else 0.01)
    found = choice_of(FREE)
    assert [study.mesh.size for study in asked] == ["coarse", (0.0212, 0.0113)]
    assert len(found.rounds) == 1
    estimating(monkeypatch, lambda size: InputError("vane: something else"))
    with pytest.raises(InputError, match="something else"):
        choice_of(FREE)


def test_a_given_mesh_is_kept_and_estimated(monkeypatch):
    asked = estimating(monkeypatch, lambda size: 0.07)
    found = choice_of(f'{FREE}\n[mesh]\nsize = "medium"')
    assert [study.mesh.size for study in asked] == ["medium"]
    assert found.rounds[0].error == 0.07
    assert found.short == ""
    assert "mesh" not in found.budget.shares


def test_modes_get_their_share_or_take_their_error_off(monkeypatch):
    estimating(monkeypatch, lambda size: 0.01)
    open_to = choice_of(FREE)
    assert open_to.study.rom.accuracy == pytest.approx(open_to.budget.shares["modes"])
    pinned = choice_of(f"{FREE}\n[rom]\naccuracy = 1e-3")
    assert pinned.study.rom.accuracy == 1e-3
    assert sum(pinned.budget.shares.values()) == pytest.approx(0.05 - 3e-4)
    assert sum(budget(parse_study(FREE)).shares.values()) == pytest.approx(0.05)
