"""The paper's script: numbers against a second way to them, and statements that can disagree."""

import csv

import numpy as np
import pytest

from examples.paper import paper
from examples.paper.paper import FEW, ONE, Peak, Plane
from tests.small_study import SMALL
from vanelock import parse_study
from vanelock.nonlinear import Options

KN, KT, MU, V0 = 1.3e6, 0.9e6, 0.35, 2e-6


def test_loops_have_the_energy_of_the_element_marched_and_open_as_the_motion_says():
    loops = {each: paper.loop(KN, KT, MU, V0, *motion) for each, motion in paper.LOOPS.items()}
    for each in loops.values():
        assert each.work == pytest.approx(each.marched, rel=1e-5)
        u, t = each.displacement[:, 1], each.force[:, 1]
        area = np.sum((t + np.roll(t, -1)) / 2 * (np.roll(u, -1) - u))
        assert each.work == pytest.approx(area, rel=1e-5)
        assert np.all(np.abs(t) <= MU * each.force[:, 0] * (1 + 1e-9) + 1e-12)
    lifts = [0, np.arccos(1 / 1.6) / np.pi, 0]
    assert [each.opened for each in loops.values()] == pytest.approx(lifts, abs=1e-3)
    # Under a steady force 4 mu n0 (U - mu n0 / kt), the classical result for an elastic slider.
    n0 = KN * V0
    expected = 4 * MU * n0 * (paper.SLIDING - 1) * MU * n0 / KT
    assert paper.loop(KN, KT, MU, V0, 0.0, 0.0).work == pytest.approx(expected, rel=1e-8)


@pytest.fixture
def plane():
    """A peak that falls to mu = 0.3 and rises again, and with interference throughout."""
    a = np.array([[60, 50], [20, 15], [40, 30]]) * 1e-6
    f = np.array([[250, 251], [255, 256], [270, 272.0]])
    shifts = (0.0, 0.5, 0.7, 0.1, 0.1)

    def cell(i, j):
        factors = (1.0, 1.6 if i == 2 else 0.8, 1.2, 1.05, 1.052)  # uncoupled: order turns round
        peaks = zip(factors, shifts, strict=True)
        return [Peak(a[i, j] * k, f[i, j] + d, 0.0, 0, 1, 1.0) for k, d in peaks]

    methods, cells = (
        (*FEW, Options(3), Options(5)),
        [[cell(i, j) for j in (0, 1)] for i in range(3)],
    )
    return Plane("interference", (0.1, 0.3, 1.0), (1e-6, 2e-6), methods, cells)


def test_statements_hold_where_the_numbers_say_so(plane):
    found, rows = paper.holds(plane), [[True] * 2, [True] * 2, [False] * 2]
    np.testing.assert_array_equal(found["peak falls with friction"], rows)
    assert found["peak falls with interference"].all()
    np.testing.assert_array_equal(found["uncoupled: higher f, lower A"], rows)
    assert not found["constant-load: higher f, lower A"].any()
    assert found["H = 3 changes < 10%"].all()
    assert found["H = 5 changes < 1%"].all()
    assert not paper.slight(plane, ONE, Options(3), 0.049).any()
    assert paper.slight(plane, ONE, Options(3), 0.051).all()
    where = np.array([[False] * 2, [True] * 2, [True] * 2])
    assert plane.share(where) == pytest.approx(4 / 6)  # of the cells that every method knows
    plane.peaks[0][0][2] = plane.peaks[0][0][2]._replace(amplitude=np.nan)
    assert plane.share(where) == pytest.approx(4 / 5)
    assert not paper.holds(plane)["constant-load: higher f, lower A"][0, 0]


def test_the_statements_and_figures_of_a_small_study_are_its_peaks(tmp_path, monkeypatch):
    values = {
        "MU": (0.2, 0.3), "INTERFERENCE": (1e-6, 2e-6), "HARMONICS": (1, 3), "SLANTS": (),
        "MAP_MU": (0.2, 0.3), "MAP_INTERFERENCE": (1e-6, 2e-6), "MAP_LOAD": (0.5, 1.0),
        "RIDGE_HARMONICS": (1,), "RIDGE_POINTS": 4,
    }  # fmt: skip
    for name, value in values.items():
        monkeypatch.setattr(paper, name, value)
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda _, path, **how: path.touch())
    (tmp_path / "study.toml").write_text(
        f'{SMALL}\nname = "small"\njoints.interlock.mu = 0.3\nexcitation.force = 15\n'
        "response.range = [252, 268]\n[outputs]\nshow = []\n"
    )
    stated = paper.main([str(tmp_path / "study.toml"), "--output", str(tmp_path / "out")])
    assert {each.agrees for each in stated if each.figure in ("8", "10", "11", "12", "14")} == {
        "yes"
    }

    def read(name):
        with (tmp_path / "out" / name).open(encoding="utf-8") as file:
            heads, *rows = csv.reader(file)
        return dict(zip(heads, zip(*rows, strict=True), strict=True))

    assert list(read("statements.csv")["agrees"]) == [each.agrees for each in stated]
    curves, plane = read("figures/figure_15.csv"), read("figures/map_interference.csv")
    cells = zip(
        plane["friction coefficient"], plane["interference (µm)"], plane["method"], strict=True
    )
    peaks = dict(zip(cells, map(float, plane["peak (m)"]), strict=True))
    for mu in ("0.2", "0.3"):  # the sweep's cases, and responses of one system with other values
        for more, coupling in (("", "coupled"), (", uncoupled", "uncoupled")):
            curve = max(float(a) for a in curves[f"μ = {mu}{more} (µm)"] if a)
            assert peaks[mu, "2.0", f"{coupling}, H = 1"] == pytest.approx(1e-6 * curve, rel=1e-9)
    page = (tmp_path / "out" / "paper.md").read_text("utf-8")
    pictures = [
        f"(figures/{file.name})" in page for file in (tmp_path / "out").glob("figures/*.png")
    ]
    assert pictures == [True] * 11


def test_what_the_script_cannot_vary_is_refused():
    study = parse_study(
        '[response]\nfriction = "isotropic"\n[sweep]\n"response.harmonics" = [1, 2]'
    )
    with pytest.raises(SystemExit, match=r"^sweep, response\.friction: a study for this script is"):
        paper.check(study)
