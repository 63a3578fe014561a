"""What a run of a study computes, leaves behind and says; orders, couplings, an early end."""

import json
import re
import shutil
from collections import Counter

import h5py
import numpy as np
import pytest
import scipy.linalg as sl

from tests.small_study import HOOK, INTERLOCK, SMALL
from tests.vanelock.scenes.test_run import PAD, QUIET, arm
from vanelock import load_scene, load_system, open_results, parse_study, run_scene, run_study
from vanelock.common.tables import Table
from vanelock.nonlinear import STUCK, Options, Response, frequency_response
from vanelock.pipeline.progress import Done, Event, Finished, Notice, PointDone
from vanelock.stages.parts.components import mesh_step
from vanelock.stages.response.limits import Limits

pytestmark = pytest.mark.usefixtures("undrawn")


def run(text, folder):
    heard: list[Event] = []
    found = run_study(parse_study(text), folder, heard.append, text)
    return found, heard


@pytest.fixture
def first(golden):
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
    done = Counter(event.stage for event in first.events if isinstance(event, Done))
    assert {stage: count for stage, count in done.items() if count > 1} == {"mesh correction": 4}
    figures = {stage for stage in done if stage.endswith(".png")}
    assert figures >= {"figures/haigh_nominal.png", "shapes/mode_free.png", "figures/mesh.png"}
    assert len(figures) == 10
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


def test_the_same_again_computes_nothing(golden, again):
    folder, _ = again
    found, heard = run(golden("sweep").text, folder)
    assert computed(heard) == []
    assert found == golden("sweep").summaries
    with open_results(folder / "results.h5") as file:
        assert file.attrs["complete"]
        assert "mu=0.3,force=20N" in file["response"]


def test_other_friction_reuses_the_reduced_model_and_a_damaged_entry_is_computed_again(again):
    folder, text = again
    (before,), heard = run(text, folder)
    pictures = {"figures/response.png", "figures/preload.png", "figures/loop_nominal.png"}
    linear = {"linear limits", "linear response, free", "linear response, stuck"}
    assert {*computed(heard)} - linear == {
        "preload",
        "response nominal",
        "static bounds",
    } | pictures
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
    assert {*computed(heard)} - pictures == {"mesh casing"}
    notices = [event.text for event in heard if isinstance(event, Notice)]
    assert sum(entry.name in text for text in notices) == 1
    assert after.peak == before.peak


HEAD = f"""{SMALL}
joints.interlock.mu = 0.1
mesh.correction = "none"
outputs = {{ show = [] }}
[response]
harmonics = 1
"""


def response(folder, case):
    with open_results(folder / "results.h5") as file:
        return Response.load(file[f"response/{case}"])


def computed(heard):
    return [event.stage for event in heard if isinstance(event, Done) and not event.cached]


def test_engine_orders_are_responses_of_their_own(tmp_path):
    frequencies = "frequencies = [253, 256]\n"
    orders = (-2, 16)
    found, heard = run(
        f"{HEAD}{frequencies}[sweep]\nexcitation.engine_order = {list(orders)}", tmp_path
    )
    names = [f"engine_order={order}" for order in orders]
    assert [each.case for each in found] == names
    assert computed(heard).count("rom casing, ND 0") == 1
    table = next(event for event in heard if isinstance(event, Table) and event.key == "cases")
    assert [row[0] for row in table.rows] == names
    assert (tmp_path / "figures" / "response.png").exists()
    for order, name in zip(orders, names, strict=True):
        kept = response(tmp_path, name)
        system = load_system(tmp_path / "results.h5", name)
        assert system.engine_order == order
        assert set(system.diameters) == {0, abs(order) % 16}
        assert kept.harmonic_diameters.tolist() == [0, order % 16]
        assert kept.converged.all()
        again = frequency_response(system, kept.frequency, Options(1))
        np.testing.assert_array_equal(again.contact, kept.contact)
    # A study of one order has the same response, to the last bit.
    together = response(tmp_path, "engine_order=16")
    run(f"{HEAD}{frequencies}[excitation]\nengine_order = 16", tmp_path)
    alone = response(tmp_path, "nominal")
    np.testing.assert_array_equal(together.amplitude, alone.amplitude)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("run")


