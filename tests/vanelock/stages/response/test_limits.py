"""Linear limits by the closed form of two masses, curves through points, how far models answer."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scipy.sparse.linalg as spl

from benchmarks.unreduced import UnreducedPart, unreduced
from tests.small_study import SMALL
from vanelock import nonlinear, parse_study
from vanelock.common.errors import InputError
from vanelock.input.band import asked_by, least_band, softest
from vanelock.input.cases.sweep import cases
from vanelock.nonlinear import linear_response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages
from vanelock.results.listing import limits_table, linear_table
from vanelock.stages.parts.components import model_step, part_step
from vanelock.stages.parts.segment import StudyStructure
from vanelock.stages.plan import plan
from vanelock.stages.response.limits import Limits, dense, fine, frequencies, limits
from vanelock.stages.response.responses import PARTS, drawn, monitor
from vanelock.stages.response.summary import Peak, peak_of

HOOK, INTERLOCK, SPRING = 3e6, 1e6, 2e6


def two_masses(a, b, c):
    """Frequencies of K = [[a, b], [b, c]], M = 1, in Hz."""
    mean, spread = (a + c) / 2, np.hypot((a - c) / 2, b)
    return np.sqrt([mean - spread, mean + spread]) / (2 * np.pi)


def test_frequencies_of_both_limits(ring):
    found = limits(ring, 2)
    assert found.nodal_diameter == 1
    np.testing.assert_allclose(found.free, two_masses(HOOK + SPRING, -SPRING, SPRING), rtol=1e-12)
    np.testing.assert_allclose(
        found.stuck, two_masses(HOOK + SPRING, -SPRING, SPRING + 3 * INTERLOCK), rtol=1e-12
    )
    assert (found.free_mode, found.stuck_mode) == (1, 1)
    assert found.rise == pytest.approx(found.stuck[1] / found.free[1] - 1)


def test_mode_of_interest_and_its_likeness(ring):
    """The angle between eigenvectors (cos α, sin α), tan 2α = 2b/(a - c), gives the MAC."""
    found = limits(ring, 1)
    free = np.arctan2(-2 * SPRING, HOOK) / 2
    stuck = np.arctan2(-2 * SPRING, HOOK - 3 * INTERLOCK) / 2
    assert found.mac == pytest.approx(np.cos(free - stuck) ** 2, rel=1e-12)


@pytest.mark.parametrize("joints", ["open", "stuck"])
def test_damping_of_the_mode_of_interest(ring, joints):
    """The ratio asked where the damping is that of this limit, 2ζωΦΦᴴ's share of it elsewhere."""
    system = replace(ring, damping_joints=joints)
    found = limits(system, 2)
    asked, other = found.free_damping, found.stuck_damping
    if joints == "stuck":
        asked, other = other, asked
    assert asked == pytest.approx(0.01, rel=1e-10)
    assert (other < 0.01) == (joints == "open")
    row = limits_table({"": found}).record()["rows"][0 if joints == "open" else 1]
    assert row["damping_percent"] == pytest.approx(100 * asked)


def test_a_mode_that_is_not_there(ring):
    with pytest.raises(InputError, match=r"response\.mode = 3: the reduced model has 2 modes"):
        limits(ring, 3)


def some_limits(free=250.0, stuck=280.0):
    none = np.zeros(2)
    return Limits(1, 16, True, np.array([100, free]), np.array([120, stuck]), 1, 1, 0.9, none, none)


def test_default_range_spans_free_to_stuck():
    low, high = frequencies(parse_study(""), some_limits())
    assert low < 250 < 280 < high
    assert low == pytest.approx(250 - 7.5)
    assert high == pytest.approx(280 + 7.5)
    low, high = frequencies(parse_study(""), some_limits(stuck=250.0))
    assert (low, high) == pytest.approx((242.5, 257.5))


