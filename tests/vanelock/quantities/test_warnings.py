"""What is to be known of a case is said once, wherever its numbers stand; jumps."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.vanelock.pipeline.test_display import summary
from vanelock import parse_study
from vanelock.analyses.bounds import BOUNDS, BoundedPeak
from vanelock.analyses.wear import WEAR, WornCase
from vanelock.commands.run import doubts
from vanelock.common.errors import InputError
from vanelock.input.schema.response import ResponseKeys
from vanelock.nonlinear import (
    OPEN,
    SLIP,
    STUCK,
    Dwell,
    Options,
    StaticBounds,
    frequency_response,
    static_response,
    wear_history,
)
from vanelock.quantities import warnings
from vanelock.quantities.warnings import notes
from vanelock.results.listing import _response_table, limits_table
from vanelock.results.page import _best_friction
from vanelock.rom import Contacts, Diameter, Force, System
from vanelock.stages.response.limits import limits
from vanelock.stages.response.summary import Jump, Peak, Sweep, peak_of

HEIGHT = 1e-5


def oscillator(v0=1e-5, force=1.0, mu=0.3):
    """A mass on a spring at 50 Hz that two contacts 3 mm apart press on, sliding along y."""
    own = np.zeros((2, 3, 2))
    own[:, 0, 0] = own[:, 1, 1] = 1
    K = np.diag([1e5, (2 * np.pi * 50) ** 2])
    output = np.zeros((1, 3, 2))
    output[0, 1, 1] = 1
    return System(
        1,
        1,
        {0: Diameter(K, np.eye(2), own, None, output)},
        Contacts(np.full(2, 1e5), np.full((2, 2), 1e5), np.full(2, mu), np.full(2, v0)),
        {1: Force(np.array([0, force + 0j]))},
        ("o",),
        0.02,
    )


def peak(response):
    return peak_of(response, response.amplitude[:, 0, 1])


def test_a_higher_peak_after_wear_is_reported():
    system, dwell = oscillator(force=0.01), Dwell(10.0, near=(70.0, 100.0))
    worn = wear_history(system, dwell, 1e-20, 1e-6, Options(1))
    case: Any = None
    assert not list(WEAR.warnings(case, [WornCase(worn)]))
    amplitude, hertz = np.full(len(worn.cycles), np.nan), np.full(len(worn.cycles), np.nan)
    amplitude[-1], hertz[-1] = 2 * worn.amplitude[-1], 91.5
    other = replace(worn, higher_amplitude=amplitude, higher_frequency=hertz)
    (line,) = WEAR.warnings(case, [WornCase(other)])
    assert line.startswith("after 10 cycles of wear ANOTHER PEAK is higher")
    assert "at 91.5 Hz" in line
    assert f"{1e6 * worn.amplitude[-1]:.4g} um" in line


def test_motion_that_is_not_small_is_reported():
    """30 N on 1 kg at resonance slides by metres; a thousandth of it by less than the spacing."""
    places = np.array([[0, 0, 0], [3e-3, 0, 0]])
    hertz = np.linspace(45, 60, 16)
    found = frequency_response(oscillator(force=3000.0), hertz, Options(1))
    top = found.amplitude[peak(found).point, 0, 1]
    lines = doubts._large(found, peak(found), 4.5e-3, "the thickness", places)
    assert top > 4.5e-3
    assert f"{1e3 * top:.3g} mm, is more than the thickness, 4.5 mm" in lines[0]
    assert f"slide by up to {2e3 * top:.3g} mm" in lines[1]
    assert "further than to the next node, 3 mm" in lines[1]
    small = frequency_response(oscillator(force=3.0), hertz, Options(1))
    assert small.amplitude.max() < 4.5e-3
    assert doubts._large(small, peak(small), 4.5e-3, "the thickness", places) == []
    assert doubts._large(small, peak(small), np.nan, "unknown", None) == []


def test_hooks_open_at_rest_and_a_state_at_rest_that_is_not_solved_are_reported(ring):
    """A gap opens the hook; a pressed hook gives no warning."""
    open_hook = replace(ring, contacts=replace(ring.contacts, v0=np.array([-1e-5, 3e-5])))
    static = static_response(open_hook)
    joints = ring.contacts.joint
    (line,) = doubts._open_at_rest(static, joints, ["hook"])
    assert line.startswith("1 of 1 contacts of hook are open at rest: the linear limits")
    assert doubts._open_at_rest(static_response(ring), joints, ["hook", "interlock"]) == []
    off = replace(ring, contacts=replace(ring.contacts, v0=np.array([1e-5, -1e-5])))
    rest = static_response(off)
    assert doubts._at_rest(rest, False) == []
    assert doubts._at_rest(rest, True) == [doubts._LOOSE]
    lost = replace(rest, converged=np.zeros(1, bool), residual=np.array([3e-2]))
    _, line = doubts._at_rest(lost, True)
    assert [line] == doubts._at_rest(lost, False)
    assert line.startswith("the state at rest DID NOT CONVERGE (residual 3.0e-02)")


def test_a_correction_is_doubted_where_what_is_held_moves():
    joints = ["hook"] * 4 + ["interlock"]
    at = Peak(1, 50.0, 1.0, False)

    def warned(states):
        response: Any = SimpleNamespace(state=np.array([[STUCK] * 5, states]))
        return doubts._corrected(response, at, joints, ("hook",))

    (line,) = warned([STUCK, SLIP, OPEN, STUCK, SLIP])
    assert line.startswith("2 of 4 contacts of hook slip or open at the peak: mesh.correction")
    assert warned([STUCK, STUCK, STUCK, STUCK, SLIP]) == []


def test_loads_that_static_friction_leaves_open_are_reported_of_joints_that_slip():
    """A pad that slips beside a clamp that sticks, or across itself; at the peak or beside it."""
    at = Peak(0, 50.0, 1.0, False)
    loads = np.array([[0.0, 12.2, 229.0], [16e3, 16e3, 16e3]])
    yes = np.ones((2, 3), bool)
    bounds = StaticBounds(("pad", "clamp"), loads, np.zeros((2, 3, 2, 2)), yes, yes)
    joints = ["pad", "clamp"]

    def warned(states, loads=loads, beside=(STUCK, STUCK), across=False):
        state = np.array([states, beside])
        still = np.repeat((state == STUCK)[:, :, None], 2, axis=2)
        still[0, 0, 1] |= across
        response: Any = SimpleNamespace(state=state, undetermined=still)
        found = bounds and replace(bounds, rest_load=loads)
        return doubts._static_friction(found, joints, response, at)

    (line,) = warned([SLIP, STUCK])
    assert "it can hold pad at rest at 0 N to 229 N a sector (12.2 N if assembled" in line
    assert warned([STUCK, STUCK]) == warned([SLIP, SLIP]) == warned([SLIP, OPEN]) == []
    assert warned([STUCK, SLIP]) == []  # the clamp's load is what it is
    assert line.endswith("and the peak depends on which")
    assert warned([SLIP, SLIP], across=True) == [line]  # the pad slips in one direction alone
    (beside,) = warned([SLIP, SLIP], beside=[SLIP, STUCK])
    assert beside.endswith("and the curve at 1 of 2 points depends on which")
    (line,) = warned([SLIP, STUCK], np.array([[0.0, 12.2, np.inf], [1.0, 1.0, 1.0]]))
    assert "at 0 N to any load (12.2 N" in line
    assert warned([SLIP, STUCK], np.array([[0.0, 12.2, np.nan], [1.0, 1.0, 1.0]])) == []
    bounds = replace(bounds, proved=~yes)
    (line,) = warned([SLIP, STUCK])
    assert "at 0 N to 229 N a sector, or beyond, (12.2 N" in line
    bounds = replace(bounds, converged=np.array([[True, True, False], [True, True, True]]))
    (line,) = warned([SLIP, STUCK])  # without the numbers
    assert line.endswith("at which loads it can hold pad at rest was not found")
    assert warned([STUCK, STUCK]) == []
    bounds = None  # too many contacts
    (line,) = warned([SLIP, STUCK])
    assert line.endswith("it can hold pad at rest was not looked for, of 2 contacts")
    assert warned([STUCK, STUCK]) == []


def test_bounds_of_another_peak_than_the_curve_s_are_reported():
    """From one per cent on, since a curve's points may miss its top."""
    found: Any = SimpleNamespace(converged=np.ones(3, bool))
    bounded = BoundedPeak(found, residual=np.zeros(3))
    found.frequency, found.amplitude = np.full(3, 250.0), np.array([1e-6, 2e-6, 3e-6])
    at = Peak(4, 249.0, 1.985e-6, False)
    case: Any = SimpleNamespace(peak=at)
    assert not list(BOUNDS.warnings(case, [bounded]))
    case.peak = replace(at, amplitude=2.5e-6)
    (line,) = BOUNDS.warnings(case, [bounded])
    assert "are of ANOTHER PEAK than the curve's" in line
    assert line.endswith("theirs is 2 um at 250 Hz, the curve's 2.5 um at 249 Hz")


