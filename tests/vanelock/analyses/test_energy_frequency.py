"""Energies of damped modes, against the motion of every mass of the ring in time."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.verification.nonlinear.spring_rings import spring_ring
from vanelock import load_scene, nonlinear, run_scene
from vanelock.analyses.energy_frequency import EnergyFrequency

pytestmark = pytest.mark.usefixtures("undrawn")
STEPS = 64


def test_the_energy_is_twice_the_kinetic_energy_of_a_sector_on_average(tmp_path: Path) -> None:
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
