"""The references that the benchmark programs measure errors against."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.solver import jenkins
from vanelock.nonlinear import SLIP, Options, frequency_response

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize(("harmonics", "friction"), [(3, "orthogonal"), (1, "isotropic")])
def test_marched_friction_converges_to_located_events(
    monkeypatch: pytest.MonkeyPatch, harmonics: int, friction: str
) -> None:
    monkeypatch.setattr(jenkins, "_steps", jenkins._steps.py_func)  # compiling would take longer
    given = jenkins.problem(12, 2, severity=30.0)
    hertz = 0.97 * given.resonance()
    response = frequency_response(given.system(), [hertz], Options(harmonics, friction=friction))
    assert response.converged.all()
    assert np.all(response.state == SLIP)
    u = response.contact[0, 1, :, 1:]
    turning = [np.abs(u[:, 0] + sign * 1j * u[:, 1]) for sign in (1, -1)]
    axes = np.abs(turning[0] - turning[1]) / (turning[0] + turning[1])
    assert axes.min() > 0.3  # ellipses, so that the two laws differ
    q = response.contact[0, :, :, 1:].reshape(harmonics + 1, -1)
    errors = []
    for samples in (128, 1024):
        reference, change = jenkins.reference(given, hertz, 1.01 * q, samples, friction)
        assert change < 1e-12
        errors.append(np.abs(reference - q).max() / np.abs(q).max())
    # Events between samples cost an error of second order: 64 times less at 8 times as many.
    assert errors[0] < 1e-3
    assert errors[1] < 3e-5
    assert errors[1] < errors[0] / 20


def test_peer_says_what_it_needs() -> None:
    command = [sys.executable, "-m", "benchmarks.peers.peer"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 1
    assert done.stderr.startswith("--peer-python: not given: needs the interpreter")
    assert done.stderr.count("\n") == 1
