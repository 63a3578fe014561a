"""Bounds and stability as stages of a run: truths, files, workers, resuming, what is refused."""

from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import h5py
import numpy as np
import pytest

from tests.nonlinear.bounds.test_peak_bounds import held_pad, peak_by_load
from tests.vanelock.scenes.test_joined import rim
from vanelock import load_scene, nonlinear, run_scene
from vanelock.analyses.bounds import BoundedPeak
from vanelock.commands.compare import compared
from vanelock.commands.stored.contents import load_run
from vanelock.common.errors import InputError
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Done, PointDone
from vanelock.pipeline.step import Stages, Step, reachable
from vanelock.rom import Contacts, Diameter, Force, System
from vanelock.stages.matrices.scene_structure import SceneStructure
from vanelock.stages.response.responses import static_bounds_step

pytestmark = pytest.mark.usefixtures("undrawn")

PAD = (
    '[system]\nfile = "pad.h5"\n[response]\nrange = [0.1, 0.3]\nharmonics = 1\n'
    "[bounds]\nstarts = 1\n[stability]\n[outputs]\nshow = []\n"
)


NEAR = "range = [44.0, 56.0]\npoints = 25\n"


def softening() -> System:
    """1 kg on a pressed contact that opens when it moves more than 0.1 mm."""
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


Bounded: TypeAlias = tuple[Path, Any, list[Any]]


@pytest.fixture(scope="module")
def pad_run(tmp_path_factory: pytest.TempPathFactory) -> Bounded:
    """A run of the pad with bounds and stability: its folder, summary and events."""
    folder, events = tmp_path_factory.mktemp("pad"), list[Any]()
    (found,) = run_scene(load_scene(pad_scene(folder)), folder / "run", events.append)
    return folder / "run", found, events


def test_bounds_of_a_run_are_those_of_the_loads_a_clamp_can_hold(
    pad_run: Bounded, tmp_path: Path
) -> None:
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


def test_bounds_are_of_the_law_that_the_run_is_solved_with(tmp_path: Path) -> None:
    # Slid along the bisector of both directions, a contact holds as much as along one of them.
    pad = held_pad(1.0)
    one = pad.diameters[0]
    turned = one.own.copy()
    turned[:, 1:] = np.sqrt(0.5) * one.own[:, 1:2]
    path = pad_scene(tmp_path)
    path.write_text(path.read_text().replace("starts = 1", "starts = 0"))
    replace(pad, diameters={0: replace(one, own=turned)}).save(tmp_path / "pad.h5")
    path.write_text(path.read_text().replace("[response]", '[response]\nfriction = "isotropic"'))
    (found,) = run_scene(load_scene(path), tmp_path / "run")
    with h5py.File(tmp_path / "run" / "results.h5") as file:
        bounded = BoundedPeak.load(file["response/nominal/bounds"]).found
    assert bounded is not None
    for place, end in ((0, found.lowest), (2, found.highest)):
        expected = peak_by_load(1.0, bounded.rest_load[place, 0])
        assert end.amplitude == pytest.approx(expected, rel=1e-9)
    assert found.wave.verdict == "stable"


def test_share_zero_has_the_peak_of_sliders_assembled_at_zero(tmp_path: Path) -> None:
    path = pad_scene(tmp_path, '[sweep]\n"bounds.share" = [0.0, 1.0]')
    path.write_text(path.read_text().replace("starts = 1\n[stability]", "starts = 0"))
    none, full = run_scene(load_scene(path), tmp_path / "run")
    assert none.lowest.amplitude == none.highest.amplitude
    assert full.lowest.amplitude < none.lowest.amplitude < full.highest.amplitude
    assert none.peak == full.peak


@pytest.mark.system
def test_workers_find_the_same_to_the_bit(tmp_path: Path) -> None:
    sweep = '[contacts.pad]\nmu = 0.5\n[sweep]\n"contacts.pad.mu" = [0.4, 0.5, 0.6]'
    scene = load_scene(pad_scene(tmp_path, sweep))
    here = run_scene(scene, tmp_path / "here")
    there = run_scene(scene, tmp_path / "there", workers=2)
    for one, other in zip(here, there, strict=True):
        assert (one.lowest, one.highest, one.wave) == (other.lowest, other.highest, other.wave)
        assert one.lowest.amplitude < one.highest.amplitude