def test_modes_of_interest_that_differ_are_reported(ring):
    """The two masses' modes free and stuck: MAC as in test_limits, and a worse one."""
    found = limits(ring, 1)
    assert (warnings.alike(found.mac) == []) == (found.mac >= 0.8)
    (line,) = warnings.alike(0.55)
    assert "alike by MAC 0.55 only" in line
    assert line in limits_table({"": replace(found, mac=0.55)}).notes


@pytest.mark.parametrize(
    ("frequency", "size", "fits"),
    [(265.0, 0.43, True), (265.0, 430.0, False), (0.008, 0.43, False), (2.6e8, 0.43, False)],
)
def test_frequencies_that_no_solid_has_are_reported(frequency, size, fits):
    """A vane in m; the same in mm; E in GPa instead of Pa; rho in t/mm^3 instead of kg/m^3."""
    nodes = np.array([[0, 0, 0], [0.1 * size, size, 0.1 * size]])
    assert (doubts._implausible(frequency, nodes) == []) == fits
    assert doubts._implausible(frequency, np.empty((0, 3))) == []


def test_harmonics_beyond_the_band_are_reported_where_they_count():
    """Contacts that open hard at 20 Hz, a third of what harmonics 2 and 3 would be at."""
    found = frequency_response(oscillator(v0=2e-5, force=50.0), np.linspace(45, 60, 16), Options(3))
    at = peak(found)
    share = np.linalg.norm(found.contact[at.point, 2:]) / np.linalg.norm(found.contact[at.point, 1])
    assert (doubts._beyond_band(found, at, 70.0) != []) == (share > doubts._HARMONICS)
    assert doubts._beyond_band(found, at, 1000.0) == doubts._beyond_band(found, at, None) == []
    contact = found.contact.copy()
    contact[:, 2:] = np.stack([0.5 * contact[:, 1], 0 * contact[:, 1]], axis=1)
    (line,) = doubts._beyond_band(replace(found, contact=contact), at, 70.0)
    assert line.startswith("harmonics from 2 on, beyond the 70 Hz")
    assert "50 % of the contacts' motion" in line


