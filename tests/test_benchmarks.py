"""The references that the benchmark programs measure errors against."""

import subprocess
import sys
from importlib import import_module, util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from vanelock.nonlinear import SLIP, frequency_response

FOLDER = Path(__file__).resolve().parent.parent / "benchmarks"


@pytest.fixture(scope="module", name="jenkins")
def jenkins_fixture() -> ModuleType:
    spec = util.spec_from_file_location("jenkins", FOLDER / "jenkins.py")
    assert spec is not None
    assert spec.loader is not None
    module = util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look for it
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("harmonics", [1, 3])
def test_marched_friction_converges_to_located_events(jenkins: ModuleType, harmonics: int) -> None:
    given = jenkins.problem(12, 2, severity=30.0)
    hertz = 0.97 * given.resonance()
    response = frequency_response(given.system(), [hertz], harmonics)
    assert response.converged.all()
    assert np.all(response.state == SLIP)
    q = response.contact[0, :, :, 1:].reshape(harmonics + 1, -1)
    errors = []
    for samples in (256, 4096):
        reference, change = jenkins.reference(given, hertz, 1.01 * q, samples)
        assert change < 1e-12
        errors.append(np.abs(reference - q).max() / np.abs(q).max())
    # Events between samples cost an error of second order: 256 times less at 16 times as many.
    assert errors[0] < 1e-3
    assert errors[1] < 2e-6
    assert errors[1] < errors[0] / 40


def test_peer_says_what_it_needs() -> None:
    done = subprocess.run(
        [sys.executable, str(FOLDER / "peer.py")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr.startswith("--peer-python: not given: needs the interpreter")
    assert done.stderr.count("\n") == 1


@pytest.mark.slow
def test_unreduced_truth_and_smaller_models(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(FOLDER))
    reduced = import_module("reduced")
    bench = reduced.Bench("coarse", np.linspace(60.0, 120.0, 4))
    given = {"modes": 10, "interface_modes": 10, "route": "direct"}
    vane, casing, _ = bench.pair(reduced.Setting("", {"modes": 10}, given))
    outcome = bench.compared(vane, casing, 0.0)
    assert bench.sector("stuck", 1).doubt() < 1e-10
    assert bench.doubt_of_response() < 1e-9
    # Ten modes and ten face modes, as published, leave about a per cent on the first ten.
    assert 1e-3 < outcome.worst() < 5e-2
    assert min(error.min() for error in outcome.error.values()) > -1e-9
    # The largest model holds the smaller ones.
    less = {"modes": 6, "interface_modes": 5, "route": "direct"}
    direct = bench.pair(reduced.Setting("", {"modes": 6}, less))
    expected = bench.compared(*direct)
    found = bench.compared(reduced.fewer(vane, 6), reduced.fewer(casing, 6, 5), 0.0)
    for case, error in expected.error.items():
        np.testing.assert_allclose(found.error[case], error, rtol=1e-4, atol=1e-9)