def test_a_run_goes_on_where_it_was_stopped(pad_run: Bounded, tmp_path: Path) -> None:
    scene = load_scene(pad_scene(tmp_path))
    stopped = list[int]()

    class Stopped(BaseException):
        pass

    def stop(event: object) -> None:
        if isinstance(event, PointDone) and event.total is None:
            stopped.append(event.done)
            if len(stopped) == 5:
                raise Stopped

    with pytest.raises(Stopped):
        run_scene(scene, tmp_path / "run", stop)
    events = list[Any]()
    assert run_scene(scene, tmp_path / "run", events.append)[0].highest == pad_run[1].highest
    done = [each for each in events if isinstance(each, Done)]
    assert [each.cached for each in done if each.stage.startswith("response")] == [True]


def test_a_peak_at_the_end_of_the_range_has_no_bounds(tmp_path: Path) -> None:
    path = pad_scene(tmp_path)
    path.write_text(path.read_text().replace("[0.1, 0.3]", "[0.1, 0.12]"))
    (found,) = run_scene(load_scene(path), tmp_path / "run")
    assert found.lowest is None
    assert any(line.startswith("no bounds of the peak over static") for line in found.warnings)


@pytest.mark.parametrize("direction", ["up", "both"])
def test_bounds_are_of_the_sweep_that_the_run_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, direction: str
) -> None:
    """A preloaded contact that opens softens: the sweep down reaches higher."""
    swept = list[str | None]()

    def bounds(
        system: object, near: object, options: nonlinear.Options, *_: Any, **__: Any
    ) -> None:
        swept.append(options.direction)
        raise InputError("enough")

    monkeypatch.setattr(nonlinear, "peak_bounds", bounds)
    softening().save(tmp_path / "soft.h5")
    text = f'direction = "{direction}"\n[bounds]\n[outputs]\nshow = []\n'
    text = f'[system]\nfile = "soft.h5"\n[response]\nharmonics = 1\n{NEAR}{text}'
    (found,) = run_scene(load_scene(written(tmp_path, text)), tmp_path / "run")
    assert [found.sweeps[0].direction] == swept
    assert swept == ["up" if direction == "up" else "down"]
    if direction == "both":
        assert found.sweeps[0].peak.amplitude > 1.1 * found.sweeps[1].peak.amplitude


def test_static_friction_is_reported_of_the_first_case_that_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By modes of harmonic 0 alone, to the bit what all harmonics' give."""
    real, taken = nonlinear.frequency_response, list[Any]()

    def response(system: System, *rest: Any, **options: Any) -> nonlinear.Response:
        if system.contacts.mu[0] == 0.4:
            raise MemoryError
        return real(system, *rest, **options)

    def bounds(friction: str, system: Step[System], modes: Step[Any]) -> Step[Any]:
        taken.append(modes)
        return static_bounds_step(friction, system, modes)

    monkeypatch.setattr(nonlinear, "frequency_response", response)
    monkeypatch.setattr("vanelock.commands.run.doubts.static_bounds_step", bounds)
    text = PAD.replace("[bounds]\nstarts = 1\n[stability]\n", "").replace("nics = 1", "nics = 3")
    held_pad(1.0).save(tmp_path / "pad.h5")
    path = written(tmp_path, text + '[contacts.pad]\n[sweep]\n"contacts.pad.mu" = [0.4, 0.5, 0.6]')
    found = run_scene(load_scene(path), tmp_path / "run")
    warned = [
        any("static friction of contacts" in line for line in each.warnings) for each in found
    ]
    assert warned == [True, False]
    assert [each.stage for each in reachable(taken)].count("stuck modes") == 1
    system = held_pad(1.0)
    one, three = (
        nonlinear.static_bounds(system, modes=nonlinear.harmonic_modes(system, h).diameters)
        for h in (0, 3)
    )
    np.testing.assert_array_equal(one.rest_load, three.rest_load)


def test_the_sector_of_a_scene_has_the_stability_of_all_its_nodal_diameters(tmp_path: Path) -> None:
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