def test_keys_without_effect_are_named():
    """Mu changes the peak at H = 1 and not at H = 3; a third key never does."""
    rows = []
    for mu in (0.1, 0.2):
        for order in ("a", "b"):
            values = {"joints.interlock.mu": mu, "response.coupling": order}
            rows.append((values, summary(peak=Peak(3, 250.0, HEIGHT * mu, False))))
    (line,) = warnings.without_effect(rows)
    assert line.startswith("response.coupling has no effect")
    for key in ("material.vane.fatigue_limit", "joints.hook.wear_coefficient", "stability.points"):
        aside = [({key: values["response.coupling"]}, found) for values, found in rows[:2]]
        assert warnings.without_effect(aside) == []
    low, high = (replace(rows[0][1], highest=Peak(3, 251.0, top, False)) for top in (2e-5, 3e-5))
    shares = [({"bounds.share": 0.5}, low), ({"bounds.share": 1.0}, high)]
    assert warnings.without_effect(shares) == []
    assert len(warnings.without_effect([({"bounds.starts": i}, low) for i in (1, 2)])) == 1
    alone = [(values, replace(found, peak=rows[0][1].peak)) for values, found in rows]
    assert len(warnings.without_effect(alone)) == 2
    assert warnings.without_effect(rows[:1]) == []
    notes = _response_table([replace(f, values=v) for v, f in rows], "monitor").notes
    assert any(note.startswith("warning: response.coupling has no effect") for note in notes)


