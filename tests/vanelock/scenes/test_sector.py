"""A sector with cyclic faces against the ring of all sectors."""

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as sl

from tests.vanelock.scenes.conftest import chain, joined
from vanelock import load_scene, run_scene
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.input.measured.curve import load_measured
from vanelock.rom import linear_modes

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
        ("low = [3]\nhigh = [5]\nmodes = 3\n", "node 5 lies"),
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
    text += '[measured]\nfile = "rig.csv"\n[outputs]\nloops = false\n'
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
