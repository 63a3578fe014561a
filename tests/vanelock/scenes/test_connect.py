"""Joined components against the same structure written out by hand."""

from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.linalg as sl
import scipy.sparse as sp
from numpy.typing import NDArray

from tests.vanelock.scenes.conftest import Chain, Write, chain, joined
from vanelock import nonlinear
from vanelock.rom import linear_modes

SPRINGS = (3e5, 2e5, 1e5)


def touching() -> str:
    """Contacts of the last nodes of one chain with the first of the other."""
    return (
        '[contacts.lap]\nbetween = ["one", "two"]\npairs = [[3, 11], [2, 12]]\n'
        "normal = [1, 0, 0]\n"
        "tangent = [0, 0, 1]\nkn = 4e4\nkt = 7e4\nmu = 0.2\n"
        '[[loads]]\ncomponent = "two"\nnodes = [13]\ndirection = [0, 1, 0]\namplitude = 2\n'
    )


def by_hand(one: Chain, two: Chain) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stiffness and mass of both chains with the two contacts as springs."""
    K, M = sl.block_diag(one.K, two.K), sl.block_diag(one.M, two.M)
    spring = np.diag([4e4, 7e4, 7e4])  # normal along x, tangents z and y alike
    for a, b in ((2, 3), (1, 4)):
        at = np.r_[3 * a : 3 * a + 3, 3 * b : 3 * b + 3]
        K[np.ix_(at, at)] += np.block([[spring, -spring], [-spring, spring]])
    return K, M


UNITS = 'units = {length = "mm", mass = "t", force = "N"}\n'


@pytest.mark.parametrize("keys", ["modes = 3\n", UNITS, 'kind = "superelement"\n'])
def test_stuck_chains_have_the_frequencies_of_the_whole(tmp_path, scene_file, keys):
    """In SI; in N/mm and t with everything kept by accuracy; and of matrices used as they are."""
    scales = (1e-3, 1e-3) if keys == UNITS else (1.0, 1.0)
    one, two = chain(1, 3, SPRINGS, ground=1.0), chain(11, 4, SPRINGS)
    text = one.write(tmp_path, "one", *scales) + keys + two.write(tmp_path, "two", *scales) + keys
    system = joined(scene_file(text + touching()))
    K, M = by_hand(one, two)
    count = 12 if "kind" not in keys else len(system.diameters[0].K)
    assert count in (12, len(K))
    expected = np.sqrt(sl.eigh(K, M, eigvals_only=True)[:count]) / (2 * np.pi)
    np.testing.assert_allclose(linear_modes(system, 0, count)[0], expected, rtol=1e-9)


def beam(lengths: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Euler-Bernoulli elements in a row, each node's deflection and rotation; consistent mass."""
    size, h = 2 * lengths + 2, 0.1
    K, M = np.zeros((size, size)), np.zeros((size, size))
    stiff = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]]
    stiff += [[-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]
    mass = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2]]
    mass += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]
    for i in range(lengths):
        at = np.ix_(range(2 * i, 2 * i + 4), range(2 * i, 2 * i + 4))
        K[at] += 50.0 / h**3 * np.array(stiff)
        M[at] += 0.8 * h / 420 * np.array(mass)
    return K, M


def test_ties_merge_rotations(tmp_path: Path, scene_file: Write) -> None:
    """Two beams tied end to end bend as one: a hinge between them would not carry the moment."""
    text = ""
    for name, first in (("one", 1), ("two", 11)):
        K, M = beam(3)
        scipy.io.mmwrite(tmp_path / f"{name}_K.mtx", sp.coo_array(K))
        scipy.io.mmwrite(tmp_path / f"{name}_M.mtx", sp.coo_array(M))
        rows = [f"{n},{d}" for n in range(first, first + 4) for d in ("uy", "rotz")]
        (tmp_path / f"{name}_dofs.csv").write_text("\n".join(["node,direction", *rows]) + "\n")
        text += (
            f'[components.{name}]\nstiffness = "{name}_K.mtx"\nmass = "{name}_M.mtx"\n'
            f'dofs = "{name}_dofs.csv"\n' + ("fixed = [1]\n" if first == 1 else "")
        )
    text += (
        '[ties.end]\nbetween = ["one", "two"]\npairs = [[4, 11]]\n'
        '[[loads]]\ncomponent = "two"\nnodes = [14]\ndirection = [0, 1, 0]\namplitude = 1\n'
    )
    K, M = (A[2:, 2:] for A in beam(6))
    frequency, _ = linear_modes(joined(scene_file(text)), 0, 4)
    expected = np.sqrt(sl.eigh(K, M, eigvals_only=True)[:4]) / (2 * np.pi)
    np.testing.assert_allclose(frequency, expected, rtol=1e-9)


def test_interference_against_ground_pushes_away(tmp_path: Path, scene_file: Write) -> None:
    """One node on a spring k, pressed by the overlap δ: v = δ - kn v / k, so v = δ k / (k + kn)."""
    one = chain(1, 2, (1e12, 1e12, 1e12), ground=1e-7)
    text = one.write(tmp_path, "one") + "modes = 2\n"
    text += (
        '[contacts.stop]\nbetween = ["one", "ground"]\npairs = [2]\nnormal = [0, 0, -2]\n'
        'kn = 3e5\nkt = 1e5\nmu = 0.5\ninterference = "20 um"\n'
        '[[loads]]\ncomponent = "one"\nnodes = [1]\ndirection = [0, 0, 1]\namplitude = 1\n'
    )
    static = nonlinear.static_response(joined(scene_file(text)))
    normal = 3e5 * 20e-6 * 1e5 / (1e5 + 3e5)
    assert static.force[0, 0, 0, 0].real == pytest.approx(normal, rel=1e-6)
    assert static.output[0, 0, 0, 2].real == pytest.approx(normal / 1e5, rel=1e-6)  # along +z
