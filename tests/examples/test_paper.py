"""The paper's script: numbers against a second way to them, and statements that can disagree."""

import csv

import numpy as np
import pytest

from examples.paper import paper
from examples.paper.paper import FEW, ONE, Model, Peak, Plane, Ridge
from tests.small_study import SMALL
from vanelock import nonlinear, parse_study
from vanelock.nonlinear import STUCK, Contacts, Diameter, Force, Options, System

RANGE = (100.0, 190.0)
HERTZ = np.linspace(*RANGE, 60)
OUTPUT = (0, 2)
HOOK, BOTH = np.array([True, False]), np.array([True, True])
KN, KT, MU, V0 = 1.3e6, 0.9e6, 0.35, 2e-6


@pytest.fixture
def model():
    """Seven sectors of four coordinates: a hook pair to the ground, an interlock to the next."""
    K = np.diag([3.0, 2.0, 1.0, 1.2]) * 1e6
    K[1, 3] = K[3, 1] = -0.02e6
    K[2, 3] = K[3, 2] = -0.5e6
    own, following, output = (np.zeros((n, 3, 4)) for n in (2, 2, 1))
    own[0, [0, 1, 2], [1, 0, 0]] = 1
    own[1, [0, 1, 2], [0, 3, 1]] = 1
    following[1, [0, 1, 2], [2, 3, 1]] = -1
    output[0, [0, 1, 2], [1, 2, 3]] = 1
    system = System(
        sectors=7,
        engine_order=1,
        diameters=dict.fromkeys(range(4), Diameter(K, np.eye(4), own, following, output)),
        contacts=Contacts(
            kn=np.array([2e6, 5e5]),
            kt=np.array([[2e6, 2e6], [4e5, 4e5]]),
            mu=np.array([0.3, 0.3]),
            v0=np.array([4e-4, 2e-6]),
            joint=("hook", "interlock"),
            always_closed=("hook",),
        ),
        force={1: Force(np.array([0, 0.2 + 0j, 1.0, 3.0]))},
        output_names=("vane output 1",),
        damping_ratio=0.01,
    )
    return Model(system, RANGE, OUTPUT)


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


def test_the_interlock_sticks_at_the_small_load_and_slips_well_above(model):
    stuck = nonlinear.linear_response(model.system, HERTZ, BOTH)
    small = paper.sticking_load(model.system, stuck)
    assert 0 < small < 1
    curves, apart = paper.all_stuck(model.changed(load=small))
    assert (curves[ONE].response.state[:, 1] == STUCK).all()
    beyond = model.changed(load=5 * small).solve(ONE, HERTZ)
    assert (beyond.response.state[:, 1] != STUCK).any()
    for each in apart.values():  # at full stick, coupled and others coincide
        assert each.vibration < 1e-9
        assert each.slipping == 0
    _, apart = paper.all_stuck(model)
    assert apart[paper.UNCOUPLED].vibration > 0.01


def test_a_ridge_is_the_peak_of_each_response_and_its_least_the_vertex(model, monkeypatch):
    monkeypatch.setattr(paper, "MAP_MU", (0.1, 1.0))
    monkeypatch.setattr(paper, "RIDGE_POINTS", 5)
    found = paper.ridge(model, ("mu", 1))
    for value, amplitude, hertz in zip(*found[2:], strict=True):
        near = model.changed(mu=value).solve(ONE, np.linspace(hertz - 1, hertz + 1, 41))
        assert amplitude == pytest.approx(near.amplitude, rel=1e-6)
    mu = np.geomspace(0.1, 10, 12)
    parabola = Ridge("mu", 1, mu, 2 + np.log(mu / 0.77) ** 2, mu)
    assert parabola.best == pytest.approx((0.77, 2.0), rel=1e-9)
    assert parabola._replace(amplitude=mu).best is None  # at an end


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
