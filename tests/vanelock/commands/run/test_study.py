"""What a run of a study computes, leaves behind and says."""

import json
import re
import shutil

import h5py
import numpy as np
import pytest
import scipy.linalg as sl

from tests.small_study import HOOK, INTERLOCK
from vanelock import load_system, open_results, parse_study, run_study
from vanelock.common.tables import Table
from vanelock.input.cases.sweep import cases
from vanelock.nonlinear import Response, linear_response
from vanelock.pipeline.progress import Done, Event, Finished, Notice, PointDone
from vanelock.stages.parts.components import mesh_step
from vanelock.stages.plan import plan
from vanelock.stages.response.limits import Limits

pytestmark = pytest.mark.usefixtures("undrawn")


def run(text, folder):
    heard: list[Event] = []
    found = run_study(parse_study(text), folder, heard.append, text)
    return found, heard


def computed(heard):
    """Stages that were not cached."""
    return {each.stage for each in heard if isinstance(each, Done) and not each.cached}


@pytest.fixture
def first(golden):
    """A run of the defaults: to be read."""
    return golden("default")


@pytest.fixture(scope="module")
def again(golden, tmp_path_factory):
    """What a sweep left, to be run again; and the text of another case, at one frequency."""
    folder = tmp_path_factory.mktemp("again") / "run"
    shutil.copytree(golden("sweep").folder, folder)
    text = golden("sweep").text.partition("[sweep]")[0]
    text = re.sub(r"frequencies = .*", "frequencies = [256]", text).replace('"both"', '"up"')
    text = text.replace("joints.interlock.kn", "joints.interlock.mu = 0.2\njoints.interlock.kn")
    return folder, text + "[outputs]\nshow = ['loops']\n"


def test_every_stage_ran_once(first):
    done = [event.stage for event in first.events if isinstance(event, Done)]
    expected = """
        mesh vane; mesh casing; fem vane; fem casing; rom vane, condensed; rom vane
        rom casing, ND 0; rom casing, ND 1; rom casing, ND 2; rom casing, ND 3
        rom casing, condensed; mesh excess, vane; linear limits
        mesh correction; mesh correction; mesh correction; mesh correction
        linear response, free; linear response, stuck; preload; response nominal; static bounds
        stress nominal; sensitivities nominal; check nominal; figures/haigh_nominal.png
        figures/loop_nominal.png; figures/contacts_nominal.png; figures/response.png
        figures/preload.png; figures/mesh.png; shapes/response_nominal.png
        shapes/stress_nominal.png; shapes/mode_free.png; shapes/mode_stuck.png; mesh errors, peak
        neglected harmonics, peak; mode shapes; report.html
    """
    assert sorted(done) == sorted(re.split(r"; |\n\s+", expected.strip()))
    points = [event for event in first.events if isinstance(event, PointDone)]
    assert [(p.case, p.done, p.total) for p in points] == [("nominal", i, 9) for i in range(1, 10)]
    assert points[-1].left == 0
    assert isinstance(first.events[-1], Finished)


def test_results_hold_the_whole_chain(first):
    with open_results(first.folder / "results.h5") as file:
        assert file.attrs["complete"]
        assert set(file) == {"mesh", "rom", "system", "limits", "response", "provenance"}
        assert set(file["mesh"]) == {"vane", "casing"}
        assert set(file["rom"]) == {"vane", "casing", *(f"casing_nd{k}" for k in (0, 2, 3))}
        assert "1" in file["rom/casing"]
        assert set(file["system/nd/1/part"]) == {"vane", "casing"}
        assert set(file["response"]) == {"free", "stuck", "nominal"}
        assert file["provenance"].attrs["study"] == first.text
        assert json.loads(file["provenance"].attrs["settings"])["mesh"]["size"] == 0.04
        assert "numpy" in file["provenance/versions"].attrs
        assert len(file["provenance/stages/name"]) >= 11
        response = Response.load(file["response/nominal"])
        listed = [250, 254, 256, 258, 259, 260, 264, 268, 272]
        np.testing.assert_allclose(response.frequency, listed, rtol=1e-12)
        assert response.contact.shape == (9, 1 + response.harmonics, HOOK + INTERLOCK, 3)


