"""Peaks asked for to an accuracy are that accurate, in a few scenes of the benchmark.

Scenes, references and errors are those of benchmarks/accuracy_scenes.py, which has all of them.
"""

from importlib import import_module
from pathlib import Path

import pytest

from tests.verification.conftest import FULL

pytestmark = pytest.mark.slow

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
SCENES = (10, 15) if FULL else (15,)
ACCURACIES = (3e-2, 1e-2, 1e-3) if FULL else (1e-2,)


@pytest.fixture(scope="module", name="program")
def program_fixture():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(BENCHMARKS))
        yield import_module("accuracy_scenes")


@pytest.fixture(scope="module", name="folder")
def folder_fixture(program, tmp_path_factory):
    return program.Folder(tmp_path_factory.mktemp("scenes"))


@pytest.mark.parametrize("number", SCENES)
def test_peak_is_as_accurate_as_asked(program, folder, number, record_property):
    scene = program.draw(number)
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