def test_frequencies_that_a_study_names():
    exact = frequencies(parse_study("[response]\nfrequencies = [1, 2, 4]"), some_limits())
    assert list(exact) == [1, 2, 4]
    assert frequencies(parse_study("[response]\nrange = [240, 300]"), some_limits()) == (240, 300)
    even = frequencies(parse_study("[response]\nrange = [240, 300]\npoints = 4"), some_limits())
    assert list(even) == [240, 260, 280, 300]


@pytest.mark.parametrize("text", ["", "frequencies = [1, 2]", "range = [240, 300]"])
def test_rigid_motion_is_no_mode_of_interest(text):
    """Frequencies of rounding alone, 1e-4 Hz beside 120 Hz, count as none."""
    with pytest.raises(InputError, match=r"response\.mode = 2: a rigid-body motion, 0 Hz, even"):
        frequencies(parse_study(f"[response]\n{text}"), some_limits(1e-4, 2e-4))


def test_a_part_that_is_loose_when_free_leaves_the_stuck_mode():
    """A quarter of the way from 0.8 of it, to either side."""
    low, high = frequencies(parse_study(""), some_limits(free=0.0))
    assert (low, high) == pytest.approx((224 - 14, 280 + 14))
    grid = dense((low, high), some_limits(free=0.0), False, 0.003)
    assert low - 1e-9 <= grid.min() < grid.max() <= high + 1e-9


def test_fine_frequencies_find_the_linear_peak(ring):
    """With modal damping a mode's peak is |Φ_out Φ_in F| / (2 ζ ω²) within ζ²."""
    found = limits(ring, 2)
    response = linear_response(ring, fine(found.stuck_frequency, 0.01), "all")
    watched = monitor(None, ring, response)
    assert watched.name == "vane output 1, circumferential"
    peak = peak_of(response, watched.amplitude(response))
    assert peak is not None
    omega = 2 * np.pi * found.stuck
    angle = np.arctan2(-2 * SPRING, HOOK - 3 * INTERLOCK) / 2
    residues = np.sin(angle) * np.cos(angle) * np.array([-1, 1])
    f = 2 * np.pi * np.linspace(0.97, 1.03, 20001) * found.stuck_frequency
    exact = abs((residues / (omega**2 - f[:, None] ** 2 + 0.02j * omega * f[:, None])).sum(axis=1))
    assert peak.amplitude == pytest.approx(exact.max(), rel=5e-4)
    assert peak.frequency == pytest.approx(f[exact.argmax()] / (2 * np.pi), rel=1e-3)
    assert not peak.at_edge


def test_monitor_that_is_not_there(ring):
    response = linear_response(ring, [100.0], "all")
    assert monitor("vane output 1, axial", ring, response).component == 2
    with pytest.raises(InputError, match='monitor = "vane output 2, axial": allowed are vane'):
        monitor("vane output 2, axial", ring, response)


@pytest.mark.parametrize("wanted", [[120.0], [1e-9, 265.0, 1e9], (100.0, 400.0), (10.0, 20.0)])
@pytest.mark.parametrize("stuck", [False, True])
def test_straight_lines_between_dense_frequencies_are_a_true_curve(wanted, stuck):
    """Against Σ 1 / (f² - ν² + 2iζfν) of the modes in between, the closed form."""
    known, ratio = some_limits(), 0.003
    wanted = wanted if isinstance(wanted, tuple) else np.array(wanted)
    drawn = dense(wanted, known, stuck, ratio)
    assert np.isin(wanted, drawn).all()
    modes = known.stuck if stuck else known.free

    def amplitude(f):
        return abs((1 / (modes**2 - f[:, None] ** 2 + 2j * ratio * modes * f[:, None])).sum(axis=1))

    between = np.append(np.linspace(drawn[0], min(drawn[-1], 2000), 20001), drawn[-1])
    between = np.concatenate([between, *(f * np.linspace(0.97, 1.03, 2001) for f in modes)])
    between = between[(between >= drawn[0]) & (between <= drawn[-1])]
    line = np.interp(between, drawn, amplitude(drawn))
    exact = amplitude(between)
    assert abs(line - exact).max() < 0.01 * exact.max()


