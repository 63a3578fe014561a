"""Peaks asked for to an accuracy are that accurate, in a few scenes of the benchmark.

Scenes, references and errors are those of benchmarks/accuracy/peaks.py, which has all of them.
"""

import pytest

from benchmarks.accuracy import peaks
from tests.verification.conftest import FULL

SCENES = (10, 15) if FULL else (15,)
ACCURACIES = (3e-2, 1e-2, 1e-3) if FULL else (1e-2,)


@pytest.fixture(scope="module", name="folder")
def folder_fixture(tmp_path_factory):
    return peaks.Folder(tmp_path_factory.mktemp("scenes"))


@pytest.mark.parametrize("number", SCENES)
def test_peak_is_as_accurate_as_asked(folder, number, record_property):
    scene = peaks.draw(number)
    known = folder.known(scene)
    record_property("doubt of the reference", f"{known['doubt']:.0e}")
    assert known["doubt"] < min(ACCURACIES) / 5
    for accuracy in ACCURACIES:
        run = folder.by_accuracy(scene, accuracy)
        amplitude = abs(run.amplitude / known["amplitude"] - 1)
        frequency = abs(run.frequency / known["frequency"] - 1)
        stated = f"stated {run.amplitude_estimate:.0e}"
        kept = f"{run.harmonics} harmonics, {run.points} points"
        record_property(
            f"{accuracy:g}", f"{amplitude:.1e}, {stated}; frequency {frequency:.1e}; {kept}"
        )
        assert run.lost == 0
        assert amplitude < accuracy
        assert frequency < accuracy
