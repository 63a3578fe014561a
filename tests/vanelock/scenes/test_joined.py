"""Joined components against the same structure written out by hand, and rows without mass."""

from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.linalg as sl
import scipy.sparse as sp
from numpy.typing import NDArray

from tests.vanelock.scenes.conftest import Chain, Write, chain, frequencies, joined, refused_by
from vanelock import load_scene, nonlinear, run_scene
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.input.measured.curve import load_measured
from vanelock.nonlinear import Options, frequency_response
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


def test_ties_merge_rotations(tmp_path, scene_file):
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


def test_interference_against_ground_pushes_away(tmp_path, scene_file):
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


N, COUNT = 6, 5
SECTOR = (
    '[contacts.pad]\nbetween = ["rim", "ground"]\npairs = [3]\nnormal = [1, 0, 0]\n'
    "kn = 4e4\nkt = 7e4\nmu = 0.2\n[excitation]\nengine_order = 1\n"
    '[[loads]]\ncomponent = "rim"\nnodes = [2]\ndirection = [0, 1, 0]\namplitude = 1\n'
)


def rim(tmp_path: Path, coordinates: str, keys: str = "low = [1]\nhigh = [5]\nmodes = 6\n") -> str:
    """A scene of a ring whose sectors are chains from one face to the other."""
    text = chain(1, COUNT, (3e5, 2e5, 1e5), ground=0.05).write(tmp_path, "rim") + keys
    points = np.vstack([[1, 0, 0], np.ones((COUNT - 2, 3)), turn(N)[:, 0]])
    rows = "".join(f"{i + 1},{x!r},{y!r},{z!r}\n" for i, (x, y, z) in enumerate(points.tolist()))
    (tmp_path / "rim_nodes.csv").write_text("node,x,y,z\n" + rows)
    ring = f'[ring]\nsectors = {N}\ncoordinates = "{coordinates}"\n'
    return ring + text + 'nodes = "rim_nodes.csv"\n' + SECTOR


@pytest.mark.parametrize("coordinates", ["cartesian", "cylindrical"])
def test_sector_has_the_frequencies_of_the_ring(tmp_path, scene_file, coordinates):
    system = joined(scene_file(rim(tmp_path, coordinates)))
    sector = chain(1, COUNT, (3e5, 2e5, 1e5), ground=0.05)
    around = turn(N) if coordinates == "cartesian" else np.eye(3)
    n = 3 * (COUNT - 1)  # the high node is the next sector's low one
    K, M = np.zeros((N * n, N * n)), np.zeros((N * n, N * n))
    for j in range(N):
        W = np.zeros((3 * COUNT, N * n))
        W[:n, j * n : (j + 1) * n] = np.eye(n)
        following = (j + 1) % N * n
        W[n:, following : following + 3] = around
        K += W.T @ sector.K @ W
        M += W.T @ sector.M @ W
        at = slice(j * n + 6, j * n + 9)
        K[at, at] += np.diag([4e4, 7e4, 7e4])
    full = np.sqrt(sl.eigh(K, M, eigvals_only=True)) / (2 * np.pi)
    for k in (0, 1, 2, 3):
        own = linear_modes(system, k, 6)[0]
        nearest = np.abs(full[:, None] - own).min(axis=0)
        assert (nearest < 1e-8 * own).all()
    assert sorted(system.diameters) == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("low = [1]\nmodes = 3\n", "low: cyclic faces come in pairs: give low and high"),
        ("low = [1]\nhigh = [4, 5]\nmodes = 3\n", "high: 2 nodes, and 1 in low"),
        ("low = [1]\nhigh = [4]\nmodes = 3\n", "node 4 lies .* from where its mate 1"),
        ("low = [1]\nhigh = [9]\nmodes = 3\n", "node 9 is not among the matrices' nodes"),
        ("fixed = [3]\nmodes = 3\n", "fixed: node 3 carries a contact, tie, load or output"),
        ("modes = 900\n", "900 fixed-interface modes of 12 slave dofs"),
    ],
)
def test_faces_that_do_not_fit_are_refused(tmp_path, scene_file, keys, expected):
    with pytest.raises(InputError, match=expected):
        joined(scene_file(rim(tmp_path, "cartesian", keys)))


def test_a_joined_ring_has_its_sectors_and_engine_order_where_speeds_are_given(
    tmp_path, scene_file
):
    """Those of its file, which a scene of a joined system does not repeat."""
    text = rim(tmp_path, "cylindrical").replace("engine_order = 1", "engine_order = 2")
    joined(scene_file(text)).save(tmp_path / "ring.h5")
    (tmp_path / "rig.csv").write_text("speed (rpm), amplitude (um)\n3000, 1\n3600, 2\n")
    text = '[system]\nfile = "ring.h5"\n[response]\nharmonics = 1\npoints = 7\n'
    text += '[measured]\nfile = "rig.csv"\n[outputs]\nshow = ["report"]\n'
    scene = load_scene(scene_file(text))
    (measured,) = load_measured(scene)
    assert measured.frequency.tolist() == [100.0, 120.0]
    assert measured.engine_order == 2
    (found,) = run_scene(scene, tmp_path / "run")
    page = (tmp_path / "run" / "report.html").read_text("utf-8")
    assert found.peak is not None
    assert f"{30 * found.peak.frequency:,.0f} rpm at engine order 2" in page.replace("\xa0", " ")
    for heading in ("Power of one sector at the peak", "Joints of one sector", "Mistuning"):
        assert heading in page, heading