def test_limits_are_those_of_the_stored_matrices(first):
    """Eigenvalues of K + BᴴkB built here from the arrays in the file alone."""
    with h5py.File(first.folder / "results.h5") as file:
        limits = Limits.load(file["limits/all"])
        nd = file["system/nd/1"]
        K, M = nd["K"][()], nd["M"][()]
        B = nd["own"][()] + nd["next"][()] * np.exp(-2j * np.pi / 16)
        stiffness = np.column_stack([file["system/contact/kn"], file["system/contact/kt"]])
        hooks = file["system/contact/joint"].asstr()[()] == "hook"
    for closed, found in ((hooks, limits.free), (hooks | True, limits.stuck)):
        rows = B[closed].reshape(-1, len(K))
        stuck = K + rows.conj().T @ (stiffness[closed].ravel()[:, None] * rows)
        reference = np.sqrt(sl.eigh(stuck, M, eigvals_only=True)[:6]) / (2 * np.pi)
        np.testing.assert_allclose(found[:6], reference, rtol=1e-8)
    assert limits.rise > 0.05
    assert limits.mac > 0.9
    shown = first.rows("limits")
    assert shown[0]["f2_hz"] == pytest.approx(limits.free[1])
    assert shown[1]["rise_percent"] == pytest.approx(100 * limits.rise)


def test_linear_peak_is_found_between_the_frequencies_asked_for(first):
    system = load_system(first.folder / "results.h5", "nominal")
    shown = first.rows("linear")
    for row, closed in zip(shown, ("hook", ("hook", "interlock")), strict=True):
        near = row["frequency_hz"] * np.linspace(0.9995, 1.0005, 21)
        reference = linear_response(system, near, closed).amplitude[:, 0].max()
        assert row["peak_um"] == pytest.approx(1e6 * reference, rel=1e-3)


def test_the_same_again_computes_nothing(golden, again):
    folder, _ = again
    found, heard = run(golden("sweep").text, folder)
    assert computed(heard) == set()
    assert found == golden("sweep").summaries
    with open_results(folder / "results.h5") as file:
        assert file.attrs["complete"]
        assert "mu=0.3,force=20N" in file["response"]


def test_other_friction_reuses_the_reduced_model_and_a_damaged_entry_is_computed_again(again):
    folder, text = again
    (before,), heard = run(text, folder)
    pictures = {"figures/response.png", "figures/preload.png", "figures/loop_nominal.png"}
    linear = {"linear limits", "linear response, free", "linear response, stuck"}
    assert computed(heard) - linear == {"preload", "response nominal", "static bounds"} | pictures
    preload = next(each for each in heard if isinstance(each, Table) and each.key == "preload")
    assert "mu=0.2" not in str(preload.title)
    (entry,) = (folder / "cache").rglob(
        f"mesh-casing-{mesh_step(parse_study(text), 'casing').key}-*"
    )
    with h5py.File(entry) as file:
        place = file["product/node_sets/fixed"].id.get_offset()  # no filter notices
    content = bytearray(entry.read_bytes())
    content[place] ^= 255
    entry.write_bytes(content)
    (after,), heard = run(text, folder)
    assert computed(heard) - pictures == {"mesh casing"}
    notices = [event.text for event in heard if isinstance(event, Notice)]
    assert sum(entry.name in text for text in notices) == 1
    assert after.peak == before.peak


def test_a_dimension_reaches_the_part_it_belongs_to():
    def keys(text):
        (planned,) = plan(cases(parse_study(text)), lambda *_: None, [None])
        found, waiting = {}, [planned.response, *planned.linear.responses.values()]
        while waiting:
            step = waiting.pop()
            found[step.stage] = step.key
            waiting += step.needs
        return found

    before, after = keys(""), keys('[casing]\nouter_radius = "604.5 mm"')
    assert {name for name, key in before.items() if after[name] == key} == {
        "mesh vane",
        "fem vane",
        "rom vane, condensed",
        "rom vane",
        "recovery vane",
    }
