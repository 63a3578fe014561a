"""Damped modes, their energies, wear over cycles and mistuned rings: what files and page have."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from tests.nonlinear.forced_response.ring.test_ring_response import damped
from tests.vanelock.analyses.test_tables import case_of
from tests.verification.nonlinear.spring_rings import spring_ring
from vanelock import load_scene, nonlinear, open_results, run_scene
from vanelock.analyses.damped_modes import FollowedMode
from vanelock.analyses.energy_frequency import EnergyFrequency
from vanelock.analyses.mistuning import (
    MISTUNING,
    MistunedRing,
    MistunedRings,
    MistuningKeys,
    _drawn,
)
from vanelock.analyses.solved_case import SolvedCase
from vanelock.analyses.wear import WornCase
from vanelock.pipeline.progress import Begun, PointDone
from vanelock.rom import System
from vanelock.stages.response.summary import Peak

pytestmark = pytest.mark.usefixtures("undrawn")


N, HOUR = 8, 3600.0


@pytest.fixture
def run(golden):
    made = golden("everything")
    (found,) = made.summaries
    return made.folder, found, made.events


def test_modes_are_those_of_the_library(run):
    folder, _, events = run
    with h5py.File(folder / "results.h5") as file:
        system = nonlinear.System.load(file["response/nominal/system"])
        group = file["response/nominal/damped_modes"]
        forward, backward = (FollowedMode.load(group[f"mode_2_nd_{k}"]) for k in (1, -1))
    mode, driven = forward.mode, forward.driven
    assert mode is not None
    assert driven is not None
    assert not mode.ended
    again = nonlinear.damped_mode(system, 2, None, nonlinear.Options(1), 1)
    np.testing.assert_allclose(mode.damping_ratio, again.damping_ratio, rtol=1e-9)
    # A wave that turns the other way is as stiff and as damped, and the air drives one of the two.
    assert backward.mode is not None
    np.testing.assert_allclose(backward.mode.linear, mode.linear, rtol=1e-6)
    air = {k: -2e3 + k * 8e4 * np.sin(2 * np.pi / N) for k in (1, -1)}  # Im A, by hand
    omega = 2 * np.pi * mode.linear[0]
    for k, each in ((1, forward), (-1, backward)):
        assert each.driven is not None
        assert each.driven.aerodynamic_damping == pytest.approx(-air[k] / (2 * omega**2), rel=1e-6)
    rows = {each.key: each.record()["rows"] for each in events if hasattr(each, "columns")}
    assert [row["rest"] for row in rows["flutter"]] == ["grows", "decays"]
    assert rows["damped_modes"][0]["rest_hz"] == mode.linear[0]
    (line,) = (line for line in run[1].warnings if "FLUTTERS" in line)
    assert "mode 2 of nodal diameter 1" in line
    steps = [each for each in events if isinstance(each, Begun | PointDone)]
    begun = steps.index(next(each for each in steps if "damped mode" in str(each)))
    assert isinstance(steps[begun + 1], PointDone)


def test_analyses_take_the_harmonics_of_the_peak_where_an_accuracy_chooses(golden):
    run = golden("accuracy")
    with open_results(run.folder / "results.h5") as file:
        response = nonlinear.Response.load(file["response/nominal"])
    chosen = response.estimates.harmonics
    fewest = int(np.argmin(chosen))
    assert chosen[fewest] < response.harmonics
    case: Any = SolvedCase.__new__(SolvedCase)
    vars(case).update(response=response, peak=Peak(fewest, 250.0, 1e-6, at_edge=False))
    assert case.options.harmonics == chosen[fewest]


def test_worn_joints_vibrate_as_the_history_says(run):
    folder, found, events = run
    with h5py.File(folder / "results.h5") as file:
        system = nonlinear.System.load(file["response/nominal/system"])
        history = WornCase.load(file["response/nominal/wear"]).history
        answers = dict(file["response/nominal/answers"].attrs)
    assert history is not None
    assert history.status == "cycles done"
    assert history.cycles[-1] == 3e6
    assert history.amplitude[0] == pytest.approx(found.peak.amplitude, rel=5e-3)
    hook = np.array(system.contacts.joints) == "hook"
    lost = history.interference[0] - history.interference[-1]
    assert (lost[hook] == 0).all()
    assert (lost[~hook] > 0).any()
    # The end, solved afresh: its joints as worn, under the load of its dwell.
    worn = history.system_at(system, -1)
    np.testing.assert_allclose(worn.force[1].vector, 1.2 * system.force[1].vector)
    afresh = nonlinear.frequency_response(worn, history.frequency[-1:], nonlinear.Options(1))
    node = system.output_names.index(history.output)
    size = afresh.amplitude[0, node, history.direction]
    assert size == pytest.approx(history.amplitude[-1], rel=1e-6)
    # What is worn at first is what the page says of the peak by itself.
    written = (folder / "figures" / "wear_nominal.csv").read_text().splitlines()
    lines = [line.split(",") for line in written if not line.startswith("#")]
    depth = next(i for i, head in enumerate(lines[0]) if head.startswith("worn depth"))
    hour = HOUR * history.frequency[0] * history.rate[0].max()
    assert max(float(line[depth] or 0) for line in lines[1:]) == pytest.approx(1e6 * hour, rel=2e-2)
    assert answers["goodman_reserve_worn"] < answers["goodman_reserve"]
    last = nonlinear.audit_response(worn, history.response.at([-1]), samples=1 << 12)
    assert last.residual[0] < 1e-3
    rows = {each.key: each.record()["rows"] for each in events if hasattr(each, "columns")}
    assert rows["wear"][-1]["amplitude_um"] == pytest.approx(1e6 * history.amplitude[-1])
    page = (folder / "report.html").read_text("utf-8")
    for text in ("Damped modes", "Flutter", "Wear over cycles", "3e+06 cycles of wear", "worn"):
        assert text in page, text
    for name in ("damped_modes", "wear_over_cycles"):
        assert (folder / "figures" / f"{name}_nominal.png").exists()
        assert (folder / "figures" / f"{name}_nominal.csv").exists()


STEPS = 64


def test_the_energy_is_twice_the_kinetic_energy_of_a_sector_on_average(tmp_path):
    ring, events, k = spring_ring(1), list[Any](), -1
    ring.save(tmp_path / "ring.h5")
    (tmp_path / "scene.toml").write_text(
        '[system]\nfile = "ring.h5"\n[response]\nfrequencies = [0.1, 0.2]\nharmonics = 3\n'
        "[damped_modes]\nmodes = [2]\n[outputs]\nshow = ['report']\n"
    )
    run_scene(load_scene(tmp_path / "scene.toml"), tmp_path / "run", events.append)
    with h5py.File(tmp_path / "run" / "results.h5") as file:
        kept = EnergyFrequency.load(file[f"response/nominal/energy_frequency/mode_2_nd_{k}"])
    mode = nonlinear.damped_mode(ring, 2, None, nonlinear.Options(3), k % ring.sectors)
    np.testing.assert_allclose(kept.frequency, mode.frequency, rtol=1e-9)
    np.testing.assert_allclose(kept.damping_ratio, mode.damping_ratio, rtol=1e-9)
    mass, turn, N = np.diag(ring.at(0).M).real, np.arange(STEPS) / STEPS, ring.sectors
    for p, omega in enumerate(2 * np.pi * mode.frequency):
        velocity = np.zeros((N, STEPS, len(mass)))
        for h, x in mode.response.x.items():
            wave = np.exp(2j * np.pi * h * (turn + k * np.arange(N)[:, None] / N))
            velocity += (1j * h * omega * wave[:, :, None] * x[p]).real
        kinetic = 0.5 * (velocity**2 * mass).sum() / (N * STEPS)
        assert kept.energy[p] == pytest.approx(2 * kinetic, rel=1e-9)
    # Small vibration is that of the linear mode: half of the square of speed and modal amplitude.
    speed = 2 * np.pi * mode.linear[0] * mode.amplitude[0]
    assert kept.energy[0] == pytest.approx(0.5 * speed**2, rel=1e-3)
    (table,) = (each for each in events if getattr(each, "key", "") == "energy_frequency")
    (row,) = table.record()["rows"]
    assert (row["least_j"], row["end_j"]) == (kept.energy[0], kept.energy[-1])
    assert (tmp_path / "run" / "figures" / "energy_frequency_nominal.csv").exists()
    assert "Energy-frequency diagram" in (tmp_path / "run" / "report.html").read_text("utf-8")


DEVIATIONS = {"contacts.contact.mu": 0.1, "contacts.contact.kn": 0.05}
DRAWN = "[mistuning]\nrings = 3\n[mistuning.keys.contacts.contact]\nmu = 0.1\nkn = 0.05\n"


def ring_scene(folder: Path, more: str) -> tuple[Path, System, list[float]]:
    system, peak = damped(0, "slip")
    system.save(folder / "ring.h5")
    hertz = (peak * np.array([0.98, 0.99, 1.0, 1.01, 1.02])).tolist()
    path = folder / "scene.toml"
    path.write_text(
        f'[system]\nfile = "ring.h5"\n'
        f"[response]\nfrequencies = {hertz}\n"
        f'[outputs]\nmonitor = "{system.output_names[0]}, radial"\nshow = ["report"]\n{more}'
    )
    return path, system, hertz


def rings_of(folder: Path) -> MistunedRings:
    with h5py.File(folder / "results.h5") as file:
        return MistunedRings.load(file["response/nominal/mistuning"])


def test_rings_of_a_run_are_those_drawn(tmp_path):
    path, system, hertz = ring_scene(tmp_path, DRAWN)
    (found,) = run_scene(load_scene(path), tmp_path / "run")
    rings = rings_of(tmp_path / "run")
    keys = MistuningKeys.model_validate({"keys": DEVIATIONS})
    for number in range(3):
        one = _drawn(system, keys, (1, number))
        own = nonlinear.ring_response(system, hertz, one, nonlinear.Options(3))
        amplitude = own.amplitude[:, :, 0, 0]
        np.testing.assert_allclose(rings.amplitude[number], amplitude.max(axis=0), rtol=1e-8)
        at = np.array(hertz)[amplitude.argmax(axis=0)]
        np.testing.assert_allclose(rings.frequency[number], at, rtol=1e-12)
    assert rings.place is not None
    assert rings.amplitude[rings.place] == rings.amplitude.max()
    assert rings.tuned == pytest.approx(found.peak.amplitude, rel=1e-8)
    assert rings.lost.tolist() == [0, 0, 0]
    text = (tmp_path / "run" / "report.html").read_text()
    assert "Mistuned rings" in text
    lines = (tmp_path / "run" / "figures" / "mistuning_nominal.csv").read_text().splitlines()
    numbers = [line for line in lines if line[:1].isdigit()]
    assert len(numbers) == 3 * system.sectors


@pytest.mark.system
def test_workers_find_the_same_rings_to_the_bit(tmp_path):
    scene = load_scene(ring_scene(tmp_path, DRAWN)[0])
    for name, workers in (("here", 1), ("there", 2)):
        run_scene(scene, tmp_path / name, workers=workers)
    here, there = rings_of(tmp_path / "here"), rings_of(tmp_path / "there")
    assert np.array_equal(here.amplitude, there.amplitude)
    assert np.array_equal(here.worst.amplitude, there.worst.amplitude)


def test_given_segments_are_one_ring_which_turns_with_them(tmp_path):
    system, _ = damped(0, "slip")
    given = np.linspace(-0.2, 0.2, system.sectors)
    found = []
    for steps in (0, 1):
        turned = [float(each) for each in np.roll(given, steps)]
        folder = tmp_path / f"{steps}"
        folder.mkdir()
        path, *_ = ring_scene(folder, f"[mistuning]\nkeys.contacts.contact.mu = {turned}\n")
        run_scene(load_scene(path), folder / "run")
        found.append(rings_of(folder / "run"))
    assert found[0].amplitude.shape == (1, system.sectors)
    turned_back = np.roll(found[1].amplitude, -1, axis=1)
    np.testing.assert_allclose(turned_back, found[0].amplitude, rtol=1e-8)


def rings(amplitude: Any, converged: Any, alike: float = 1e-6) -> MistunedRings:
    amplitude, converged = np.array(amplitude, float), np.array(converged, bool)
    hertz = np.linspace(100.0, 101.0, len(converged))
    worst = MistunedRing(hertz, amplitude, converged, alike)
    known = worst.known
    return MistunedRings(
        amplitude=np.where(known.max(axis=0) < 0, np.nan, known.max(axis=0))[None],
        frequency=worst.frequency[known.argmax(axis=0)][None],
        tuned=np.array([alike]),
        points=np.array([len(converged)]),
        lost=np.array([np.count_nonzero(~converged)]),
        at_edge=np.array([known.max(axis=1).argmax() in (0, len(known) - 1)]),
        worst=worst,
    )


def test_points_that_are_lost_count_for_nothing_and_are_warned_of():
    case: Any = SimpleNamespace(peak=Peak(1, 101.0, 1e-6, at_edge=False))
    found = rings([[1e-6, 2e-6], [9e-6, 9e-6], [1e-6, 1e-6]], [True, False, True])
    assert found.place == (0, 1)
    assert found.largest.tolist() == [2.0]
    lost, edge = MISTUNING.warnings(case, [found])
    assert lost.startswith("1 of 3 points of mistuned rings DID NOT CONVERGE")
    assert "vibrate most at the end of the frequency range" in edge
    (table,) = MISTUNING.tables({"a": case_of(mistuning=[found])})
    (row,) = table.record()["rows"]
    assert row["lost"] == 1
    nothing = rings([[1e-6, 2e-6]], [False])
    assert nothing.place is None
    assert list(MISTUNING.tables({"a": case_of(mistuning=[nothing])}))
    higher: Any = SimpleNamespace(peak=Peak(1, 101.0, 2e-6, at_edge=False))
    assert "compared with" in list(MISTUNING.warnings(higher, [found]))[-1]