TOUCHES = (
    '[contacts.pad]\nbetween = ["one", "ground"]\npairs = [6]\nnormal = [1, 0, 0]\nkn = 1e4\n'
    'kt = 1e4\nmu = 0.3\ninterference = 1e-6\n[[loads]]\ncomponent = "one"\nnodes = [3]\n'
    "direction = [0, 0, 1]\namplitude = 1\n[response]\nmode = 1\n[outputs]\n"
    "show = []\n"
)
SUPER = 'kind = "superelement"\n'
NEGATIVE = np.kron([[0.1, 0.2], [0.2, 0.1]], np.eye(3))
WITHOUT = {
    "inner": slice(3, 6),
    "at the contact": slice(15, 18),
    "at the load": slice(6, 9),
    "every y": slice(1, None, 3),
}


def scene_of(one: Chain, folder: Path, keys: str, scene_file: Write) -> Path:
    return scene_file(one.write(folder, "one") + keys + TOUCHES)


@pytest.mark.parametrize("keys", ['kind = "superelement"\n', "", "modes = 8\n", "cutoff = 1e4\n"])
@pytest.mark.parametrize("without", WITHOUT)
def test_massless_rows_follow_the_others(tmp_path, scene_file, without, keys):
    """Frequencies are those of the matrices with these rows condensed by hand."""
    one = chain(1, 6, SPRINGS, ground=1.0)
    one.M[WITHOUT[without]] = 0
    system = joined(scene_of(one, tmp_path, keys, scene_file))
    frequency, shapes = linear_modes(system, 0, 4)

    K = one.K.copy()
    K[15:, 15:] += 1e4 * np.eye(3)
    a = one.M.diagonal() > 0
    condensed = K[np.ix_(a, a)] - K[np.ix_(a, ~a)] @ sl.solve(K[np.ix_(~a, ~a)], K[np.ix_(~a, a)])
    exact = np.sqrt(sl.eigvalsh(condensed, one.M[np.ix_(a, a)])[:4]) / (2 * np.pi)
    np.testing.assert_allclose(frequency, exact, rtol=1e-3 if "modes" in keys else 1e-9)
    M = system.diameters[0].M
    np.testing.assert_allclose(shapes.T @ M @ shapes, np.eye(4), atol=1e-9)
    assert frequency_response(system, frequency[:1], Options(3)).converged.all()


@pytest.mark.parametrize(
    ("rows", "block", "keys", "expected"),
    [
        (slice(3, 9), NEGATIVE, SUPER, "mass matrix is not pos"),
        (slice(3, 9), NEGATIVE, "modes = 4\n", "components.one"),
        (slice(3, 6), 0.0, "modes = 13\n", "allowed are 0 to 12"),
    ],
)
def test_what_is_no_mass_is_refused(tmp_path, scene_file, rows, block, keys, expected):
    one = chain(1, 6, SPRINGS, ground=1.0)
    one.M[rows, rows] = block
    refused_by(joined, scene_of(one, tmp_path, keys, scene_file), expected)


PAD = (
    '[contacts.pad]\nbetween = ["rod", "ground"]\npairs = [6]\nnormal = [1, 0, 0]\n'
    "kn = 4e4\nkt = 2e5\nmu = 0.2\n[outputs]\nshow = []\n"
    '[[loads]]\ncomponent = "rod"\nnodes = [6]\ndirection = [0, 1, 0]\namplitude = 1\n'
    "[response]\nharmonics = 1\nfrequencies = [3.0, {highest}]\n"
)
ROD = chain(1, 6, (9e4, 3e5, 5e5), ground=1.0, mass=3.0)


def rod_scene(tmp_path: Path, keys: str, highest: float) -> str:
    return ROD.write(tmp_path, "rod") + keys + PAD.format(highest=highest)


@pytest.mark.parametrize(
    ("keys", "few"), [("modes = 0\n", True), ('cutoff = "10 Hz"\n', True), ("modes = 3\n", False)]
)
def test_what_few_modes_cost_is_estimated_and_warned_of(tmp_path, scene_file, keys, few):
    """Not below the error against all coordinates; by half of it above at most, contacts free."""
    scene = load_scene(scene_file(rod_scene(tmp_path, keys, 12.0)))
    (summary,) = run_scene(scene, tmp_path / "run")
    with h5py.File(tmp_path / "run/results.h5") as file:
        for which, closed in (("free", 0), ("stuck", 1)):
            K = ROD.K.copy()
            K[15:, 15:] += closed * np.diag([4e4, 2e5, 2e5])
            exact = np.sqrt(sl.eigh(K, ROD.M, eigvals_only=True)[0]) / (2 * np.pi)
            error = frequencies(file, which)[0] / exact - 1
            estimate = frequencies(file, f"{which}_error")[0]
            assert error < estimate < (np.inf if closed else 1.5 * error)
    warned = [line for line in summary.warnings if "too few modes are kept" in line]
    assert len(warned) == few
