"""The ring of shrouded blades against the whole ring by hand, and by marching four sectors.

A wave of engine order 3 around twelve sectors repeats after four, so that a closed ring of four
of them, each in its own turned coordinates, vibrates as the whole one does.
"""

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from tests.golden.runs import GoldenRun
from tests.vanelock.scenes.newmark import Floats, amplitude, march
from tests.vanelock.scenes.scenes import (
    EXAMPLES,
    Integers,
    frequencies,
    generator,
    lists_of,
    numbers,
)
from vanelock.nonlinear import Options, frequency_response
from vanelock.rom import System

HERE = EXAMPLES / "shrouded_ring"
SECTORS, ENGINE_ORDER = 12, 3
TURN = 2 * np.pi / SECTORS
AROUND = np.array([[np.cos(TURN), -np.sin(TURN), 0], [np.sin(TURN), np.cos(TURN), 0], [0, 0, 1]])


def freedoms(nodes: Floats | Integers) -> Integers:
    """Rows of nodes, direction by direction fastest."""
    found: Integers = (3 * (np.asarray(nodes, int)[:, None] - 1) + np.arange(3)).ravel()
    return found


class Raw:
    """A closed ring of sectors: low faces and inner nodes stay, each sector in its own frame."""

    def __init__(self, sectors: int) -> None:
        self.sectors = sectors
        K, M = (sp.load_npz(HERE / f"{name}.npz").tocsr() for name in "KM")
        size = K.shape[0]
        low, high, bore = (freedoms(numbers(HERE / f"{n}.csv")) for n in ("low", "high", "bore"))
        gone = np.zeros(size, bool)
        gone[high] = gone[bore] = True
        self.place = np.cumsum(~gone) - 1
        n = self.own = int((~gone).sum())
        kept = np.flatnonzero(~gone)
        here = sp.coo_array((np.ones(n), (kept, self.place[kept])), (size, n)).tocsr()
        turned = sp.block_diag([AROUND] * (len(low) // 3)).tocoo()
        beyond = sp.coo_array(
            (turned.data, (high[turned.row], self.place[low[turned.col]])), (size, n)
        ).tocsr()
        one = sp.eye_array(sectors, format="csr")
        following = sp.csr_array(np.roll(np.eye(sectors), 1, axis=1))
        T = sp.kron(one, here) + sp.kron(following, beyond)
        self.K, self.M = ((T.T @ sp.kron(one, A) @ T).tocsc() for A in (K, M))
        table = np.loadtxt(HERE / "shroud.csv", skiprows=1, delimiter=",")
        self.B = np.zeros((sectors * len(table), 3, sectors * n))
        for sector in range(sectors):
            for k, line in enumerate(table):
                normal, tangent = line[2:5], line[5:8]
                frame = np.array([normal, tangent, np.cross(normal, tangent)])
                row = self.B[sector * len(table) + k]
                after = (sector + 1) % sectors
                row[:, self.columns(sector, line[0])] += frame
                row[:, self.columns(after, line[1])] -= frame @ AROUND
        self.k = np.tile([2e6, 1e6, 1e6], (len(self.B), 1))

    def columns(self, sector: int, node: float) -> Integers:
        """Coordinates of a node that stays."""
        found: Integers = sector * self.own + self.place[freedoms(np.array([node]))]
        return found

    def axial(self, sector: int) -> Floats:
        """The row of the loaded node's axial displacement."""
        found = np.zeros(self.K.shape[0])
        found[self.columns(sector, numbers(HERE / "tip.csv")[0])[2]] = 1
        return found


@pytest.fixture(scope="module")
def run(golden: Callable[[str], GoldenRun]) -> tuple[float, Path]:
    """One case: the peak's frequency, and the results."""
    known = golden("shrouded_ring")
    (found,) = (each for each in known.summaries if each.case == "interference=1um")
    assert found.peak is not None
    return found.peak.frequency, known.folder / "results.h5"


def test_frequencies_are_those_of_the_whole_ring(run: tuple[float, Path]) -> None:
    """Each of nodal diameter 3 is there twice, as a wave travels both ways."""
    ring = Raw(SECTORS)
    flat = sp.csr_array(ring.B.reshape(-1, ring.B.shape[-1]))
    stuck = ring.K + flat.T @ sp.diags_array(ring.k.ravel()) @ flat
    for which, K in (("free", ring.K), ("stuck", stuck)):
        with h5py.File(run[1]) as file:
            ours = frequencies(file, which)[:2]
        squared = spl.eigsh(K.tocsc(), 40, ring.M, sigma=(2 * np.pi * 300) ** 2)[0]
        whole = np.sort(np.sqrt(squared)) / (2 * np.pi)
        for frequency in ours:
            nearest = whole[np.argsort(np.abs(whole - frequency))[:2]]
            assert nearest == pytest.approx([frequency] * 2, rel=1e-4)


def test_friction_peak_is_that_of_time_integration(run: tuple[float, Path]) -> None:
    """Of seven harmonics: three alone are some per cent too high where all contacts slip."""
    hertz, path = run
    with h5py.File(path) as file:
        system = System.load(file["response/interference=1um/system"])
    balanced = frequency_response(system, [hertz], Options(7))
    peak = float(balanced.amplitude[0, 0, 2])  # axial
    assert balanced.converged.all()
    ring = Raw(4)
    wave = np.exp(-1j * ENGINE_ORDER * TURN * np.arange(4))
    force = sum(0.5 * wave[j] * ring.axial(j) for j in range(4))
    history = march(
        ring.K.toarray(), ring.M.toarray(), ring.B, ring.k, 0.3, 1e-6, force,
        np.zeros(4 * ring.own), hertz, 0.001, periods=20, steps=120,
    )  # fmt: skip
    found = [amplitude(history, ring.axial(j)) for j in range(4)]
    assert found == pytest.approx([found[0]] * 4, rel=5e-3)  # a travelling wave
    assert found[0] == pytest.approx(peak, rel=0.015)


def test_files_are_what_the_script_writes(tmp_path: Path) -> None:
    generator("shrouded_ring", tmp_path).main()
    assert lists_of(tmp_path) == lists_of(HERE)
    for name in ("K.npz", "M.npz"):
        ours, committed = (sp.load_npz(folder / name) for folder in (tmp_path, HERE))
        assert np.abs(ours - committed).max() <= 1e-10 * np.abs(committed).max()
