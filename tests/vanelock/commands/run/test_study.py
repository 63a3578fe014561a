"""Whole runs of the real scene on its coarsest mesh, with few frequencies."""

import json

import h5py
import numpy as np
import pytest
import scipy.linalg as sl

from vanelock import load_system, open_results, parse_study, run_study
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.nonlinear import OPEN, SLIP, SLIP_OPEN, Response, linear_response
from vanelock.pipeline.progress import Begun, Done, Event, Finished, Notice, PointDone
from vanelock.results.files.run_folder import claimed
from vanelock.rom import System
from vanelock.stages.parts.meshes import mesh_step
from vanelock.stages.response.limits import Limits

STUDY = """
[mesh]
size = "coarse"
[response]
frequencies = [262, 266, 270]
harmonics = 1
[outputs]
shapes = false
animations = false
report = false
"""


class Listener(list[Event]):
    """Everything that a run said."""

    def computed(self):
        """Stages that were not cached."""
        done = [event for event in self if isinstance(event, Done)]
        return {event.stage for event in done if not event.cached}

    def table(self, key):
        """The table of that name."""
        return next(event for event in self if isinstance(event, Table) and event.key == key)


def run(text, folder):
    heard = Listener()
    found = run_study(parse_study(text), folder, heard.append, text)
    return found, heard


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A run in a fresh folder: folder, summaries, events."""
    folder = tmp_path_factory.mktemp("run")
    return folder, *run(STUDY, folder)


def test_every_stage_ran_once(first):
    _, _, heard = first
    done = [event.stage for event in heard if isinstance(event, Done)]
    assert sorted(done) == sorted(
        [
            "mesh vane",
            "mesh casing",
            "fem vane",
            "fem casing",
            "rom vane, condensed",
            "rom vane",
            "rom casing",
            "rom casing, condensed",
            "mesh excess, vane",
            "mesh correction",
            "linear limits",
            "linear response, free",
            "linear response, stuck",
            "preload",
            "response nominal",
            "static bounds",
            "figures/response.png",
            "figures/preload.png",
            "figures/loop_nominal.png",
        ]
    )
    points = [event for event in heard if isinstance(event, PointDone)]
    assert [(p.case, p.done, p.total) for p in points] == [("nominal", i, 3) for i in (1, 2, 3)]
    assert points[-1].left == 0
    assert isinstance(heard[-1], Finished)


def test_results_hold_the_whole_chain(first):
    folder, _, _ = first
    with open_results(folder / "results.h5") as file:
        assert file.attrs["complete"]
        assert set(file) == {"mesh", "rom", "system", "limits", "response", "provenance"}
        assert set(file["mesh"]) == set(file["rom"]) == {"vane", "casing"}
        assert {"0", "1"} <= set(file["rom/casing"])
        assert set(file["response"]) == {"free", "stuck", "nominal"}
        assert file["provenance"].attrs["study"] == STUDY
        assert json.loads(file["provenance"].attrs["settings"])["mesh"]["size"] == "coarse"
        assert "numpy" in file["provenance/versions"].attrs
        assert len(file["provenance/stages"]) >= 11
        response = Response.load(file["response/nominal"])
        assert response.frequency.tolist() == [262, 266, 270]
        assert response.contact.shape == (3, 2, 66, 3)


def test_limits_are_those_of_the_stored_matrices(first):
    """Eigenvalues of K + BᴴkB built here from the arrays in the file alone."""
    folder, _, heard = first
    with h5py.File(folder / "results.h5") as file:
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
    shown = heard.table("limits").record()["rows"]
    assert shown[0]["f2_hz"] == pytest.approx(limits.free[1])
    assert shown[1]["rise_percent"] == pytest.approx(100 * limits.rise)


def test_preload_table_counts_the_contacts(first):
    folder, _, heard = first
    hook, interlock = heard.table("preload").record()["rows"]
    assert (hook["closed"], hook["open"]) == (56, 0)
    assert (interlock["closed"], interlock["open"]) == (10, 0)
    with open_results(folder / "results.h5") as file:
        static = Response.load(file["response/nominal/preload"])
        joint = np.array(System.load(file["system"]).contacts.joint)
    force = static.force[0, 0].real
    assert hook["n_mean"] == pytest.approx(force[joint == "hook", 0].mean())
    assert interlock["n_min"] == pytest.approx(force[joint == "interlock", 0].min())
    # n = kn v where the contact is closed.
    v = static.contact[0, 0, joint == "hook", 0].real
    np.testing.assert_allclose(force[joint == "hook", 0], 1.67e7 * v, rtol=1e-9)


def test_summary_agrees_with_the_stored_response(first):
    folder, (found,), heard = first
    with open_results(folder / "results.h5") as file:
        response = Response.load(file["response/nominal"])
        linear = {which: Response.load(file[f"response/{which}"]) for which in ("free", "stuck")}
        limits = Limits.load(file["limits/all"])
        monitor = file["response/nominal"].attrs["monitor"]
        assert file["response/nominal"].attrs["peak_amplitude"] == found.peak.amplitude
    system = load_system(folder / "results.h5", "nominal")
    node = system.output_names.index(monitor.partition(", ")[0])
    component = ["radial", "circumferential", "axial"].index(monitor.partition(", ")[2])
    assert node == 0
    at_peak = linear["free"].amplitude[:, 0].max(axis=0)
    assert component == at_peak.argmax()
    amplitude = response.amplitude[:, node, component]
    top = amplitude.argmax()
    assert found.peak.amplitude == amplitude[top]
    assert found.peak.frequency == response.frequency[top]
    for which, ratio in (("free", found.of_free), ("stuck", found.of_stuck)):
        assert ratio == pytest.approx(
            amplitude[top] / linear[which].amplitude[:, 0, component].max()
        )
    free, stuck = limits.free_frequency, limits.stuck_frequency
    assert found.position == pytest.approx((found.peak.frequency - free) / (stuck - free))
    states = response.state[top][-10:]
    assert found.slipping == np.mean((states == SLIP) | (states == SLIP_OPEN))
    assert found.opening == np.mean((states == OPEN) | (states == SLIP_OPEN))
    assert (found.converged, found.points) == (3, 3)
    (row,) = heard.table("cases").record()["rows"]
    assert row["peak_um"] == pytest.approx(1e6 * amplitude[top])
    assert row["converged"] == "3/3"


def test_linear_peak_is_found_between_the_frequencies_asked_for(first):
    folder, _, heard = first
    system = load_system(folder / "results.h5", "nominal")
    shown = heard.table("linear").record()["rows"]
    for row, closed in zip(shown, ("hook", ("hook", "interlock")), strict=True):
        near = row["frequency_hz"] * np.linspace(0.9995, 1.0005, 21)
        reference = linear_response(system, near, closed).amplitude[:, 0].max()
        assert row["peak_um"] == pytest.approx(1e6 * reference, rel=1e-3)


def test_the_same_again_computes_nothing(first):
    folder, summaries, _ = first
    again, heard = run(STUDY, folder)
    assert heard.computed() == set()
    assert again == summaries
    with open_results(folder / "results.h5") as file:
        assert file.attrs["complete"]
        assert "nominal" in file["response"]


def test_other_friction_reuses_the_reduced_model(first):
    folder, _, _ = first
    text = STUDY + "[joints.interlock]\nmu = 0.15"
    _, heard = run(text, folder)
    pictures = {"figures/response.png", "figures/preload.png", "figures/loop_nominal.png"}
    assert heard.computed() == {"preload", "response nominal", "static bounds"} | pictures
    assert "mu=0.15" not in str(heard.table("preload").title)
    _, heard = run(text.replace("shapes = false", "shapes = false\nloops = false"), folder)
    assert heard.computed() == set()


def test_a_dimension_reaches_the_part_it_belongs_to(first):
    folder, _, _ = first
    heard = Listener()

    def until_preload(event):
        heard.append(event)
        if event == Begun("preload"):
            raise KeyboardInterrupt

    text = STUDY + '[casing]\nouter_radius = "604.5 mm"'
    with pytest.raises(KeyboardInterrupt):
        run_study(parse_study(text), folder, until_preload)
    assert heard.computed() == {
        "mesh casing",
        "fem vane",  # of what is left of the vane: nothing is kept of these three
        "rom vane, condensed",
        "mesh excess, vane",
        "fem casing",
        "rom casing",
        "rom casing, condensed",
        "mesh correction",
        "linear limits",
        "linear response, free",
        "linear response, stuck",
    }


def test_a_damaged_cache_entry_is_computed_again(first):
    folder, summaries, _ = first
    key = mesh_step(parse_study(STUDY), "casing").key
    (entry,) = (folder / "cache").rglob(f"mesh-casing-{key}-*.h5")
    content = bytearray(entry.read_bytes())
    content[len(content) // 3] ^= 255
    entry.write_bytes(content)
    again, heard = run(STUDY, folder)
    assert heard.computed() - {"figures/response.png", "figures/preload.png"} <= {
        "mesh casing",
        "figures/loop_nominal.png",
    }
    assert "mesh casing" in heard.computed()
    notices = [event.text for event in heard if isinstance(event, Notice)]
    assert sum(entry.name in text for text in notices) == 1
    assert again[0].peak == summaries[0].peak


def test_two_runs_in_one_folder(first):
    folder, _, _ = first
    with claimed(folder), pytest.raises(InputError, match="another run is using this folder"):
        run(STUDY, folder)
