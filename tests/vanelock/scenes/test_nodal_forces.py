"""Nodal forces from files: answers of the whole matrices, and no coordinates for loaded nodes."""

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as sl
from numpy.typing import NDArray

from tests.vanelock.scenes.conftest import Chain, chain, joined, planar, refused_by
from vanelock import check_file, load_scene, nonlinear, run_scene
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files import load_pairs
from vanelock.stages.matrices.gather import gathered
from vanelock.stages.matrices.scene_structure import SceneStructure, motions_step

Floats = NDArray[np.float64]

COUNT, OTHER = 40, 25
KN, KT, OVERLAP = 4e5, 3e5, 1e-3
PAIRS = [[20, 101], [21, 102], [22, 103], [40, 125]]
LAP = (
    f'[contacts.lap]\nbetween = ["one", "two"]\npairs = {PAIRS}\nnormal = [0, 0, 1]\n'
    f"tangent = [1, 0, 0]\nkn = {KN}\nkt = {KT}\nmu = 1e6\ninterference = {OVERLAP}\n"
)
SHAKEN = (
    '[[loads]]\ncomponent = "one"\nnodes = [30]\ndirection = [0, 1, 1]\namplitude = 3\n'
    "[outputs]\nnodes = {one = [3, 30, 40], two = [103, 117]}\nshow = []\n"
)
GAS = '[[loads]]\ncomponent = "one"\nfile = "gas.csv"\nharmonic = 0\nscale = -2.5\n'
HEAT = '[[loads]]\ncomponent = "two"\nfile = "heat.csv"\nharmonic = 0\n'


def truss(first: int, count: int, seed: int, ground: float = 0.0) -> Chain:
    """Bars in random directions between each node and the five behind it."""
    rng, each = np.random.default_rng(seed), chain(first, count, (0, 0, 0))
    K = each.K.reshape(count, 3, count, 3)
    for i in range(count):
        for j in range(i + 1, min(i + 6, count)):
            d = rng.normal(size=3)
            bar = 1e5 * np.outer(d, d)
            for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                K[a, :, b, :] += sign * bar
    K[-1, :, -1, :] += ground * np.eye(3)
    return Chain(each.K, np.diag(rng.uniform(0.05, 0.2, 3 * count)), each.nodes)


ONE, TWO = truss(1, COUNT, 3), truss(101, OTHER, 4, ground=2e5)


def write_forces(path: Path, nodes: NDArray[np.int64], forces: Floats) -> None:
    lines = [f"{n},{x!r},{y!r},{z!r}" for n, (x, y, z) in zip(nodes, forces.tolist(), strict=True)]
    path.write_text("\n".join(["node,fx,fy,fz", *lines]) + "\n")


def scene(folder: Path, one: str = "modes = 3\n", two: str = "modes = 2\n") -> str:
    text = ONE.write(folder, "one") + "fixed = [1, 2]\n" + one + TWO.write(folder, "two") + two
    return text + LAP


def random_forces(folder: Path) -> Floats:
    """(65, 3) forces on all nodes of both, clamped ones and those in contact too."""
    forces = np.random.default_rng(8).normal(size=(COUNT + OTHER, 3))
    write_forces(folder / "gas.csv", ONE.nodes, forces[:COUNT])
    write_forces(folder / "heat.csv", TWO.nodes, forces[COUNT:])
    return forces


def whole() -> tuple[Floats, Floats]:
    """Stiffness of all nodes with closed contacts, and the contacts' rows."""
    n = 3 * (COUNT + OTHER)
    K = sl.block_diag(ONE.K, TWO.K)
    B = np.zeros((len(PAIRS), 3, COUNT + OTHER, 3))
    for i, (a, b) in enumerate(PAIRS):
        B[i, :, a - 1], B[i, :, COUNT + b - 101] = np.eye(3), -np.eye(3)
    rows = B.reshape(-1, n)
    return K + rows.T @ np.diag([KT, KT, KN] * len(PAIRS)) @ rows, rows


SHOWN = [2, 29, 39, COUNT + 2, COUNT + 16]


def solved(A: NDArray[np.complex128] | Floats, f: Floats) -> NDArray[np.complex128]:
    """(o, 3) displacements of the outputs, the first two nodes clamped."""
    x = np.zeros(len(A), np.result_type(A, f))
    x[6:] = np.linalg.solve(A[6:, 6:], f.ravel()[6:])
    return x.reshape(-1, 3)[SHOWN]


def overlapping(f: Floats) -> Floats:
    """Forces and what the interference adds to them."""
    spread = np.zeros((len(PAIRS), 3))
    spread[:, 2] = KN * OVERLAP
    return f.ravel() - whole()[1].T @ spread.ravel()


