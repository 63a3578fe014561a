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


def test_ties_merge_nodes(tmp_path: Path, scene_file: Write) -> None:
    """Two chains tied end to end are one longer chain with a node of twice the mass."""
    one, two = chain(1, 3, SPRINGS, ground=1.0), chain(11, 4, SPRINGS)
    text = one.write(tmp_path, "one") + two.write(tmp_path, "two")
    text += (
        '[ties.end]\nbetween = ["one", "two"]\npairs = [[3, 11]]\n'
        '[[loads]]\ncomponent = "two"\nnodes = [14]\ndirection = [1, 0, 0]\namplitude = 1\n'
    )
    whole = chain(1, 6, SPRINGS, ground=1.0)
    M = whole.M.copy()
    M[6:9, 6:9] *= 2
    frequency, _ = linear_modes(joined(scene_file(text)), 0, 6)
    expected = np.sqrt(sl.eigh(whole.K, M, eigvals_only=True)[:6]) / (2 * np.pi)
    np.testing.assert_allclose(frequency, expected, rtol=1e-9)


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


@pytest.mark.parametrize("coordinates", ["cartesian", "cylindrical"])
def test_a_ring_has_the_frequencies_of_all_its_sectors(tmp_path, scene_file, coordinates):
    """A chain per sector, its last node touching the first of the next sector's chain."""
    N = 5
    blade = chain(1, 3, SPRINGS, ground=0.3)
    text = blade.write(tmp_path, "blade") + "modes = 3\n"
    text += (
        f'[ring]\nsectors = {N}\ncoordinates = "{coordinates}"\n'
        '[contacts.shroud]\nbetween = ["blade", "blade"]\npairs = [[3, 1]]\nnext_sector = true\n'
        "normal = [0, 1, 0]\ntangent = [0, 0, 1]\nkn = 4e4\nkt = 7e4\nmu = 0.2\n"
        '[excitation]\nengine_order = 2\n[[loads]]\ncomponent = "blade"\nnodes = [2]\n'
        "direction = [0, 1, 0]\namplitude = 1\n[outputs]\nnodes = {blade = [2]}\n"
        "[response]\nharmonics = 3\n"
    )
    table = "node,x,y,z\n1,1,0,0\n2,1.1,0,0\n3,1.2,0,0\n"
    (tmp_path / "nodes.csv").write_text(table)
    text = text.replace("modes = 3", 'modes = 3\nnodes = "nodes.csv"')
    system = joined(scene_file(text))

    angle = 2 * np.pi / N if coordinates == "cartesian" else 0.0
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])  # of the next sector, seen from this one
    spring = np.diag([7e4, 4e4, 7e4])
    n = len(blade.K)
    K, M = np.kron(np.eye(N), blade.K), np.kron(np.eye(N), blade.M)
    for j in range(N):
        here, there = j * n + 6, (j + 1) % N * n
        B = np.zeros((3, N * n))
        B[:, here : here + 3], B[:, there : there + 3] = np.eye(3), -turn
        K += B.T @ spring @ B
    expected = np.sqrt(sl.eigh(K, M, eigvals_only=True)) / (2 * np.pi)
    assert sorted(system.diameters) == [0, 1, 2]
    found = np.concatenate(
        [np.repeat(linear_modes(system, k, n)[0], 1 if k == 0 else 2) for k in (0, 1, 2)]
    )
    np.testing.assert_allclose(np.sort(found), expected, rtol=1e-9)


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


def test_columns_of_pairs_stand_in_for_keys(tmp_path: Path, scene_file: Write) -> None:
    one = chain(1, 4, SPRINGS, ground=1.0)
    (tmp_path / "pairs.csv").write_text(
        "node,nx,ny,nz,tx,ty,tz,kn,interference\n2,0,0,5,1,0,1,1e5,1e-6\n3,1,0,0,0,3,0,2e5,-2e-6\n"
    )
    text = one.write(tmp_path, "one") + "modes = 3\n"
    text += (
        '[contacts.pads]\nbetween = ["one", "ground"]\npairs = "pairs.csv"\nkt = 5e4\nmu = 0.1\n'
        '[[loads]]\ncomponent = "one"\nnodes = [4]\ndirection = [0, 0, 1]\namplitude = 1\n'
    )
    system = joined(scene_file(text))
    np.testing.assert_array_equal(system.contacts.kn, [1e5, 2e5])
    np.testing.assert_array_equal(system.contacts.v0, [1e-6, -2e-6])
    rows = system.diameters[0].own[:, :, :9].reshape(2, 3, 3, 3)
    np.testing.assert_allclose(rows[0, :, 0], [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-15)
    np.testing.assert_allclose(rows[1, :, 1], [[1, 0, 0], [0, 1, 0], [0, 0, 1]], atol=1e-15)
    assert not rows[0, :, 1:].any()