def test_a_line_names_its_cases_once():
    found = {f"mu={i}": summary(warnings=("something",)) for i in range(3)}
    assert warnings.by_text(found) == ["all cases: something."]
    found["mu=9"] = summary()
    assert warnings.by_text(found, str) == ["mu=0; mu=1; mu=2: something."]
    many = {f"mu={i}": summary(warnings=("it",) if i else ()) for i in range(50)}
    assert warnings.by_text(many, str)[0].endswith("mu=8 and 41 more: it.")


def test_the_friction_that_damps_best_is_withheld_where_a_peak_may_lie_beyond():
    key = "joints.interlock.mu"
    height = {0.1: 2e-5, 0.2: 1e-5, 0.3: 3e-5}
    known = [
        summary(case=f"mu={mu}", mu=mu, values={key: mu}, peak=Peak(3, 250.0, top, False))
        for mu, top in height.items()
    ]
    content: Any = SimpleNamespace(known=known)
    (card,) = _best_friction(content)
    assert card.value == "μ = 0.2"
    known[2] = replace(known[2], peak=replace(known[2].peak, at_edge=True))
    (card,) = _best_friction(content)
    assert (card.value, card.flag) == ("withheld", "warn")
    assert "a peak may lie beyond: widen response.range" in card.note


def test_frequencies_without_a_mode_of_interest_are_said(ring):
    """From the mode with contacts free to that with contacts stuck, ends included."""
    found = limits(ring, 1)
    low, high = sorted((found.free_frequency, found.stuck_frequency))

    def said(**keys):
        given = ResponseKeys(mode=1, **keys)
        return warnings.beside_range(given, found)

    assert said() == said(range=(0.5 * low, low)) == said(range=(high, 2 * high)) == []
    (line,) = said(range=(2 * high, 3 * high))
    assert "response.range" in line
    assert f"hold no mode of interest: mode 1 lies at {found.free_frequency:.6g} Hz" in line
    (line,) = said(frequencies=(0.3 * low, 0.9 * low))
    assert line.startswith("response.frequencies")


JUMP = Jump((250.0, 250.2), (5e-6, 2e-6))
UP = Sweep("up", Peak(3, 250.0, 5e-6, False), (JUMP,))
DOWN = Sweep("down", Peak(7, 248.0, 6e-6, False), ())


def test_a_jump_is_reported_with_its_place_and_heights():
    first, second = notes([UP])
    assert first == "sweeping up JUMPS from 5 to 2 um between 250 and 250.2 Hz"
    assert second.endswith('may reach higher: response.direction = "both"')
    both = Sweep("both", UP.peak, (JUMP,))
    assert "looked for from every jump" in list(notes([both]))[1]
    assert not list(notes([DOWN]))


def test_the_lower_of_two_sweeps_and_the_largest_of_many_jumps_are_given():
    lines = list(notes([DOWN, UP]))
    assert lines[-1] == ("the peak is that of the sweep down; sweeping up reaches 5 um at 250 Hz")
    alike = Sweep("up", DOWN.peak, ())
    assert list(notes([DOWN, alike])) == []
    jumps = tuple(Jump((200.0 + i, 200.5 + i), (1e-6 * i, 0.0)) for i in range(1, 8))
    (line, _) = notes([Sweep("down", None, jumps)])
    assert line.count("between") == 4
    assert "between 207 and 207.5 Hz" in line
    assert line.endswith("; and 3 smaller jumps")


@pytest.mark.parametrize("direction", ["down", "both"])
def test_where_both_directions_are_taken_anyway_none_is_given(direction):
    with pytest.raises(InputError, match=r"response\.direction"):
        parse_study(f'accuracy = 0.01\n[response]\ndirection = "{direction}"\n')
