"""Bounds, stability and what settles as stages of a run: truths, files, resuming, the page."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.nonlinear.bounds.test_peak_bounds import held_pad, peak_by_load
from tests.vanelock.scenes.test_joined import rim
from tests.vanelock.stages.conftest import planned_of
from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock import load_scene, nonlinear, run_scene
from vanelock.analyses.bounds import BoundedPeak
from vanelock.analyses.settled import FollowedPeak
from vanelock.commands.compare import compared
from vanelock.commands.stored.contents import load_run
from vanelock.common.errors import InputError
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import PointDone
from vanelock.pipeline.step import Stages
from vanelock.rom import Contacts, Diameter, Force, System
from vanelock.stages.matrices.scene_structure import SceneStructure

pytestmark = pytest.mark.usefixtures("undrawn")


PAD = (
    '[system]\nfile = "pad.h5"\n[response]\nrange = [0.1, 0.3]\nharmonics = 1\n'
    "[bounds]\nstarts = 1\n[stability]\n[outputs]\nshow = []\n"
)


NEAR = "range = [44.0, 56.0]\npoints = 25\n"


def softening() -> System:
    own = np.array([[[1.0], [0.0], [0.0]]])
    stiffness = (2 * np.pi * 55) ** 2
    matrices = Diameter(np.array([[0.5 * stiffness]]), np.eye(1), own, None, own)
    springs = np.array([0.5 * stiffness]), np.ones((1, 2)), np.zeros(1), np.array([1e-4])
    force = {1: Force(np.array([1.0 + 0j]))}
    return System(1, 1, {0: matrices}, Contacts(*springs, ("pad",)), force, ("mass",), 0.005)


def written(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text)
    return path


def pad_scene(folder: Path, more: str = "") -> Path:
    held_pad(1.0).save(folder / "pad.h5")
    return written(folder, PAD + more)


@pytest.fixture(scope="module")
def pad_run(tmp_path_factory):
    folder, events = tmp_path_factory.mktemp("pad"), list[Any]()
    (found,) = run_scene(load_scene(pad_scene(folder)), folder / "run", events.append)
    return folder / "run", found, events


def test_bounds_of_a_run_are_those_of_the_loads_a_clamp_can_hold(pad_run, tmp_path):
    folder, found, events = pad_run
    path = pad_scene(tmp_path)
    path.write_text(path.read_text().replace("[bounds]\nstarts = 1\n[stability]\n", ""))
    (before,) = run_scene(load_scene(path), tmp_path / "plain")
    assert found.peak == before.peak  # the response is the same, to the bit
    with h5py.File(folder / "results.h5") as file:
        group = file["response/nominal"]
        bounded = BoundedPeak.load(group["bounds"])
        assert bounded.found is not None
        stability = nonlinear.Stability.load(group["stability"])
        assert group.attrs["lowest_peak_amplitude"] == bounded.found.amplitude[0]
        assert group.attrs["highest_peak_amplitude"] == bounded.found.amplitude[2]
        assert group.attrs["wave"] == "stable"
    low, high = bounded.low, bounded.high
    assert low is not None
    assert high is not None
    assert bounded.residual.max() < 1e-9
    for place, end in ((0, found.lowest), (2, found.highest)):
        load = bounded.found.rest_load[place, 0]
        assert end.amplitude == pytest.approx(peak_by_load(1.0, load), rel=1e-9)
    for curve, end in ((low, found.lowest), (high, found.highest)):
        top = curve.amplitude[:, 0].max()
        assert end.amplitude * (1 - 1e-2) < top <= end.amplitude * (1 + 1e-9)
    assert stability.frequency.tolist() == [found.peak.frequency]
    assert found.wave.verdict == "stable"
    assert found.wave.growth == pytest.approx(abs(stability.multiplier[0, 0]), rel=1e-12)
    assert found.wave.growth < 1
    tables = {each.key: each for each in events if hasattr(each, "columns")}
    assert [row[0] for row in tables["bounds"].rows] == [
        "lower bound",
        "as assembled",
        "upper bound",
    ]
    row = tables["cases"].record()["rows"][0]
    assert (row["lowest_um"], row["highest_um"]) == pytest.approx(
        (1e6 * found.lowest.amplitude, 1e6 * found.highest.amplitude)
    )
    assert row["wave"] == "stable"
    assert any(isinstance(each, PointDone) and each.total is None for each in events)
    assert not any("static friction" in line for line in found.warnings)
    runs = load_run(tmp_path / "plain"), load_run(folder)
    lines = {what: values for _, what, *values in compared(*runs)[2].rows}
    assert lines["upper bound"] == [None, f"{1e6 * found.highest.amplitude:.4g} µm", ""]
    assert lines["growth per cycle"][1] == f"{found.wave.growth:.4g}"


def test_a_peak_at_the_end_of_the_range_has_no_bounds(tmp_path):
    path = pad_scene(tmp_path)
    path.write_text(path.read_text().replace("[0.1, 0.3]", "[0.1, 0.12]"))
    (found,) = run_scene(load_scene(path), tmp_path / "run")
    assert found.lowest is None
    assert any(line.startswith("no bounds of the peak over static") for line in found.warnings)


@pytest.mark.parametrize(
    ("direction", "friction"), [("up", "orthogonal"), ("both", "orthogonal"), ("up", "isotropic")]
)
def test_bounds_are_of_the_sweep_and_the_law_that_the_run_shows(
    tmp_path, monkeypatch, direction, friction
):
    """A preloaded contact that opens softens: the sweep down reaches higher."""
    swept = list[tuple[str | None, str]]()

    def bounds(
        system: object, near: object, options: nonlinear.Options, *_: Any, **__: Any
    ) -> None:
        swept.append((options.direction, options.friction))
        raise InputError("enough")

    monkeypatch.setattr(nonlinear, "peak_bounds", bounds)
    softening().save(tmp_path / "soft.h5")
    text = f'direction = "{direction}"\nfriction = "{friction}"\n[bounds]\n[outputs]\nshow = []\n'
    text = f'[system]\nfile = "soft.h5"\n[response]\nharmonics = 1\n{NEAR}{text}'
    (found,) = run_scene(load_scene(written(tmp_path, text)), tmp_path / "run")
    assert swept == [(found.sweeps[0].direction, friction)]
    assert found.sweeps[0].direction == ("up" if direction == "up" else "down")
    if direction == "both":
        assert found.sweeps[0].peak.amplitude > 1.1 * found.sweeps[1].peak.amplitude


def test_static_friction_is_reported_of_the_first_case_that_is_there(tmp_path, monkeypatch):
    real = nonlinear.frequency_response

    def response(system: System, *rest: Any, **options: Any) -> nonlinear.Response:
        if system.contacts.mu[0] == 0.4:
            raise MemoryError
        return real(system, *rest, **options)

    monkeypatch.setattr(nonlinear, "frequency_response", response)
    text = PAD.replace("[bounds]\nstarts = 1\n[stability]\n", "")
    held_pad(1.0).save(tmp_path / "pad.h5")
    path = written(tmp_path, text + '[contacts.pad]\n[sweep]\n"contacts.pad.mu" = [0.4, 0.5, 0.6]')
    found = run_scene(load_scene(path), tmp_path / "run")
    warned = [
        any("static friction of contacts" in line for line in each.warnings) for each in found
    ]
    assert warned == [True, False]


def test_the_sector_of_a_scene_has_the_stability_of_all_its_nodal_diameters(tmp_path):
    text = rim(tmp_path, "cylindrical").replace("mu = 0.2\n", 'mu = 0.2\ninterference = "40 um"\n')
    scene = load_scene(
        written(
            tmp_path,
            text + '[response]\nharmonics = 1\npoints = 2\n[stability]\npoints = "all"\n'
            "[outputs]\nshow = []\n",
        )
    )
    (found,) = run_scene(scene, tmp_path / "run")
    stages = Stages(Cache(tmp_path / "other", print), lambda event: None)
    system = stages.get(SceneStructure(scene).system((0, 1, 2, 3)))
    with h5py.File(tmp_path / "run" / "results.h5") as file:
        response = nonlinear.Response.load(file["response/nominal"])
        kept = nonlinear.Stability.load(file["response/nominal/stability"])
    again = nonlinear.stability(system, response)
    assert kept.verdict.tolist() == again.verdict.tolist()
    assert len(kept.verdict) == response.points
    np.testing.assert_allclose(kept.exponent, again.exponent, rtol=1e-6, atol=1e-6)
    assert found.wave is not None
    csv = (tmp_path / "run" / "figures" / "response.csv").read_text()
    words = ["stable", "unstable", "undecided"]
    ends = [line.rpartition(",")[2] for line in csv.splitlines() if "nominal" in line]
    assert ends == [words[i] for i in kept.verdict]


def test_a_study_has_both_on_its_page(golden, kept_by):
    run = golden("everything")
    (found,) = run.summaries
    with h5py.File(run.folder / "results.h5") as file:
        group = file["response/nominal"]
        response = nonlinear.Response.load(group)
        bounded = BoundedPeak.load(group["bounds"])
        kept = nonlinear.Stability.load(group["stability"])
        answers = dict(group["answers"].attrs)
    assert bounded.found is not None
    assert found.lowest.amplitude == found.highest.amplitude == bounded.found.amplitude[0]
    assert found.highest.amplitude == pytest.approx(found.peak.amplitude, rel=5e-3)
    whole = kept_by("everything").get(planned_of(run.text).structure.whole)
    assert sorted(whole.diameters) == list(range(5))
    top = int(response.amplitude[:, 0].max(axis=1).argmax())
    again = nonlinear.stability(whole, response, [top])
    assert kept.frequency.tolist() == [found.peak.frequency]
    np.testing.assert_allclose(kept.exponent, again.exponent, rtol=1e-5)
    assert found.wave.growth == pytest.approx(abs(kept.multiplier[0, 0]), rel=1e-12)
    assert answers["goodman_reserve_at_largest_peak"] == pytest.approx(
        answers["goodman_reserve"], rel=1e-2
    )
    page = (run.folder / "report.html").read_text("utf-8")
    for text in ("Periodic wave", found.wave.verdict, "Mistuning", "as assembled"):
        assert text in page, text
    assert "upper bound of the peak over static friction" in page


SIZE = 1e-5
"""Of the ring of masses, so that it vibrates by micrometres."""


def scene(folder: Path, frequencies: str, asked: str = "[settled]\n") -> Path:
    """The ring whose wave at 0.34 Hz is unstable, a thousand times as fast."""
    system = loaded(spring_ring(1), SIZE * worst_of(1)["lift"][1])
    made = replace(
        system,
        contacts=replace(system.contacts, v0=SIZE * system.contacts.v0),
        diameters={k: replace(each, M=1e-6 * each.M) for k, each in system.diameters.items()},
    )
    made.save(folder / "ring.h5")
    path = folder / "scene.toml"
    path.write_text(
        f'[system]\nfile = "ring.h5"\n[response]\n{frequencies}\nharmonics = 5\n'
        f"[stability]\n{asked}[outputs]\nshow = ['report']\n"
    )
    return path


def test_a_run_says_what_its_ring_does_instead_of_an_unstable_wave(tmp_path):
    events, folder = list[Any](), tmp_path / "run"
    path = scene(tmp_path, "range = [310, 370]")
    (found,) = run_scene(load_scene(path), folder, events.append)
    assert found.wave.verdict == "unstable"
    settled = found.wave.settled
    with h5py.File(folder / "results.h5") as file:
        kept = FollowedPeak.load(file["response/nominal/settled"]).found
        system = nonlinear.System.load(file["response/nominal/system"])
        response = nonlinear.Response.load(file["response/nominal"])
    assert kept is not None
    assert kept.verdict == nonlinear.MODULATED
    assert settled.verdict == "modulated"
    # The same from the library, of another disturbance.
    again = nonlinear.settled_response(system, response, found.peak.point, seed=5, least=300)
    axial = int(abs(response.amplitude[found.peak.point, 0] - found.peak.amplitude).argmin())
    for name in ("mean", "largest", "smallest"):
        assert getattr(settled, name) == getattr(kept, name)[0, axial]
        assert getattr(settled, name) == pytest.approx(getattr(again, name)[0, axial], rel=1e-2)
    assert settled.largest > 1.02 * found.peak.amplitude
    low, high = (f"{1e6 * each:.4g}" for each in (settled.smallest, settled.largest))
    (line,) = (line for line in found.warnings if "UNSTABLE" in line)
    assert f"integrated in time it vibrates between {low} and {high} um" in line
    assert "modulated" in line
    page = (folder / "report.html").read_text("utf-8")
    assert f"integrated in time it vibrates between {low} and {high} µm" in page
    tables = {each.key: each for each in events if hasattr(each, "columns")}
    (row,) = tables["settled"].record()["rows"]
    assert row["balance_um"] == pytest.approx(1e6 * found.peak.amplitude)
    assert row["largest_um"] == pytest.approx(1e6 * settled.largest)
    assert (row["settled"], row["periods"]) == ("modulated", kept.periods)


@pytest.mark.parametrize(
    ("asked", "frequencies"), [("[settled]\n", "[250, 300]"), ("", "[310, 370]")]
)
def test_stable_peaks_and_unasked_ones_are_not_followed(tmp_path, asked, frequencies):
    path = scene(tmp_path, f"range = {frequencies}", asked)
    (found,) = run_scene(load_scene(path), tmp_path / "run")
    assert found.wave.verdict == ("stable" if asked else "unstable")
    assert found.wave.settled is None
    with h5py.File(tmp_path / "run" / "results.h5") as file:
        assert "settled" not in file["response/nominal"]
