"""Linear limits against the closed form of two masses; the curve through a response's points."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vanelock import parse_study
from vanelock.common.errors import InputError
from vanelock.nonlinear import linear_response
from vanelock.results.listing import limits_table, linear_table
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


def test_the_table_of_limits_names_the_wave(ring):
    backward = replace(ring, engine_order=-1, diameters={**ring.diameters, 2: ring.diameters[1]})
    title = limits_table({"": limits(backward, 1)}).title
    assert title == "Linear limits: modes of nodal diameter 1, backward wave"


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
