"""The Brake-Reuss beam, coarse, against published figures, beam theory and its raw matrices."""

from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

from tests.vanelock.scenes.conftest import EXAMPLES, frequencies, generator
from vanelock import load_scene, run_scene
from vanelock.nonlinear import static_bounds
from vanelock.rom import System

AREA = 2921.03e-6  # m^2, of the lap less its bores: Porter and Brake (2023)
BOLTS = 3 * 12249.0  # N
SLIP, OPEN, SLIP_OPEN = 1, 2, 3  # of `Response.state`


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("beam")
    generator("brake_reuss", found).main(columns=6, divisions=1, layers=1)
    text = (EXAMPLES / "brake_reuss" / "scene.toml").read_text()
    node = (found / "tip.csv").read_text().split()[-1]
    text = text.replace("left 23, y", f"left {node}, y").replace("points = 61", "points = 3")
    text = text.replace("harmonics = 3", "harmonics = 1")
    text = text.replace("127.6 N", f"{BOLTS / len(numbers(found / 'washers.csv')):.9g} N")
    (found / "scene.toml").write_text(text.replace("[outputs]", "[outputs]\nshow = ['loops']"))
    return found


def numbers(path: Path) -> list[int]:
    return [int(word) for word in path.read_text().split()[1:]]


@pytest.fixture(scope="module")
def summary(folder, tmp_path_factory):
    into = tmp_path_factory.mktemp("run")
    (found,) = run_scene(load_scene(folder / "scene.toml"), into)
    return found, into


def raw(folder: Path) -> tuple[sp.csc_array, sp.csc_array, sp.csc_array]:
    """K and M of both halves, and the springs of the pairs."""
    halves = [sp.load_npz(folder / f"{name}_K.npz") for name in ("left", "right")]
    M = sp.load_npz(folder / "M.npz")
    n = M.shape[0]
    own, mate, kn, kt = np.loadtxt(folder / "pairs.csv", delimiter=",", skiprows=1).T
    springs = np.column_stack([kt, kt, kn]).ravel()
    at = [(3 * (a.astype(int)[:, None] - 1) + np.arange(3)).ravel() for a in (own, mate)]
    each, c = np.arange(len(springs)), len(springs)
    B = sp.csc_array((np.ones(c), (each, at[0])), shape=(c, 2 * n))
    B = B - sp.csc_array((np.ones(c), (each, at[1] + n)), shape=(c, 2 * n))
    return sp.block_diag(halves, "csc"), sp.block_diag([M, M], "csc"), B.T @ (springs[:, None] * B)


def elastic(K: sp.csc_array, M: sp.csc_array, rigid: int, count: int) -> np.ndarray:
    squared = eigsh(K, rigid + count, M, sigma=-((2 * np.pi * 100.0) ** 2))[0]
    return np.asarray(np.sqrt(np.sort(squared)[rigid:]) / (2 * np.pi))


def test_lap_and_mass_are_the_published_ones(folder):
    shares = np.loadtxt(folder / "pairs.csv", delimiter=",", skiprows=1)[:, 2] / 1e12
    assert (shares > 0).all()
    assert shares.sum() == pytest.approx(AREA, rel=0.02)  # bores of four sides
    mass = sp.load_npz(folder / "M.npz").sum() / 3
    volume = 25.4e-3**2 * 0.3 + 25.4e-3 / 2 * shares.sum()
    assert mass == pytest.approx(7784 * volume, rel=1e-6)


def test_frequencies_are_those_of_the_raw_matrices(folder, summary):
    """Six motions that nothing holds with the contacts stuck, twelve with them open."""
    K, M, springs = raw(folder)
    with h5py.File(summary[1] / "results.h5") as file:
        for which, matrix, rigid in (("free", K, 12), ("stuck", K + springs, 6)):
            ours = frequencies(file, which)
            exact = elastic(matrix, M, rigid, len(ours) - rigid)
            assert ours[rigid:] == pytest.approx(exact, rel=1e-4)


def test_bolts_press_at_rest_and_the_lap_slides_without_lift_off(summary):
    """What is open at rest stays so; friction that sticks changes nothing of the forces at rest."""
    with h5py.File(summary[1] / "results.h5") as file:
        found = static_bounds(System.load(file["system"]))
    np.testing.assert_allclose(found.rest_load, [[BOLTS] * 3], rtol=1e-6)
    with h5py.File(summary[1] / "results.h5") as file:
        found = file["response/nominal"]
        state, rest = found["state"][()], found["preload/force"][0, 0, :, 0].real
    assert rest.sum() == pytest.approx(BOLTS, rel=1e-9)
    assert summary[0].converged == len(state)
    np.testing.assert_array_equal(state == OPEN, np.tile(rest < 1e-9 * BOLTS, (len(state), 1)))
    assert not (state == SLIP_OPEN).any()
    assert (state == SLIP).any()
    assert 0 < summary[0].of_stuck < 1


def test_tip_moves_as_the_raw_matrices_say(folder, summary):
    """The linear peak, stuck: of a mode alone, the load's and the output's node the same."""
    K, M, springs = raw(folder)
    squared, shapes = eigsh(K + springs, 8, M, sigma=-((2 * np.pi * 100.0) ** 2))
    node = numbers(folder / "tip.csv")[0]
    along = shapes[3 * (node - 1) + 1, :]
    second = np.argsort(squared)[7]
    peak = along[second] ** 2 / squared[second] / (2 * 0.00087)  # of 1 N
    found = summary[0]
    assert found.peak is not None
    assert found.peak.amplitude / found.of_stuck == pytest.approx(peak, rel=2e-3)