def test_couplings_and_friction_are_swept_like_numbers(folder):
    text = (
        'frequencies = [256]\n[excitation]\nforce = 30\n[sweep]\n"response.coupling" = '
        '["coupled", "uncoupled", "constant-load"]\n'
        '"response.friction" = ["orthogonal", "isotropic"]'
    )
    found, heard = run(HEAD + text, folder)
    assert [each.case for each in found] == [
        f"coupling={coupling},friction={friction}"
        for coupling in ("coupled", "uncoupled", "constant-load")
        for friction in ("orthogonal", "isotropic")
    ]
    stages = computed(heard)
    assert stages.count("preload") == 2  # one for each kind of friction
    assert stages.count("linear response, free") == 1
    peaks = {}
    for each in found:
        kept = response(folder, each.case)
        assert kept.converged.all()
        settings = dict(item.split("=") for item in each.case.split(","))
        assert (kept.coupling, kept.friction) == (settings["coupling"], settings["friction"])
        assert kept.samples == 0
        assert np.any(kept.state != STUCK)
        peaks[kept.coupling, kept.friction] = each.peak.amplitude
        with open_results(folder / "results.h5") as file:
            group = file[f"response/{each.case}"]
            assert group.attrs["sweep response.coupling"] == kept.coupling
            static = Response.load(group["preload"])
        assert static.friction == kept.friction
        if kept.coupling != "coupled":
            np.testing.assert_allclose(kept.force[0, 0], static.force[0, 0], atol=1e-6)
    assert len(set(peaks.values())) == 6


def test_samples_of_the_study_reach_the_law(folder):
    run(f"{HEAD}frequencies = [254]\nsamples = 64", folder)
    kept = response(folder, "nominal")
    assert kept.samples == 64
    system = load_system(folder / "results.h5", "nominal")
    again = frequency_response(system, [254.0], Options(1, samples=64))
    np.testing.assert_array_equal(again.contact, kept.contact)


NAMES = ["mu=0.05", "mu=0.1", "mu=0.2"]


def stopped(event: Event) -> None:
    """Ctrl-C at the first table of the first case."""
    if isinstance(event, Table) and event.title.startswith("Preload"):
        raise KeyboardInterrupt


def test_cases_that_are_solved_are_in_results_after_an_interrupt(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(f'{arm(tmp_path)}{PAD}{QUIET}[sweep]\n"contacts.pad.mu" = [0.05, 0.1, 0.2]')
    folder, results = tmp_path / "run", tmp_path / "run" / "results.h5"
    run_scene(load_scene(path), folder)
    with h5py.File(results) as file:
        whole = {name: file[f"response/{name}/amplitude"][()] for name in NAMES}
        peaks = {name: file[f"response/{name}"].attrs["peak_amplitude"] for name in NAMES}
    results.unlink()
    entries = (folder / "cache").glob("*/response-*.h5")
    max(entries, key=lambda each: each.stat().st_mtime_ns).unlink()  # the last is not solved yet
    with pytest.raises(KeyboardInterrupt):
        run_scene(load_scene(path), folder, stopped)
    with h5py.File(results) as file:
        found = [name for name in NAMES if name in file["response"]]
        assert len(found) == 2
        assert not file.attrs["complete"]
        for name in found:
            np.testing.assert_array_equal(file[f"response/{name}/amplitude"], whole[name])
            assert file[f"response/{name}"].attrs["peak_amplitude"] == peaks[name]
    run_scene(load_scene(path), folder)
    with h5py.File(results) as file:
        assert file.attrs["complete"]
        assert all(name in file["response"] for name in NAMES)