KEPT = {
    "few modes": ("modes = 3\n", "modes = 2\n"),
    "no modes": ("modes = 0\n", "modes = 0\n"),
    "accuracy": ("accuracy = 1e-5\n", ""),
    "as it is": ("modes = 3\n", 'kind = "superelement"\n'),
}


@pytest.mark.parametrize("keys", KEPT.values(), ids=list(KEPT))
def test_rest_is_that_of_the_whole(tmp_path, scene_file, keys):
    forces = random_forces(tmp_path)
    system = joined(scene_file(scene(tmp_path, *keys) + GAS + HEAT + SHAKEN))
    forces[:COUNT] *= -2.5
    rest = nonlinear.static_response(system)
    assert rest.converged.all()
    assert (rest.state == nonlinear.STUCK).all()
    exact = solved(whole()[0], overlapping(forces))
    np.testing.assert_allclose(rest.output[0, 0], exact, atol=1e-10 * np.abs(exact).max())


@pytest.mark.parametrize("keys", KEPT.values(), ids=list(KEPT))
def test_a_uniform_force_is_the_same_from_a_file(tmp_path, scene_file, keys):
    """Vibration by a file, by nodes and direction, and of the whole: phase and scale, too."""
    loaded = np.array([105, 110, 111, 112])
    direction = np.array([1.0, -2.0, 2.0]) / 3
    write_forces(tmp_path / "wave.csv", loaded, np.tile(7 * direction, (4, 1)))
    outputs = SHAKEN[SHAKEN.index("[outputs]") :] + "[damping]\nratio = 0.02\n"
    head = '[[loads]]\ncomponent = "two"\nphase = 35\n'
    by_nodes = f"nodes = {loaded.tolist()}\ndirection = [1, -2, 2]\namplitude = 3.5\n"
    text = scene(tmp_path, *keys)
    ways = (by_nodes, 'file = "wave.csv"\nscale = 0.5\n')
    slow, systems = [1e-7], []
    for way in ways:
        systems.append(joined(scene_file(text + head + way + outputs)))
    responses = [nonlinear.linear_response(system, slow) for system in systems]
    f = np.zeros((COUNT + OTHER, 3))
    f[COUNT + loaded - 101] = 3.5 * direction
    exact = solved(whole()[0], f) * np.exp(1j * np.deg2rad(35))
    for each in responses:
        np.testing.assert_allclose(each.output[0, 1], exact, atol=1e-9 * np.abs(exact).max())
    if "accuracy" in keys[0] or "kind" in keys[1]:
        fast = [nonlinear.linear_response(system, [5.0, 20.0]).output[:, 1] for system in systems]
        np.testing.assert_allclose(fast[1], fast[0], atol=1e-5 * np.abs(fast[0]).max())


def keys_of(path: Path, name: str = "one") -> tuple[str, str, str]:
    given = load_scene(path)
    lists = gathered(given)
    own = SceneStructure(given)
    steps = own.component(name, 0), motions_step(given, name, lists)
    return steps[0].key, steps[1].key, own.system((0,)).key


def test_keys_follow_contents_alone(tmp_path, scene_file):
    forces = random_forces(tmp_path)
    text = scene(tmp_path) + GAS + SHAKEN
    first = keys_of(scene_file(text))
    (tmp_path / "gas.csv").rename(tmp_path / "moved.csv")
    path = scene_file(text.replace("gas.csv", "moved.csv"))
    assert keys_of(path) == first
    other = keys_of(path, "two")
    write_forces(tmp_path / "moved.csv", ONE.nodes, 1.001 * forces[:COUNT])
    assert not set(keys_of(path)) & set(first)
    assert keys_of(path, "two")[:2] == other[:2]
    write_forces(tmp_path / "moved.csv", ONE.nodes, forces[:COUNT])
    scaled = keys_of(scene_file(path.read_text().replace("-2.5", "2")))
    assert scaled[:2] == first[:2]
    assert scaled[2] != first[2]


def test_a_file_that_changes_while_it_is_read_is_refused(tmp_path, scene_file, monkeypatch):
    random_forces(tmp_path)
    path = scene_file(scene(tmp_path) + GAS + SHAKEN)

    def meanwhile(file: Path) -> object:
        found = load_pairs(file)
        file.write_text("node,fx\n1,2\n")
        return found

    monkeypatch.setattr("vanelock.stages.matrices.piece.load_pairs", meanwhile)
    with pytest.raises(InputError, match=r"loads\[0\]\.file: .*gas\.csv: changed while it was"):
        gathered(load_scene(path))


