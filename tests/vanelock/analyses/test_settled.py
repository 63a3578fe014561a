"""A run follows its ring from an unstable peak, and says what it settles at."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import pytest

from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock import load_scene, nonlinear, run_scene
from vanelock.analyses.settled import FollowedPeak

pytestmark = pytest.mark.usefixtures("undrawn")
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


def test_a_run_says_what_its_ring_does_instead_of_an_unstable_wave(tmp_path: Path) -> None:
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
def test_stable_peaks_and_unasked_ones_are_not_followed(
    tmp_path: Path, asked: str, frequencies: str
) -> None:
    path = scene(tmp_path, f"range = {frequencies}", asked)
    (found,) = run_scene(load_scene(path), tmp_path / "run")
    assert found.wave.verdict == ("stable" if asked else "unstable")
    assert found.wave.settled is None
    with h5py.File(tmp_path / "run" / "results.h5") as file:
        assert "settled" not in file["response/nominal"]
