"""The two blocks with a lap joint against their raw matrices: frequencies, friction by marching."""

import gzip
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.linalg

from tests.vanelock.scenes.newmark import Floats, amplitude, march, springs
from tests.vanelock.scenes.scenes import (
    EXAMPLES,
    frequencies,
    generator,
    lists_of,
    numbers,
    run_one,
)

HERE = EXAMPLES / "lap_joint"
MU = "contacts.lap.mu"


def entries(name: str, folder: Path = HERE) -> Floats:
    """(k, 5) node, freedom, node, freedom, entry of an Abaqus file."""
    text = gzip.decompress((folder / name).read_bytes()).decode()
    return np.loadtxt(text.split("\n"), delimiter=",")


class Raw:
    """Both blocks' matrices by node and direction, clamped freedoms left out."""

    def __init__(self) -> None:
        tables = {(p, m): entries(f"{p}_{m}1.mtx.gz") for p in PARTS for m in ("STIF", "MASS")}
        labels = sorted({tuple(row[:2].astype(int)) for t in tables.values() for row in t})
        held = {
            tuple(row[:2].astype(int))
            for table in tables.values()
            for row in table
            if row[4] == 1e36
        }
        self.place = {
            label: k for k, label in enumerate(each for each in labels if each not in held)
        }
        self.K, self.M = (np.zeros((len(self.place),) * 2) for _ in range(2))
        for (_, kind), table in tables.items():
            into = self.K if kind == "STIF" else self.M
            for row in table:
                i, j = (self.place.get((int(row[k]), int(row[k + 1]))) for k in (0, 2))
                if i is not None and j is not None:
                    into[i, j] = into[j, i] = row[4]
        pairs = np.loadtxt(HERE / "pairs.csv", skiprows=1, delimiter=",").astype(int)
        self.B = np.zeros((len(pairs), 3, len(self.K)))
        for row, (lower, upper) in zip(self.B, pairs, strict=True):
            for k, (direction, sign) in enumerate(((3, 1), (1, 1), (2, 1))):
                row[k, self.place[lower, direction]] = sign
                row[k, self.place[upper, direction]] = -sign
        self.k = np.tile([2e7, 1e7, 1e7], (len(pairs), 1))

    def bolt(self, part: str) -> Floats:
        """A unit force along z on each node that the bolt presses."""
        found = np.zeros(len(self.K))
        for node in numbers(HERE / f"{part}_bolt.csv"):
            found[self.place[node, 3]] = 1
        return found


PARTS = ("lower", "upper")


@pytest.fixture(scope="module")
def raw() -> Raw:
    return Raw()


def test_friction_peak_is_that_of_time_integration(raw: Raw, tmp_path: Path) -> None:
    """Started near it, the vibration stays for forty periods where the balance says."""
    found = run_one("lap_joint", MU, 0.03, tmp_path)
    assert found.peak is not None
    stuck = raw.K + springs(raw.B, raw.k)
    for which, K in (("free", raw.K), ("stuck", stuck)):
        squared = scipy.linalg.eigh(K, raw.M, eigvals_only=True, subset_by_index=[0, 1])
        with h5py.File(tmp_path / "results.h5") as file:
            ours = frequencies(file, which)[:2]
        assert ours == pytest.approx(np.sqrt(squared) / (2 * np.pi), rel=1e-4)
    _, shape = scipy.linalg.eigh(stuck, raw.M, subset_by_index=[0, 0])
    row = raw.bolt("lower") * 0
    row[raw.place[numbers(HERE / "lower_bolt.csv")[0], 3]] = 1
    shape = shape[:, 0] / (row @ shape[:, 0])
    history = march(
        raw.K, raw.M, raw.B, raw.k, 0.03, 0.0, 0.4 * raw.bolt("lower").astype(complex),
        400 * (raw.bolt("lower") - raw.bolt("upper")), found.peak.frequency, 0.002,
        periods=40, steps=120, start=-1j * found.peak.amplitude * shape,
    )  # fmt: skip
    assert amplitude(history, row) == pytest.approx(found.peak.amplitude, rel=0.01)


def test_files_are_what_the_scripts_write(tmp_path: Path) -> None:
    generator("lap_joint", tmp_path).main()
    assert lists_of(tmp_path) == lists_of(HERE)
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
