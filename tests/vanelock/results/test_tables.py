"""Tables that a golden run printed, against the modes, responses and forces of its results."""

import h5py
import numpy as np
import pytest

from tests.small_study import HOOK


def test_the_tables_of_limits_are_the_linear_modes_and_responses(golden):
    ran = golden("default")
    with h5py.File(ran.folder / "results.h5") as file:
        limits = {key: item[()] for key, item in file["limits/all"].items()}
        peaks = {}
        for which in ("free", "stuck"):
            group = file["response"][which]
            around = 2 * np.pi * np.arange(720) / 720
            moved = (group["output"][:, 1, 0][..., None] * np.exp(1j * around)).real.max(axis=-1)
            point, direction = np.unravel_index(moved.argmax(), moved.shape)
            peaks[which] = moved[point, direction], group["frequency"][point]
    rows, linear = ran.rows("limits"), ran.rows("linear")
    assert [row["contacts"] for row in rows] == [row["contacts"] for row in linear] == [*peaks]
    for row, peak in zip(rows, linear, strict=True):
        which = row["contacts"]
        own, mode = limits[which], int(limits[f"{which}_mode"])
        assert row["mode"] == mode + 1
        assert row["frequency_hz"] == own[mode]
        assert [row[f"f{i}_hz"] for i in range(1, 7)] == own[:6].tolist()
        assert row["damping_percent"] == pytest.approx(100 * limits[f"{which}_damping"])
        assert row["error"] == limits[f"{which}_error"][:6].max()
        assert row["mesh_percent"] == pytest.approx(100 * limits[f"{which}_lowered"])
        assert peak["peak_um"] == pytest.approx(1e6 * peaks[which][0], rel=2e-3)
        assert peak["frequency_hz"] == pytest.approx(peaks[which][1], rel=1e-3)
    rise = limits["stuck"][int(limits["stuck_mode"])] / limits["free"][int(limits["free_mode"])]
    assert rows[0]["rise_percent"] is None
    assert rows[1]["rise_percent"] == pytest.approx(100 * (rise - 1))
    assert rows[1]["mac"] == limits["mac"]


def test_the_table_of_the_preload_is_of_its_forces(golden):
    ran = golden("default")
    with h5py.File(ran.folder / "results.h5") as file:
        force = file["response/nominal/preload/force"][0, 0].real
    n, t = force[:, 0], np.abs(force[:, 1:]).max(axis=1)
    own = {"hook": slice(HOOK), "interlock": slice(HOOK, None)}
    for row in ran.rows("preload"):
        mine = own[row["joint"]]
        assert (row["n_min"], row["n_max"]) == pytest.approx((n[mine].min(), n[mine].max()))
        assert row["n_mean"] == pytest.approx(n[mine].mean())
        used = t[mine] / n[mine]
        assert (row["t_over_n"], row["mu"]) == (pytest.approx(used.max()), 0.3)
        assert row["slipped"] == np.count_nonzero(used > 0.3 * (1 - 1e-6))
        assert (row["closed"], row["open"]) == (len(n[mine]), 0)
