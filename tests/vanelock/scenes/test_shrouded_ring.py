"""The ring of shrouded blades against the whole ring by hand, and by marching four sectors."""

import gzip
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from numpy.typing import NDArray

from tests.vanelock.scenes.conftest import (
    EXAMPLES,
    Floats,
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
def run(golden):
    known = golden("shrouded_ring")
    (found,) = (each for each in known.summaries if each.case == "interference=1um")
    assert found.peak is not None
    return found.peak.frequency, known.folder / "results.h5"


def test_frequencies_are_those_of_the_whole_ring(run):
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


def test_friction_peak_is_that_of_time_integration(run):
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


def test_files_are_what_the_script_writes(tmp_path):
    generator("shrouded_ring", tmp_path).main()
    assert lists_of(tmp_path) == lists_of(HERE)
    for name in ("K.npz", "M.npz"):
        ours, committed = (sp.load_npz(folder / name) for folder in (tmp_path, HERE))
        assert np.abs(ours - committed).max() <= 1e-10 * np.abs(committed).max()


LAP = EXAMPLES / "lap_joint"


def entries(name: str, folder: Path = LAP) -> Floats:
    """(k, 5) node, freedom, node, freedom, entry of an Abaqus file."""
    text = gzip.decompress((folder / name).read_bytes()).decode()
    return np.loadtxt(text.split("\n"), delimiter=",")


PARTS = ("lower", "upper")


def test_files_are_what_the_scripts_write(tmp_path):
    generator("lap_joint", tmp_path).main()
    assert lists_of(tmp_path) == lists_of(LAP)
    for name in (f"{part}_{kind}1.mtx.gz" for part in PARTS for kind in ("STIF", "MASS")):
        ours, committed = entries(name, tmp_path), entries(name)
        assert ours == pytest.approx(committed, rel=1e-6, abs=1e-9 * np.abs(ours[:, 4]).min())
    there, here = EXAMPLES / "ground_damper", tmp_path / "damper"
    here.mkdir()
    generator("ground_damper", here).main()
    assert lists_of(here) == lists_of(there)
    assert (here / "rows.mapping").read_text() == (there / "rows.mapping").read_text()
    for name in ("stiffness.mtx.gz", "mass.mtx.gz"):
        ours, committed = (scipy.io.mmread(folder / name).toarray() for folder in (here, there))
        assert np.abs(ours - committed).max() <= 1e-10 * np.abs(committed).max()


def modal_damping(K: Floats, M: Floats, ratio: float, count: int = 12) -> Floats:
    """(n, count) F of C = F Fᵀ = Σ 2 ζ ω_j (M V_j)(M V_j)ᵀ of the lowest modes."""
    squared, V = scipy.linalg.eigh(K, M, subset_by_index=[0, count - 1])
    MV = M @ V
    factor: Floats = MV * np.sqrt(2 * ratio * np.sqrt(np.abs(squared)))
    return factor


def springs(B: Floats, k: Floats) -> Floats:
    """Stiffness of all contacts stuck; B (c, 3, n), k (c, 3)."""
    flat = B.reshape(-1, B.shape[-1])
    added: Floats = flat.T @ (k.reshape(-1, 1) * flat)
    return added


def march(
    K: Floats,
    M: Floats,
    B: Floats,
    k: Floats,
    mu: float,
    v0: float,
    force: NDArray[np.complex128] | Floats,
    constant: Floats,
    hertz: float,
    ratio: float,
    periods: int,
    steps: int = 240,
) -> Floats:
    """(steps, n) displacement over the last period, from the preloaded state at rest.

    B (c, 3, n) takes displacements to (closing, two tangential) of each contact; k (c, 3) N/m;
    the load is Re(force e^{iωt}) + constant.
    """
    c, _, n = B.shape
    flat = B.reshape(-1, n)
    stuck = K + springs(B, k)
    F = modal_damping(stuck, M, ratio)
    mass = sp.csr_array(M)
    omega = 2 * np.pi * hertz
    h = 1 / hertz / steps
    inverse = np.linalg.inv(K + (2 / h) * (F @ F.T) + (4 / h**2) * M)
    across = inverse @ flat.T
    G = flat @ across
    closed = np.zeros((c, 3))
    closed[:, 0] = k[:, 0] * v0
    x = np.linalg.solve(stuck, constant - flat.T @ closed.ravel())
    v, a = np.zeros(n), np.zeros(n)
    slider, last = np.zeros((c, 2)), (k * _with(flat @ x, v0)).ravel()
    kept = np.empty((steps, n))
    for step in range(1, periods * steps + 1):
        load = constant + (force * np.exp(1j * omega * h * step)).real
        inertia = (4 / h**2) * x + (4 / h) * v + a
        free = inverse @ (load + mass @ inertia + F @ (F.T @ ((2 / h) * x + v)))
        open_, guess = flat @ free, last
        for _ in range(300):
            found, moved = _law(_with(open_ - G @ guess, v0), k, mu, slider)
            change = np.abs(found - guess).max()
            guess = found
            if change < 1e-9 * max(1.0, np.abs(found).max()):
                break
        else:
            raise AssertionError(f"the contacts of step {step} do not settle")
        slider, last = moved, guess
        new = free - across @ guess
        speed = (2 / h) * (new - x) - v
        a = (4 / h**2) * (new - x) - (4 / h) * v - a
        x, v = new, speed
        kept[step % steps] = x
    return kept


def _with(displacement: Floats, v0: float) -> Floats:
    found: Floats = displacement.reshape(-1, 3).copy()
    found[:, 0] += v0
    return found


def _law(d: Floats, k: Floats, mu: float, slider: Floats) -> tuple[Floats, Floats]:
    """Forces (3c,) and sliders: n = max(kn v, 0), |t| <= mu n in each direction."""
    normal = np.maximum(k[:, 0] * d[:, 0], 0.0)
    bound = (mu * normal)[:, None]
    trial = k[:, 1:] * (d[:, 1:] - slider)
    friction = np.clip(trial, -bound, bound)
    return np.column_stack([normal, friction]).ravel(), d[:, 1:] - friction / k[:, 1:]


def amplitude(history: Floats, row: Floats) -> float:
    """Half the peak-to-peak of a displacement."""
    return float(np.ptp(history @ row) / 2)
