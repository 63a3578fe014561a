"""The references that the benchmark programs measure errors against, and memory."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.mesh import bubbles, error
from benchmarks.rom import reduced
from benchmarks.runs.memory import taken
from benchmarks.segment import MATERIAL
from benchmarks.solver import jenkins
from vanelock import fem, mesh
from vanelock.fem import Material, assemble, eigenpairs
from vanelock.nonlinear import SLIP, Options, frequency_response

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(("harmonics", "friction"), [(3, "orthogonal"), (1, "isotropic")])
def test_marched_friction_converges_to_located_events(monkeypatch, harmonics, friction):
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


def test_peer_says_what_it_needs():
    command = [sys.executable, "-m", "benchmarks.peers.peer"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 1
    assert done.stderr.startswith("--peer-python: not given: needs the interpreter")
    assert done.stderr.count("\n") == 1


HOOK = mesh.HookDimensions(band_nodes=3)
VANE = mesh.VaneDimensions(hook=HOOK, aerofoils=1, interlock_nodes=3, root_fillet=0.0)


@pytest.mark.system
def test_unreduced_truth_and_smaller_models(monkeypatch):
    """On a vane of one aerofoil, of large elements."""
    vane_part, casing_part = (
        mesh.vane_segment(VANE, size=0.05),
        mesh.casing_sector(hook=HOOK, size=0.05),
    )
    monkeypatch.setattr(reduced, "vane_model", lambda size: fem.assemble(vane_part, MATERIAL))
    monkeypatch.setattr(reduced, "casing_model", lambda size: fem.assemble(casing_part, MATERIAL))
    bench = reduced.Bench(0.05, np.linspace(60.0, 120.0, 4))
    given = {"modes": 10, "interface_modes": 10, "interface": "published"}
    vane, casing, _ = bench.pair(reduced.Setting("", {"modes": 10}, given))
    outcome = bench.compared(vane, casing, 0.0)
    assert bench.sector("stuck", 1).doubt() < 1e-10
    assert bench.doubt_of_response() < 1e-9
    # Ten modes and ten face modes, as published, leave about a per cent on the first ten.
    assert 1e-3 < outcome.worst() < 5e-2
    assert min(error.min() for error in outcome.error.values()) > -1e-9
    # The largest model holds the smaller ones; a mode's sign is free.
    less = {"modes": 6, "interface_modes": 5, "interface": "published"}
    few_of_vane, few_of_casing, _ = bench.pair(reduced.Setting("", {"modes": 6}, less))
    for found, expected in (
        (reduced.fewer(vane, 6), few_of_vane),
        (reduced.fewer(casing, 6, 5), few_of_casing),
    ):
        assert found.diameters.keys() == expected.diameters.keys()
        for k, matrices in expected.diameters.items():
            for name in ("K", "M"):
                own, held = (abs(getattr(of, name)) for of in (matrices, found.diameters[k]))
                scale = np.sqrt(np.outer(own.diagonal(), own.diagonal()))
                np.testing.assert_allclose(held / scale, own / scale, rtol=0, atol=1e-9)


def test_bubbles_vanish_at_nodes_and_have_these_slopes():
    nodes = np.vstack([np.zeros(3), np.eye(3)])
    nodes = np.vstack([nodes, [nodes[list(pair)].mean(axis=0) for pair in bubbles.EDGES]])
    assert np.abs(bubbles.bubbles(nodes)[0]).max() < 1e-15
    place, step = np.array([[0.2, 0.3, 0.1]]), 1e-6
    _, slopes = bubbles.bubbles(place)
    for i, e in enumerate(step * np.eye(3)):
        rise = bubbles.bubbles(place + e)[0] - bubbles.bubbles(place - e)[0]
        np.testing.assert_allclose(rise / (2 * step), slopes[..., i], atol=1e-9)


def test_both_estimate_part_of_the_error_of_a_wave_along_a_box(lattice):
    part = lattice((4, 4, 4), lambda p: p * [1.3, 1.0, 1.0])
    model = assemble(part, Material(E=3.0, nu=0.0, rho=1.0))
    rows = model.dofs[:, 0]
    K, M = (A[rows][:, rows].tocsc() for A in (model.K, model.M))
    squared, shapes = eigenpairs(K, M, 4, shift=-1.0)
    true = squared[3] - 3 * (np.pi / 1.3) ** 2  # after the rigid motion and two waves across
    u = np.zeros((len(part.points), 3, 1))
    u[:, 0, 0] = shapes[:, 3]
    assert 0.6 < bubbles.bubble_excess(model, u, squared[3:])[0] / true < 1
    assert 0 < error.averaged_excess(model, u)[0] / true < 1


MOST = 8.0
"""GB that a run of the default study to 1 % may take."""


@pytest.mark.system
def test_a_run_to_one_per_cent_stays_within_eight_gigabytes_and_near_its_forecast(record_property):
    found, said = taken("accuracy = 0.01\n")
    peak = max(found[kind] for kind in ("mesh", "response", "pictures"))
    record_property("result", f"{peak:.2f} GB, {said.memory / 1e9:.2f} forecast")
    assert peak <= MOST
    assert 0.75 <= said.memory / (1e9 * peak) <= 1.34
