"""Loads that static friction may hold: a closed form, all states on a grid, random ones."""

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.nonlinear.systems import even, random_system, with_contacts
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    audit_response,
    static_bounds,
    static_response,
)
from vanelock.nonlinear.bounds.rest_states import rest_states

K, KN, KT, MU, V0 = 2.0, np.array([0.5, 0.8]), 0.7, 0.4, np.array([1.0, 1.5])
OBLIQUE = 0.3
"""What the second contact closes by where the first closes by 1."""


PLANE = Options(friction="isotropic")


def wedge(angle=0.0):
    """One coordinate that closes a pad, and slides and closes a wedge, in its plane by an angle."""
    own = np.zeros((2, 3, 1))
    own[0, 0], own[1, 0], own[1, 1:, 0] = 1, OBLIQUE, (np.cos(angle), np.sin(angle))
    contacts = Contacts(KN, [[KT, KT]] * 2, [MU, MU], V0, ("pad", "wedge"))
    one = {0: Diameter(K=[[K]], M=[[1.0]], own=own)}
    return System(1, 1, one, contacts, {}, (), damping_ratio=0.01)


def named(system, *joints):
    return with_contacts(system, joint=joints)


def wedge_load(used):
    """The pad's load where the wedge holds a share of its limit, N.

    K x + kn₁ (x + v₁) + β kn₂ (βx + v₂) + t = 0,      t = used μ kn₂ (βx + v₂).
    """
    by_wedge = KN[1] * (OBLIQUE + used * MU)
    x = -(KN[0] * V0[0] + by_wedge * V0[1]) / (K + KN[0] + by_wedge * OBLIQUE)
    return float(KN[0] * (x + V0[0]))


@pytest.mark.parametrize("share", [1.0, 0.4])
@pytest.mark.parametrize("angle", [None, 0.0, 0.3, 0.8, 2.5])
def test_a_wedge_holds_a_pad_between_the_loads_of_its_closed_form(angle, share):
    """Of isotropic friction in whatever direction, of orthogonal along the first."""
    system, options = (wedge(), Options()) if angle is None else (wedge(angle), PLANE)
    found = static_bounds(system, "pad", share=share, options=options)
    force = static_response(system, options).force[0, 0, 1].real
    along = np.array([np.cos(angle or 0.0), np.sin(angle or 0.0)])
    used = force[1:] @ along / (MU * force[0])
    expected = [wedge_load((1 - share) * used + sign * share) for sign in (1, -1)]
    low, nominal, high = found.rest_load[0]
    np.testing.assert_allclose([low, high], sorted(expected), rtol=1e-8 if angle else 1e-9)
    assert low < nominal < high
    assert found.converged.all()


@pytest.mark.parametrize("options", [Options(), PLANE])
def test_a_wedge_that_holds_itself_may_hold_any_load(options):
    # K + kn₁ + β kn₂ (β - μ) = 0: pulling it in presses it on as much as it takes.
    least = OBLIQUE + (K + KN[0]) / (OBLIQUE * KN[1])
    system = wedge(0.0 if options.friction == "orthogonal" else 0.6)
    for mu, wedges in ((0.99 * least, False), (1.01 * least, True)):
        held = with_contacts(system, mu=np.array([MU, mu]))
        found = static_bounds(held, "pad", options=options)
        assert np.isinf(found.rest_load[0, 2]) == wedges
        assert found.converged.all()


@pytest.mark.parametrize("options", [Options(), PLANE])
def test_a_table_on_feet_weighs_the_same_whatever_they_hold(options):
    random = np.random.default_rng(1)
    feet = 9
    own = np.zeros((feet, 3, 4))  # heave, two tilts, slide
    own[:, 0, 0], own[:, 0, 1:3] = 1.0, random.uniform(-1, 1, (feet, 2))
    own[:, 1, 1:] = np.column_stack([random.uniform(0, 1, (feet, 2)), np.ones(feet)])
    turn = np.linalg.qr(random.normal(size=(4, 4)))[0]
    kn, joints = random.uniform(0.5, 2, feet), ("left",) * 4 + ("right",) * 5
    contacts = Contacts(kn, np.full((feet, 2), KT), np.full(feet, MU), np.zeros(feet), joints)
    one = {0: Diameter(turn.T @ np.diag([0, 0, 0, K]) @ turn, np.eye(4), own @ turn)}
    force = {0: Force(turn.T @ [0.7, 0.0, 0.0, 0.0])}
    table = System(1, 1, one, contacts, force, (), damping_ratio=0.01)
    each = static_bounds(table, options=options).rest_load
    both = static_bounds(named(table, *("feet",) * feet), options=options).rest_load
    np.testing.assert_allclose(both, [[0.7] * 3], rtol=1e-12)
    np.testing.assert_allclose(each[0] + each[1, ::-1], 0.7, rtol=1e-7)
    assert np.all(np.diff(each) > 0.01)


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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"of": "hub"}, "of: given 'hub': joints are pad, wedge"),
        ({"share": 1.2}, "share: given 1.2: needs 0 to 1"),
        ({"share": float("nan")}, "share: given nan: needs 0 to 1"),
        ({"joints": np.ones(3, bool)}, r"given bool of shape \(3,\): needs bool, \(2,\)"),
    ],
)
def test_wrong_questions_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        static_bounds(wedge(), **{"of": "pad", **options})
