"""Peaks that static friction may move: closed forms, differences, random places."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.nonlinear.peaks.test_peak import DAMPING, KT, K, jenkins_peak
from tests.nonlinear.systems import with_contacts
from tests.verification.nonlinear.spring_rings import spring_ring
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    linear_response,
    peak_bounds,
    static_bounds,
)
from vanelock.nonlinear.bounds.rest_states import RestStates
from vanelock.nonlinear.bounds.slider_search import Search
from vanelock.nonlinear.peaks.amplitude_gradient import amplitude_gradient
from vanelock.nonlinear.peaks.peak import Resonance

NEAR = (0.1, 0.3)
MU = 0.5
FRICTIONS = ("orthogonal", "isotropic")


def held_pad(force):
    """The oscillator of `test_peak`, its pad pressed on by a plate that a clamp holds.

    Coordinates: the mass, and the plate, on which the clamp's friction acts.
    """
    own = np.zeros((2, 3, 2))
    own[0, 1, 0] = own[0, 0, 1] = 1.0  # the pad slides with the mass, the plate presses it
    own[1, 1, 1] = 1.0  # the clamp slides with the plate
    output = [[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]]
    C = np.diag([DAMPING, DAMPING])
    one = Diameter(K=np.diag([K, 1.0]), M=np.eye(2), C=C, own=own, output=output)
    kt, joints = [[KT, KT], [1.0, 1.0]], ("pad", "clamp")
    contacts = Contacts([2.0, 1.0], kt, [MU, 0.3], [1.0, 2.0], joints)
    return System(1, 0, {0: one}, contacts, {1: Force([force, 0.0])}, ("mass",))


@cache
def slid_bounds(friction="orthogonal"):
    """Bounds of one held pad that slides."""
    return peak_bounds(held_pad(1.0), NEAR, Options(1, friction=friction), starts=0)


def peak_by_load(force, load):
    return jenkins_peak(force, MU * load)[1]


@pytest.mark.parametrize(("force", "friction"), [(0.1, "orthogonal"), (1.0, "isotropic")])
def test_the_peak_is_that_of_the_loads_a_clamp_can_hold(force, friction):
    system = held_pad(force)
    loads = static_bounds(system, "pad").rest_load[0]
    found = peak_bounds(system, NEAR, Options(1, friction=friction), starts=1)
    assert found.converged.all()
    assert found.joints == ("pad", "clamp")
    for amplitude, load in zip(found.amplitude, found.rest_load[:, 0], strict=True):
        assert amplitude == pytest.approx(peak_by_load(force, load), rel=1e-9)
    possible = [peak_by_load(force, load) for load in np.linspace(loads[0], loads[2], 200)]
    assert found.amplitude[0] == pytest.approx(min(possible), rel=2e-3)
    assert found.amplitude[2] == pytest.approx(max(possible), rel=2e-3)
    assert found.amplitude[2] > 1.05 * found.amplitude[0]
    assert found.solved > 10


def test_a_share_of_nothing_is_the_peak_assembled_at_zero():
    found = peak_bounds(held_pad(1.0), NEAR, Options(1), share=0.0)
    np.testing.assert_array_equal(found.amplitude, [found.amplitude[1]] * 3)
    assert not found.slider.any()
    assert set(found.found_by) == {"assembled at zero"}


@cache
def oblique(friction="orthogonal"):
    """The held pad in general position, with a second clamp."""
    aside = 1.0 if friction == "isotropic" else 1.125
    rng = np.random.default_rng(4)
    system = held_pad(0.3)
    own = np.concatenate([system.diameters[0].own, np.zeros((1, 3, 2))])
    own = own + 0.1 * rng.normal(size=own.shape)
    kt, joints = [[KT, KT], [1.0, aside], [0.8, 0.8 * aside]], ("pad", "clamp", "clamp")
    contacts = Contacts([2.0, 1.0, 1.5], kt, [MU, 1.5, 1.5], [1.0, 4.0, 4.0], joints)
    diameter = replace(system.diameters[0], own=own)
    return replace(system, contacts=contacts, diameters={0: diameter})


@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("harmonics", [1, 4])
def test_the_gradient_is_that_of_differences(harmonics, friction):
    system, options = oblique(friction), Options(harmonics, friction=friction)
    found = peak_bounds(system, NEAR, options, share=0.0)
    component = (0, found.direction)

    def peak(slider):
        ready = options.prepare(with_contacts(system, slider=slider), NEAR, 1000)
        resonance = Resonance(ready.solver.family, component, 1e-12)
        solution = next(iter(ready.solver.sweep(np.array([2 * np.pi * found.frequency[1]]))))
        return ready, resonance.peak(solution.omega, solution.w, -1e4)

    here = np.array([[0.0, 0.0], [0.05, -0.03], [0.02, 0.04]])
    ready, at = peak(here)
    assert not at.solution.w[1:].any()  # the clamps hold where they were assembled
    moves = amplitude_gradient(ready, at.solution, component, held=True)
    assert moves is not None
    gradient, step = moves.by_slider(), 1e-4
    for place in np.ndindex(3, 2):
        aside = np.zeros((3, 2))
        aside[place] = step
        change = peak(here + aside)[1].amplitude - peak(here - aside)[1].amplitude
        assert change / (2 * step) == pytest.approx(gradient[place], rel=1e-5, abs=1e-7)
    assert np.abs(gradient[1:]).max() > 1e-2
    assert abs(gradient[0, 0]) < 1e-9  # the pad slips there


def test_a_peak_at_a_kink_is_no_lower_than_its_neighbours():
    system, hertz = spring_ring(131, 0.3), np.linspace(0.1, 0.45, 300)
    top = hertz[linear_response(system, hertz).amplitude[:, 0].max(axis=1).argmax()]
    found = peak_bounds(system, (0.88 * top, 1.06 * top), Options(1), share=0.0)
    beside = np.linspace(0.99, 1.01, 41) * found.frequency[1]
    size = frequency_response(system, beside, Options(1), find_jumps=False).amplitude
    assert found.converged[1]
    assert found.amplitude[1] == pytest.approx(size[:, 0, found.direction].max(), rel=1e-9)


def test_ends_are_those_of_all_peaks_that_any_search_has_met():
    """Of the highest of the range at each random place, too."""
    system = with_contacts(spring_ring(5, 0.1), v0=np.full(2, 0.5))
    found = peak_bounds(system, (0.1, 0.45), Options(1), starts=1)
    least, nominal, largest = found.amplitude
    assert least <= min(nominal, *found.drawn) < 0.99 * nominal
    assert nominal < largest
    assert largest >= found.drawn.max()


def test_a_state_at_rest_that_is_not_solved_is_reported(monkeypatch):
    solved = RestStates.solved

    def missed(states, slider):
        found = solved(states, slider)
        return replace(found, converged=np.zeros_like(found.converged))

    monkeypatch.setattr(RestStates, "solved", missed)
    assert not peak_bounds(held_pad(1.0), NEAR, Options(1), share=0.0).converged.any()
    loads = static_bounds(held_pad(1.0), "pad")
    assert loads.converged.tolist() == [[False, True, False]]


@pytest.mark.parametrize(("sharp", "distance"), [(True, 0.0), (False, np.inf)])
def test_an_end_is_stationary_where_its_gradient_alone_gives_all_changes(
    monkeypatch, sharp, distance
):
    exact = Search.exact

    def rough(search, place):
        found = exact(search, place)
        return replace(found, peak=replace(found.peak, sharp=sharp, distance=distance))

    assert slid_bounds().stationary[[0, 2]].any()
    monkeypatch.setattr(Search, "exact", rough)
    assert not peak_bounds(held_pad(1.0), NEAR, Options(1), starts=0).stationary.any()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"near": (0.3, 0.1)}, "near"),
        ({"near": (0.5, 0.6)}, "near: no peak was found in it"),
        ({"share": -1.0}, "share: given -1.0: needs 0 to 1"),
        ({"joints": "hub"}, "closed: given 'hub'"),
        ({"options": Options(1, coupling="uncoupled")}, "bounds are of coupled balances"),
        ({"options": Options(0)}, "harmonics: given 0"),
        ({"starts": -1}, "starts: given -1"),
        ({"starts": 2.5}, "starts: given 2.5: needs a whole number"),
        ({"seed": -1}, "seed: given -1: must be >= 0"),
        ({"tolerance": 0.0}, "tolerance: given 0.0"),
    ],
)
def test_wrong_questions_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        peak_bounds(held_pad(1.0), **{"near": NEAR, "options": Options(1), **options})
