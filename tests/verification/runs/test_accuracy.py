"""Peaks asked for to an accuracy are that accurate, in a few scenes of the benchmark.

Scenes, references and errors are those of benchmarks/accuracy/peaks.py, which has all of them. The
sample has smaller parts under the same joints and loads, and makes its own references: more modes
and harmonics, and close frequencies about the peak.
"""

import numpy as np
import pytest

from benchmarks.accuracy import peaks
from benchmarks.accuracy.models import Models, prepared
from tests.conftest import FULL
from tests.nonlinear.systems import solved_response
from vanelock.nonlinear import Options, frequency_response

SCENES = (10, 15) if FULL else (15, 17)
ACCURACIES = (3e-2, 1e-2, 1e-3) if FULL else (1e-2,)


@pytest.fixture(scope="module", name="folder")
def folder_fixture(tmp_path_factory):
    return peaks.Folder(tmp_path_factory.mktemp("scenes"))


def drawn(number):
    """A scene, smaller in the sample."""
    scene = peaks.draw(number)
    if not FULL:
        hook = scene.values["vane"]["hook"]
        scene.values["vane"].update(aerofoils=1, interlock_nodes=3, hook={**hook, "band_nodes": 3})
        scene.values["mesh"]["size"] = 0.04
    return scene


def over_resolved(scene, folder):
    """Peak by 7 harmonics, and how much it differs from that by 3."""
    given = prepared(scene, Models(scene, folder.path).reduced(1e-4))
    study, top, found = scene.study(), None, []
    for harmonics in (3, 7):
        options = Options(
            harmonics, coupling=study.response.coupling, friction=study.response.friction
        )
        hertz = given.range if top is None else top * np.linspace(0.999, 1.001, 11)
        swept = solved_response(given.system, hertz, options)
        size = given.monitor.amplitude(swept)
        top = float(swept.frequency[size.argmax()])
        found.append(float(size.max()))
    doubt = abs(found[-2] / found[-1] - 1)
    return {"amplitude": found[-1], "frequency": top, "doubt": doubt}


@pytest.mark.parametrize("number", SCENES)
def test_peak_is_as_accurate_as_asked(folder, number, record):
    scene = drawn(number)
    known = folder.known(scene) if FULL else over_resolved(scene, folder)
    record("doubt of the reference", f"{known['doubt']:.0e}")
    assert known["doubt"] < min(ACCURACIES) / 5
    for accuracy in ACCURACIES:
        run = folder.by_accuracy(scene, accuracy)
        amplitude = abs(run.amplitude / known["amplitude"] - 1)
        frequency = abs(run.frequency / known["frequency"] - 1)
        stated = f"stated {run.amplitude_estimate:.0e}"
        kept = f"{run.harmonics} harmonics, {run.points} points"
        record(
            f"{accuracy:g}", f"{amplitude:.1e}, {stated}; frequency {frequency:.1e}; {kept}"
        )
        assert run.lost == 0
        assert amplitude < accuracy
        assert frequency < accuracy
