"""The blade on a ground damper against its raw matrices: frequencies, and friction by marching."""

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

HERE = EXAMPLES / "ground_damper"
MU = "contacts.platform.mu"
STIFFNESS = 2e6  # N/m, normal and tangential


class Raw:
    """Unreduced matrices in SI units, without the clamped root."""

    def __init__(self) -> None:
        K = scipy.io.mmread(HERE / "stiffness.mtx.gz").toarray() * 1e3  # N/mm
        M = scipy.io.mmread(HERE / "mass.mtx.gz").toarray() * 1e3  # t
        every = np.arange(1, len(K) // 3 + 1)
        free = np.repeat(~np.isin(every, numbers(HERE / "root.csv")), 3)
        self.K: Floats = K[np.ix_(free, free)]
        self.M: Floats = M[np.ix_(free, free)]
        self.place = np.cumsum(free) - 1
        underside = numbers(HERE / "underside.csv")
        self.B = np.zeros((len(underside), 3, len(self.K)))
        for row, node in zip(self.B, underside, strict=True):
            for k, (direction, sign) in enumerate(((2, -1), (0, 1), (1, -1))):
                row[k, self.place[3 * (node - 1) + direction]] = sign
        (tip,) = numbers(HERE / "tip.csv")
        self.tip = np.zeros(len(self.K))
        self.tip[self.place[3 * (tip - 1)]] = 1
        self.k = np.full((len(underside), 3), STIFFNESS)

    def frequencies(self, stuck: bool) -> Floats:
        """The lowest two, Hz."""
        K = self.K + springs(self.B, self.k) if stuck else self.K
        squared = scipy.linalg.eigh(K, self.M, eigvals_only=True, subset_by_index=[0, 1])
        found: Floats = np.sqrt(squared) / (2 * np.pi)
        return found


@pytest.fixture(scope="module")
def raw() -> Raw:
    return Raw()


@pytest.mark.parametrize("mu", [0.15, 0.4])
def test_friction_peak_is_that_of_time_integration(mu: float, raw: Raw, tmp_path: Path) -> None:
    """Left and right of the best friction; harmonics above the seventh are left out of one."""
    found = run_one("ground_damper", MU, mu, tmp_path, points=13)
    assert found.peak is not None
    history = march(
        raw.K, raw.M, raw.B, raw.k, mu, 5e-6, 0.5 * raw.tip.astype(complex),
        np.zeros(len(raw.K)), found.peak.frequency, 0.002, periods=20, steps=120,
    )  # fmt: skip
    assert found.peak.amplitude == pytest.approx(amplitude(history, raw.tip), rel=0.015)
    with h5py.File(tmp_path / "results.h5") as file:
        for which in ("free", "stuck"):
            ours = frequencies(file, which)[:2]
            assert ours == pytest.approx(raw.frequencies(which == "stuck"), rel=1e-4)
            assert np.all(ours >= raw.frequencies(which == "stuck") * (1 - 1e-9))


def test_files_are_what_the_script_writes(tmp_path: Path) -> None:
    generator("ground_damper", tmp_path).main()
    assert lists_of(tmp_path) == lists_of(HERE)
    assert (tmp_path / "rows.mapping").read_text() == (HERE / "rows.mapping").read_text()
    for name in ("stiffness.mtx.gz", "mass.mtx.gz"):
        ours, committed = (scipy.io.mmread(folder / name).toarray() for folder in (tmp_path, HERE))
        assert np.abs(ours - committed).max() <= 1e-10 * np.abs(committed).max()