def test_a_system_without_interlock_has_one_limit(ring):
    contacts = replace(ring.contacts, joint=("hook", "hook"), always_closed=("hook",))
    assert limits(ring, 1).opens
    found = limits(replace(ring, contacts=contacts), 1)
    assert not found.opens
    table = limits_table({"": found})
    assert [row[0] for row in table.rows] == ["free"]
    linear = linear_table(
        {"free": Peak(1, 9.0, 1e-5, False), "stuck": Peak(1, 9.0, 1e-5, False)}, "", ""
    )
    assert [row[0] for row in linear.rows] == ["free"]


def test_the_table_has_the_largest_error_down_to_the_mode_of_interest():
    frequencies, errors = np.arange(100.0, 110.0), np.linspace(1e-5, 1e-4, 10)
    for free, stuck in ((1, 2), (8, 9)):
        found = Limits(1, 16, True, frequencies, frequencies, free, stuck, 1.0, errors, 2 * errors)
        rows = limits_table({"": found}).record()["rows"]
        assert [row["error"] for row in rows] == [errors[max(5, free)], 2 * errors[max(5, stuck)]]


def response(f, slope, converged=True) -> Any:
    lost = np.full(len(f), converged)
    return SimpleNamespace(
        frequency=f, converged=lost, estimates=SimpleNamespace(slope=np.asarray(slope))
    )


def test_a_curve_with_slopes_is_drawn_round():
    f = np.linspace(0.0, 3.0, 7)
    found, amplitude, converged = drawn(response(f, np.cos(f)), 2 + np.sin(f))
    assert len(found) == 6 * PARTS + 1
    np.testing.assert_allclose(amplitude, 2 + np.sin(found), atol=3e-4)
    assert converged.all()
    assert set(f) <= set(found)


def test_a_jump_is_drawn_straight():
    f = np.arange(4.0)
    a = np.array([1.0, 1.0, 2.0, 2.0])
    found, amplitude, _ = drawn(response(f, [0.0, 50.0, 50.0, 0.0]), a)
    inside = (found >= 1) & (found <= 2)
    np.testing.assert_allclose(amplitude[inside], found[inside])


def test_points_alone_where_one_is_lost_or_nothing_is_known_of_slopes():
    f = np.arange(4.0)
    lost = response(f, np.zeros(4), False)
    assert drawn(lost, f) == (lost.frequency, f, lost.converged)
    bare: Any = SimpleNamespace(frequency=f, converged=np.ones(4, bool), estimates=None)
    assert drawn(bare, f)[0] is f


def test_a_study_far_above_the_tenth_mode_answers_like_the_unreduced_sector(tmp_path):
    """Beyond the fourteenth elastic mode of the vane, 2,855 Hz: a fixed number, ten, ends below."""
    study = parse_study(
        f'{SMALL}mesh.correction = "none"\nrom.accuracy = 1e-5\nresponse.range = [3040, 3060]\n'
        "response.harmonics = 1\ndamping.ratio = 1e-7\n"
        'joints.patch = "node"\n'
    )
    stages = Stages(Cache(tmp_path, print), lambda event: None)
    (case,) = cases(study)
    (planned,) = plan([case])
    system = stages.get(planned.linear.system)
    assert system.band is not None
    assert system.band > 3060
    f = 3060.0
    found = nonlinear.linear_response(system, [f]).output[0, 1, 0]
    blade, shell = (stages.get(model_step(study, part, True)) for part in ("vane", "casing"))
    parts = UnreducedPart(blade), UnreducedPart(shell, 1)
    sector = StudyStructure(study).bare.segment.assembly(*parts)
    K, M = unreduced(sector, 1)
    casing = stages.get(planned.part("casing", 1))
    nodes = casing.masters.set("force")
    own = system.force[1].vector[casing.dofs(nodes).ravel()]
    load = np.zeros(K.shape[0], complex)
    load[sector.places("casing", nodes, "").ravel()] = own
    seen = blade.part.node_sets["output"][0]
    assert system.output_names[0] == "vane output 1"
    dynamic = (K - (2 * np.pi * f) ** 2 * M).tocsc()
    x = spl.splu(dynamic, "MMD_AT_PLUS_A", 0.01, options={"SymmetricMode": True}).solve(load)
    assert np.linalg.norm(dynamic @ x - load) < 1e-9 * np.linalg.norm(load)
    true = np.linalg.norm(x[sector.places("vane", np.array([seen]), "").ravel()])
    assert np.linalg.norm(found) == pytest.approx(true, rel=1e-4)


