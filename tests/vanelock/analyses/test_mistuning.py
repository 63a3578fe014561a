"""Mistuned rings as stages of a run: what they are, files, workers, what is refused."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from tests.nonlinear.forced_response.ring.test_ring_response import damped
from tests.vanelock.analyses.test_tables import case_of
from vanelock import load_scene, nonlinear, run_scene
from vanelock.analyses.mistuning import (
    MISTUNING,
    MistunedRing,
    MistunedRings,
    MistuningKeys,
    _drawn,
)
from vanelock.rom import System
from vanelock.stages.response.summary import Peak

pytestmark = pytest.mark.usefixtures("undrawn")
DEVIATIONS = {"contacts.contact.mu": 0.1, "contacts.contact.kn": 0.05}
DRAWN = "[mistuning]\nrings = 3\n[mistuning.keys.contacts.contact]\nmu = 0.1\nkn = 0.05\n"


def ring_scene(folder: Path, more: str) -> tuple[Path, System, list[float]]:
    """A scene of a ring's matrices around its peak."""
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
