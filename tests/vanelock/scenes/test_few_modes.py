"""Components that keep few modes: what that costs is said, or refused, against their matrices."""

from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.linalg as sl

from tests.vanelock.scenes.conftest import chain
from tests.vanelock.scenes.scenes import frequencies
from vanelock import load_scene, run_scene

PAD = (
    '[contacts.pad]\nbetween = ["rod", "ground"]\npairs = [6]\nnormal = [1, 0, 0]\n'
    "kn = 4e4\nkt = 2e5\nmu = 0.2\n[outputs]\nloops = false\nreport = false\n"
    '[[loads]]\ncomponent = "rod"\nnodes = [6]\ndirection = [0, 1, 0]\namplitude = 1\n'
    "[response]\nharmonics = 1\nfrequencies = [3.0, {highest}]\n"
)
ROD = chain(1, 6, (9e4, 3e5, 5e5), ground=1.0, mass=3.0)


def scene_of(tmp_path: Path, keys: str, highest: float) -> str:
    return ROD.write(tmp_path, "rod") + keys + PAD.format(highest=highest)


@pytest.mark.parametrize(
    ("keys", "few"), [("modes = 0\n", True), ('cutoff = "10 Hz"\n', True), ("modes = 3\n", False)]
)
def test_what_few_modes_cost_is_estimated_and_warned_of(tmp_path, scene_file, keys, few):
    """Not below the error against all coordinates; by half of it above at most, contacts free."""
    scene = load_scene(scene_file(scene_of(tmp_path, keys, 12.0)))
    (summary,) = run_scene(scene, tmp_path / "run")
    with h5py.File(tmp_path / "run/results.h5") as file:
        for which, closed in (("free", 0), ("stuck", 1)):
            K = ROD.K.copy()
            K[15:, 15:] += closed * np.diag([4e4, 2e5, 2e5])
            exact = np.sqrt(sl.eigh(K, ROD.M, eigvals_only=True)[0]) / (2 * np.pi)
            error = frequencies(file, which)[0] / exact - 1
            estimate = frequencies(file, f"{which}_error")[0]
            assert error < estimate < (np.inf if closed else 1.5 * error)
    warned = [line for line in summary.warnings if "too few modes are kept" in line]
    assert len(warned) == few
