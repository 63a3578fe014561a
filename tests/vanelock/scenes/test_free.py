"""Scenes that nothing holds, and components that their kept nodes alone do not hold."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from tests.vanelock.scenes.conftest import Write, joined, load, write_model
from vanelock import load_scene, run_scene
from vanelock.fem import Material, assemble
from vanelock.mesh import Part
from vanelock.nonlinear import linear_response, static_response, stuck_modes
from vanelock.stages.response.limits import limits

STEEL = Material(E=210e9, nu=0.3, rho=7800)


@pytest.fixture
def beam(lattice: Callable[..., Part], tmp_path: Path):
    """A free beam of 0.3 x 0.02 x 0.01 m, its matrices, and its component in a scene file."""
    model = assemble(lattice((15, 2, 1), lambda p: p * [0.3, 0.02, 0.01], "hexahedron"), STEEL)
    return model, write_model(tmp_path, model, "beam")


def pushed(node: int, harmonic: int, direction: str) -> str:
    return load("beam", node, direction, 1, f"harmonic = {harmonic}\n")


@pytest.mark.parametrize("nodes", [1, 2])
def test_free_beam_is_solved_from_its_end(beam, scene_file: Write, nodes: int) -> None:
    """As its whole matrices say; about one or two nodes it could turn, which more nodes prevent."""
    model, text = beam
    kept = [len(model.part.points), 1][:nodes]
    last, asked = kept[0], model.dofs[np.array(kept) - 1]
    shaken = asked[0]
    text += (
        pushed(last, 1, "[0, 1, 2]") + pushed(last, 0, "[3, 0, 1]") + "[damping]\nratio = 1e-9\n"
    )
    text += f"[outputs]\nnodes = {{beam = {kept}}}\n[response]\nmode = 1\n"
    system = joined(scene_file(text))
    assert stuck_modes(system, 0).rigid == 6
    hertz = np.array([20.0, 400.0, 900.0])
    found = linear_response(system, hertz).output[:, 1]
    push = np.zeros(model.K.shape[0])
    push[shaken] = np.array([0, 1, 2]) / np.sqrt(5)
    for f, output in zip(hertz, found, strict=True):
        D = (model.K - (2 * np.pi * f) ** 2 * model.M).tocsc()
        exact = sp.linalg.spsolve(D, push)[asked]
        assert np.abs(output - exact).max() < 1e-3 * np.abs(exact).max()
    # At rest K x = f - M R a, Rᵀ M x = 0, R the rigid motions by their geometry.
    x, y, z = (model.part.points - model.part.points.mean(axis=0)).T
    o, i = np.zeros_like(x), np.ones_like(x)
    R = np.array([[i, o, o], [o, i, o], [o, o, i], [o, -z, y], [z, o, -x], [-y, x, o]])
    R = R.transpose(0, 2, 1).reshape(6, -1).T[np.argsort(model.dofs.ravel())]
    push[shaken] = np.array([3, 0, 1]) / np.sqrt(10)
    MR = model.M @ R
    bordered = sp.block_array([[model.K, MR], [MR.T, None]], format="csc")
    exact = sp.linalg.spsolve(bordered, np.concatenate([push, np.zeros(6)]))[asked]
    still = static_response(system).output[0, 0]
    assert np.abs(still - exact).max() < 1e-6 * np.abs(exact).max()


def test_modes_are_counted_from_the_first_that_vibrates(beam, scene_file: Write) -> None:
    model, text = beam
    text += pushed(1, 1, "[0, 0, 1]")
    found = limits(joined(scene_file(text)), 1)
    values = sp.linalg.eigsh(model.K, 8, model.M, sigma=-1e5)[0]
    exact = np.sqrt(np.sort(values)[6]) / (2 * np.pi)
    assert found.stuck_mode == 6
    assert found.stuck_frequency == pytest.approx(exact, rel=1e-4)
    assert found.free_frequency == found.stuck_frequency


@pytest.mark.parametrize("second", ["[0, 0, -1]", "[0, 0, 1]"])
def test_loads_at_rest_that_do_not_balance_are_reported(beam, tmp_path, scene_file, second):
    _, text = beam
    text += pushed(1, 1, "[0, 0, 1]") + pushed(2, 0, "[0, 0, 1]") + pushed(2, 0, second)
    text += "[outputs]\nshow = []\n[response]\npoints = 3\n"
    (summary,) = run_scene(load_scene(scene_file(text)), tmp_path / "run")
    warned = [line for line in summary.warnings if "do not balance each other" in line]
    assert len(warned) == (second == "[0, 0, 1]")