def test_what_a_study_asks_for_and_a_little_wider_range_needs_no_new_models():
    text = "[response]\nrange = [240, 300]\n[campbell]\nspeeds = [0, 20000]\nengine_orders = [7]\n"
    asked = asked_by(parse_study(text))
    assert asked == {"response.range": 300, "campbell.speeds": pytest.approx(20000 / 60 * 7)}
    least = least_band(asked)
    assert least is not None
    assert 1.05 * 20000 / 60 * 7 <= least <= 1.05 * 2 ** (1 / 3) * 20000 / 60 * 7
    heated = '[material.vane]\nE = [[20, "200 GPa"], [600, "50 GPa"]]\n'
    assert softest(parse_study(heated + "[temperature]\nvane = 480\n")) == pytest.approx(0.25)
    assert least_band({}) is None
    keys = {
        part_step(parse_study(f"[response]\nrange = [240, {high}]"), "vane").key
        for high in (315, 340, 380)
    }
    assert len(keys) == 1


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("response.range = [200, 900]", r"response\.range reaches 900 Hz.*write response\.range"),
        ("response.range = [200, 900]\nrom.modes = 2", r"leave out rom\.modes"),
        (
            'response.frequencies = [900]\nrom.route = "paper"',
            r"response\.frequencies reaches 900 Hz.*give more rom\.modes",
        ),
        ("", r"response\.mode = 2 reaches"),
    ],
)
def test_frequencies_beyond_what_modes_answer_are_refused(ring, text, line):
    """Modes of the two masses lie at 195 to 480 Hz."""
    found = replace(limits(ring, 2), band=300.0)
    with pytest.raises(InputError, match=line):
        frequencies(parse_study(text), found)


def test_a_system_with_a_band_refuses_frequencies_beyond_it(ring, tmp_path):
    known = replace(ring, band=300.0)
    place = tmp_path / "system.h5"
    known.save(place)
    assert nonlinear.System.load(place).band == 300.0
    line = r"frequencies: given 400 Hz: .* answer up to 300 Hz .*reduce them with band = 420"
    one, shares = nonlinear.Options(1), nonlinear.Shares(0.01, 0.01)
    for ask in (
        lambda: nonlinear.frequency_response(known, [250.0, 400.0], one),
        lambda: nonlinear.frequency_response(known, (250.0, 400.0), one),
        lambda: nonlinear.linear_response(known, [400.0]),
        lambda: nonlinear.adaptive_response(lambda h: known, [400.0], shares, one),
        lambda: nonlinear.parameter_response(known, 400.0, "mu", [0.1], one),
        lambda: nonlinear.peak_response(known, "mu", [0.1], (100.0, 400.0), one),
        lambda: nonlinear.hysteresis(known, (250.0, 400.0), one),
        lambda: nonlinear.time_response(known, 400.0, periods=1),
    ):
        with pytest.raises(InputError, match=line):
            ask()
    assert nonlinear.linear_response(known, [300.0]).converged.all()
