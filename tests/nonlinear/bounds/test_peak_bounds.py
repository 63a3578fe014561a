"""Loads and peaks that static friction may hold or move: closed forms, a cone programme."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.nonlinear.peaks.test_peak import DAMPING, KT, K, jenkins_peak
from tests.nonlinear.systems import even, random_system, solved_response, with_contacts
from tests.refusals import refused
from tests.verification.nonlinear.spring_rings import spring_ring
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    audit_response,
    linear_response,
    peak_bounds,
    static_bounds,
    static_response,
)
from vanelock.nonlinear.bounds.rest_states import RestStates, rest_states

NEAR = (0.1, 0.3)
MU = 0.5


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


def test_a_peak_at_a_kink_is_no_lower_than_its_neighbours():
    system, hertz = spring_ring(131, 0.3), np.linspace(0.1, 0.45, 300)
    top = hertz[linear_response(system, hertz).amplitude[:, 0].max(axis=1).argmax()]
    found = peak_bounds(system, (0.88 * top, 1.06 * top), Options(1), share=0.0)
    beside = np.linspace(0.99, 1.01, 41) * found.frequency[1]
    size = solved_response(system, beside, Options(1)).amplitude
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


@pytest.mark.parametrize(("options", "message"), [
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
])  # fmt: skip
def test_wrong_questions_are_refused(options, message):
    refused(message, peak_bounds, held_pad(1.0), **{"near": NEAR, "options": Options(1), **options})


WEDGE_K, KN, WEDGE_KT, WEDGE_MU, V0 = 2.0, np.array([0.5, 0.8]), 0.7, 0.4, np.array([1.0, 1.5])
OBLIQUE = 0.3
"""What the second contact closes by where the first closes by 1."""


PLANE = Options(friction="isotropic")


def wedge(angle=0.0):
    """One coordinate that closes a pad, and slides and closes a wedge, in its plane by an angle."""
    own = np.zeros((2, 3, 1))
    own[0, 0], own[1, 0], own[1, 1:, 0] = 1, OBLIQUE, (np.cos(angle), np.sin(angle))
    contacts = Contacts(KN, [[WEDGE_KT, WEDGE_KT]] * 2, [WEDGE_MU, WEDGE_MU], V0, ("pad", "wedge"))
    one = {0: Diameter(K=[[WEDGE_K]], M=[[1.0]], own=own)}
    return System(1, 1, one, contacts, {}, (), damping_ratio=0.01)


def named(system, *joints):
    return with_contacts(system, joint=joints)


def wedge_load(used):
    """The pad's load where the wedge holds a share of its limit, N.

    K x + kn₁ (x + v₁) + β kn₂ (βx + v₂) + t = 0,      t = used μ kn₂ (βx + v₂).
    """
    by_wedge = KN[1] * (OBLIQUE + used * WEDGE_MU)
    x = -(KN[0] * V0[0] + by_wedge * V0[1]) / (WEDGE_K + KN[0] + by_wedge * OBLIQUE)
    return float(KN[0] * (x + V0[0]))


@pytest.mark.parametrize("share", [1.0, 0.4])
@pytest.mark.parametrize("angle", [None, 0.0, 0.3, 0.8, 2.5])
def test_a_wedge_holds_a_pad_between_the_loads_of_its_closed_form(angle, share):
    """Of isotropic friction in whatever direction, of orthogonal along the first."""
    system, options = (wedge(), Options()) if angle is None else (wedge(angle), PLANE)
    found = static_bounds(system, "pad", share=share, options=options)
    force = static_response(system, options).force[0, 0, 1].real
    along = np.array([np.cos(angle or 0.0), np.sin(angle or 0.0)])
    used = force[1:] @ along / (WEDGE_MU * force[0])
    expected = [wedge_load((1 - share) * used + sign * share) for sign in (1, -1)]
    low, nominal, high = found.rest_load[0]
    np.testing.assert_allclose([low, high], sorted(expected), rtol=1e-8 if angle else 1e-9)
    assert low < nominal < high
    assert found.converged.all()


@pytest.mark.parametrize("options", [Options(), PLANE])
def test_a_wedge_that_holds_itself_may_hold_any_load(options):
    # WEDGE_K + kn₁ + β kn₂ (β - μ) = 0: pulling it in presses it on as much as it takes.
    least = OBLIQUE + (WEDGE_K + KN[0]) / (OBLIQUE * KN[1])
    system = wedge(0.0 if options.friction == "orthogonal" else 0.6)
    for mu, wedges in ((0.99 * least, False), (1.01 * least, True)):
        held = with_contacts(system, mu=np.array([WEDGE_MU, mu]))
        found = static_bounds(held, "pad", options=options)
        assert np.isinf(found.rest_load[0, 2]) == wedges
        assert found.converged.all()


def test_only_the_joints_that_are_named_are_undetermined():
    found = static_bounds(wedge(), "pad", joints="pad")
    np.testing.assert_allclose(found.rest_load, found.rest_load[0, 1], rtol=1e-9)


def test_loads_that_isotropic_friction_holds_are_those_of_a_cone_programme():
    system = even(named(random_system(5, contacts=3, mu=0.4, harmonics=1), *"abb"))
    states = rest_states(system, "all", 1.0, PLANE, None)
    start, by = states.stretch
    contacts, ends = system.contacts, []

    def stretch(w):
        return np.asarray((start + by @ w).reshape(-1, 3))

    def room(w):
        v = stretch(w)
        return np.asarray((contacts.alpha[:, 0] * v[:, 0]) ** 2 - v[:, 1] ** 2 - v[:, 2] ** 2)

    places = np.repeat(np.eye(9)[:, [1, 2, 4, 5, 7, 8]], 1, axis=1)  # contacts stay closed
    for sign in (1, -1):
        found = minimize(
            lambda s, sign=sign: sign * contacts.kn[0] * stretch(places @ s)[0, 0],
            np.zeros(6),
            constraints={"type": "ineq", "fun": lambda s: room(places @ s)},
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 1000},
        )
        assert found.success
        ends.append(sign * found.fun * states.scale)
    found = static_bounds(system, "a", options=PLANE)
    assert found.converged.all()
    np.testing.assert_allclose(found.rest_load[0, ::2], ends, rtol=1e-7)
    square = static_bounds(system, "a")
    assert np.ptp(square.rest_load[0]) > 1.02 * np.ptp(found.rest_load[0])


@pytest.mark.parametrize("options", [Options(), PLANE])
def test_each_end_is_a_state_at_rest(options):
    system = even(named(random_system(2, mu=0.4, harmonics=1), *"aabbbb"))
    found = static_bounds(system, options=options)
    assert found.joints == ("a", "b")
    for i, chosen in enumerate((slice(0, 2), slice(2, 6))):
        for slider, load in zip(found.slider[i], found.rest_load[i], strict=True):
            moved = with_contacts(system, slider=slider)
            state = static_response(moved, options)
            assert audit_response(moved, state).residual[0] < 1e-9
            total = state.force[0, 0, chosen, 0].real.sum()
            assert total == pytest.approx(load, rel=1e-9, abs=1e-9 * found.rest_load[i].max())


@pytest.mark.parametrize(("options", "message"), [
    ({"of": "hub"}, "of: given 'hub': joints are pad, wedge"),
    ({"share": 1.2}, "share: given 1.2: needs 0 to 1"),
    ({"share": float("nan")}, "share: given nan: needs 0 to 1"),
    ({"joints": np.ones(3, bool)}, r"given bool of shape \(3,\): needs bool, \(2,\)"),
])  # fmt: skip
def test_wrong_questions_of_loads_are_refused(options, message):
    refused(message, static_bounds, wedge(), **{"of": "pad", **options})
