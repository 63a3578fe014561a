"""Damped modes, their energies, flutter and wear over cycles: what files and page have."""

from typing import Any

import h5py
import numpy as np
import pytest

from tests.verification.nonlinear.spring_rings import spring_ring
from vanelock import load_scene, nonlinear, run_scene
from vanelock.analyses.damped_modes import FollowedMode
from vanelock.analyses.energy_frequency import EnergyFrequency
from vanelock.analyses.wear import WornCase
from vanelock.pipeline.progress import Begun, PointDone

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