FILE = '[[loads]]\ncomponent = "one"\nfile = "bad.csv"\n'
NODE = r"bad\.csv: a column 'node' of node numbers is needed"
ONE_OF = r"loads\[1\]\.nodes: give either this or file, not both\n.*loads\[1\]\.amplitude: give"
UNKNOWN = r"loads\[1\]\.file: node 99 is not among the nodes of components\.one"
WRONG = {
    "no node": ("fx\n1\n", "", NODE),
    "no force": ("node\n1\n", "", r"bad\.csv: at least one of the columns fx, fy, fz is needed"),
    "other column": ("node,fx,f\n1,1,1\n", "", r"bad\.csv: column 'f': allowed are node, fx, fy"),
    "words": ("node,fx\n3,much\n", "", r"bad\.csv: column 'fx' does not hold numbers"),
    "not a number": ("node,fx\n3,1\n4,nan\n", "", r"bad\.csv: column 'fx': 'nan' is not a"),
    "twice": ("node,fx\n3,1\n3,2\n", "", r"loads\[1\]\.file: .*bad\.csv: node 3 is listed twice"),
    "nothing": ("node,fx\n3,0\n", "", r"bad\.csv: all its forces are 0"),
    "unknown node": ("node,fx\n3,1\n99,2\n", "", UNKNOWN),
    "both": ("node,fx\n3,1\n", "nodes = [3]\namplitude = 2\n", ONE_OF),
    "static phase": ("node,fx\n3,1\n", "harmonic = 0\nphase = 3\n", r"loads\[1\]\.phase: a static"),
    "scale": ("node,fx\n3,1\n", 'scale = "big"\n', r"loads\[1\]\.scale = \"big\": expected a num"),
}


@pytest.mark.parametrize("case", WRONG)
def test_it_is_refused(tmp_path, scene_file, case):
    table, keys, message = WRONG[case]
    (tmp_path / "bad.csv").write_text(table)
    path = scene_file(scene(tmp_path) + SHAKEN + FILE + keys)
    refused_by(check_file, path, message)
    refused_by(lambda path: run_scene(load_scene(path), tmp_path / "run"), path, message)
    folder = tmp_path / "run"
    assert not [each for each in folder.rglob("*") if each.name.startswith("component")]


def test_a_missing_file_and_component_are_named(tmp_path, scene_file):
    text = scene(tmp_path) + SHAKEN + FILE

    refused_by(check_file, scene_file(text), r"loads\[1\]\.file: .*bad\.csv: cannot be read")
    (tmp_path / "bad.csv").write_text("node,fx\n99,1\n")
    text = text.replace('component = "one"\nfile', 'component = "three"\nfile')
    refused_by(check_file, scene_file(text), r'loads\[1\]\.component: no component "three"')


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[ring]", "low = [1]\nhigh = [2]\n[ring]", r"0\]\.file: components\.one is cyclic,"),
        ("[outputs]\nnodes = {one = [3]}\n", "", r"outputs\.nodes: must be given where all loads"),
        ('file = "gas.csv"', 'file = "../gas.csv"', r'loads\[0\]\.file = "\.\./gas\.csv": '),
        ('file = "gas.csv"', "scale = 2", r"loads\[0\]\.nodes: must be given, or file"),
        ('file = "gas.csv"', "scale = 2", r"loads\[0\]\.scale: goes with file"),
        ('file = "gas.csv"', 'file = "gas.csv"\nscale = 0', "loads: nothing vibrates"),
    ],
)
def test_a_scene_is_refused(tmp_path, scene_file, old, new, message):
    text = ONE.write(tmp_path, "one") + (
        '[ring]\nsectors = 6\n[[loads]]\ncomponent = "one"\nfile = "gas.csv"\n'
        "[outputs]\nnodes = {one = [3]}\n"
    )
    assert old in text
    refused_by(load_scene, scene_file(text.replace(old, new)), message)


def test_a_force_along_a_direction_without_a_row(tmp_path, scene_file):
    """It is refused, but for a clamped node and where the file says 0."""
    text = planar(tmp_path, ground=0.0) + "fixed = [1]\n[[loads]]\n"
    text += 'component = "one"\nfile = "gas.csv"\n[outputs.nodes]\none = [3]\n'
    nodes = np.arange(1, 4)
    forces = np.array([[0, 5, 0], [2, 0, 1], [0, 0, 3.0]])
    write_forces(tmp_path / "gas.csv", nodes, forces)
    slow = nonlinear.linear_response(joined(scene_file(text)), [1e-7]).output[0, 1]
    np.testing.assert_allclose(slow, [[2 / 3e5, 0, 4 / 1e5 + 3 / 1e5]], rtol=1e-9)
    forces[1, 1] = 0.1
    write_forces(tmp_path / "gas.csv", nodes, forces)
    no_row = r"loads\[0\]\.file: node 2 of components\.one has no row for its fy"
    refused_by(check_file, scene_file(text), no_row)
