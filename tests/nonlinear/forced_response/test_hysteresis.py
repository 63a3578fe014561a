"""Hysteresis, responses and peaks against a parameter: a stop in closed form, every coupling."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from tests.nonlinear.systems import (
    GAP_DAMPING,
    GAP_FORCE,
    even,
    first_frequency,
    gap_oscillator,
    loop_area,
    random_system,
    sliding_system,
    solved_response,
    with_contacts,
    with_rest,
)
from tests.refusals import refused
from vanelock.nonlinear import (
    OPEN,
    SLIP_OPEN,
    STUCK,
    Contacts,
    Diameter,
    Force,
    Options,
    ParameterResponse,
    System,
    contact_loop,
    frequency_response,
    hysteresis,
    parameter_response,
    peak_response,
)
from vanelock.nonlinear.forced_response.parameter_response import _NAMES
from vanelock.nonlinear.fourier import TURN

DAMPING, FORCE = GAP_DAMPING, GAP_FORCE
LOW, HIGH = 0.9, 1.25


def frequencies_of(X):
    """The two frequencies, rad/s, at which its first harmonic has the amplitude X; or none."""

    def integrals(mean):
        gap = 1 - mean
        if gap >= X:
            return 0.0, 0.0
        touch = np.arccos(gap / X)
        zero = (X * np.sin(touch) - gap * touch) / np.pi
        first = X * (touch / 2 + np.sin(2 * touch) / 4) - gap * np.sin(touch)
        return zero, 2 / np.pi * first

    mean = brentq(lambda mean: mean + integrals(mean)[0], -X, 0.0, xtol=1e-15)
    spring = 1 + integrals(mean)[1] / X
    middle = spring - DAMPING**2 / 2
    root = middle**2 - spring**2 + (FORCE / X) ** 2
    if root < 0:
        return np.full(2, np.nan)
    squares = middle + np.sqrt(root) * np.array([-1, 1])
    return np.sqrt(np.where(squares > 0, squares, np.nan))


@cache
def closed_folds():
    """(ω, X) of the upper fold, near the tip of the peak, and of the lower one."""
    X = np.linspace(1.0, 8.0, 4001)
    both = np.array([frequencies_of(x) for x in X])
    both = both[np.isfinite(both[:, 0])]
    X = X[: len(both)]
    tip = X[-1]
    side = int(np.argmax(both.max(axis=0)))
    options = {"xatol": 1e-12}
    high = X[np.argmax(both[:, side])]
    near = (high - 0.02, min(tip, high + 0.02))
    top = minimize_scalar(
        lambda x: -frequencies_of(x)[side], bounds=near, method="bounded", options=options
    )
    bottom = minimize_scalar(
        lambda x: frequencies_of(x)[1], bounds=(1.0, 1.5), method="bounded", options=options
    )
    return (-top.fun, top.x), (bottom.fun, bottom.x)


@pytest.fixture(scope="module")
def both_ways():
    return hysteresis(gap_oscillator(), np.linspace(LOW, HIGH, 61) / TURN, Options(1))


@pytest.mark.parametrize("damping", ["C", "ratio"])
def test_branch_is_the_closed_form_with_both_folds(both_ways, damping):
    found = both_ways
    if damping == "ratio":
        # Damped as the mode that does not touch the other spring.
        system = gap_oscillator(C=None, damping_ratio=DAMPING / 2)
        found = hysteresis(system, (LOW / TURN, 1.15 / TURN), Options(1))
    assert found.complete
    assert found.connected
    assert found.branch.converged.all()
    omega, X = TURN * found.branch.frequency, found.branch.amplitude[:, 0, 0]
    for one, amplitude in zip(omega, X, strict=True):
        assert np.nanmin(np.abs(frequencies_of(amplitude) - one)) < 1e-7
    # Drawn as a polygon it is smooth: neighbours differ little.
    assert np.abs(np.diff(omega)).max() < 0.06 * (HIGH - LOW)
    assert np.abs(np.diff(X)).max() < 0.06 * X.max()
    (top, high), (bottom, low) = closed_folds()
    assert found.upper.tolist() == [True, False]
    assert not found.sharp.any()
    np.testing.assert_allclose(omega[found.fold], [top, bottom], rtol=1e-9)
    np.testing.assert_allclose(X[found.fold], [high, low], rtol=1e-5)
    np.testing.assert_allclose(TURN * found.several, [[bottom, top]], rtol=1e-9)
    first, last = found.fold
    assert found.unstable[first + 1 : last].all()
    assert not found.unstable[: first + 1].any()
    assert not found.unstable[last:].any()
    np.testing.assert_array_equal(np.unique(found.passed), [0, 1, 2])
    assert found.branch.state[0, 0] == OPEN
    assert found.branch.state[first, 0] == SLIP_OPEN


@pytest.mark.parametrize("short", [1e-6, 1e-2])
def test_a_fold_beyond_the_range_is_not_of_the_path(short):
    (top, high), _ = closed_folds()
    end = top * (1 - short)
    found = hysteresis(gap_oscillator(), (LOW / TURN, end / TURN), Options(1))
    assert found.complete
    assert not len(found.fold)
    assert TURN * found.branch.frequency[-1] == pytest.approx(end, rel=1e-14)
    assert found.branch.frequency.argmax() == len(found.branch.frequency) - 1
    last = found.branch.amplitude[-1, 0, 0]
    assert np.nanmin(np.abs(frequencies_of(last) - end)) < 1e-7
    assert not found.unstable.any()
    assert short == 1e-2 or last > high  # between the tip and the fold


def test_sweeps_differ_between_the_folds_alone(both_ways):
    (top, _), (bottom, _) = closed_folds()
    hertz, found = np.linspace(LOW, HIGH, 61) / TURN, both_ways
    np.testing.assert_allclose(found.up.frequency, hertz, rtol=1e-14)
    np.testing.assert_allclose(found.down.frequency, hertz, rtol=1e-14)
    omega = TURN * hertz
    np.testing.assert_array_equal(found.differ, (omega > bottom) & (omega < top))
    assert found.differ.sum() > 3
    higher = found.up.amplitude[found.differ, 0, 0] / found.down.amplitude[found.differ, 0, 0]
    assert higher.min() > 1.5


def test_impossible_ranges_are_refused():
    refused("frequencies: given", hysteresis, gap_oscillator(), [1.0], Options(1))
    refused("frequencies: given", hysteresis, gap_oscillator(), (1.0, 1.0), Options(1))


def test_a_path_that_ends_early_says_where_and_why(monkeypatch):
    monkeypatch.setattr("vanelock.nonlinear.forced_response.hysteresis._LIMIT", 20)
    with pytest.warns(RuntimeWarning, match="hysteresis: the path ended at") as warned:
        found = hysteresis(gap_oscillator(), [LOW / TURN, HIGH / TURN], Options(1))
    assert not found.complete
    assert not found.connected
    assert str(warned[0].message) == f"hysteresis: {found.ended}"
    assert warned[0].filename == __file__
    at = f"{found.branch.frequency[-1]:g} Hz of {LOW / TURN:g} ... {HIGH / TURN:g}, after 20 points"
    assert at in found.ended
    assert found.ended.endswith("it goes on, but 20 points are the most")


@pytest.mark.parametrize("more", [0.0, -1e-4])
def test_a_path_goes_on_where_another_branch_crosses_it(more):
    """It does not turn back there, though the sign of det P may change.

    Rounding decides which branch goes on: the same one, on which stability is lost once, or the
    other, on which it is not.
    """
    springs = [1.75, 0.59, 1.74, 0.75]
    chain = np.diag(np.add(springs[:-1], springs[1:]))
    chain -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    K = np.kron(np.eye(2), chain)  # three masses, each of two directions
    own = np.zeros((3, 3, 6))
    own[[0, 2], 0, 0], own[1, 0, 1] = -1.0, 1.0
    own[[0, 2], 1, 3], own[1, 1, 4] = 1.0, 1.0
    diameter = Diameter(K=K, M=np.eye(6), C=0.03 * K, own=own)
    contacts = Contacts([7.8] * 3, [[5.5] * 2] * 3, [0.3] * 3, [0.1, -0.1, 0.1])
    force = {1: Force([0.15 * (1 + more), 0, 0, 0, 0, 0])}
    system = System(1, 0, {0: diameter}, contacts, force)
    found = hysteresis(system, [0.8 / TURN, 2.2 / TURN], Options(1))
    assert found.complete
    assert found.upper.tolist() == [True, False]
    assert len(found.several) == 1
    crossed = np.flatnonzero(np.diff(found.unstable) != 0) + 1
    fallen = np.setdiff1d(crossed, np.concatenate([found.fold, found.fold + 1]))
    assert len(fallen) <= 1
    assert (np.diff(found.branch.frequency[found.fold[-1] :]) > 0).all()


MASK = np.array([True, False, True, True, False, False])
METHODS = [
    ("coupled", "isotropic"),
    ("uncoupled", "orthogonal"),
    ("uncoupled", "isotropic"),
    ("constant-load", "orthogonal"),
    ("constant-load", "isotropic"),
]


def two_joints():
    """Six contacts of two joints, under a static load too."""
    joint = tuple("rim" if m else "root" for m in MASK)
    return with_rest(with_contacts(random_system(1, preload=3.0), joint=joint))


def changed(system, name, value, mask=slice(None)):
    """The system at a value of the parameter, written out once more."""
    if name == "force":
        return replace(system, force={**system.force, 1: Force(value * system.force[1].vector)})
    key = {"mu": "mu", "interference": "v0"}[name]
    moved = getattr(system.contacts, key).copy()
    moved[mask] = value
    return with_contacts(system, **{key: moved})


def differ(one, other):
    """Largest difference of contacts, forces and outputs, each relative to the largest."""
    pairs = [(getattr(one, name), getattr(other, name)) for name in ("contact", "force", "output")]
    return max(np.abs(a - b).max() / np.abs(b).max() for a, b in pairs)


@pytest.mark.parametrize(("name", "joint", "low", "high", "coupling", "friction"), [
    ("force", None, 1e-3, 30.0, "coupled", "orthogonal"),
    ("mu", None, 0.03, 0.6, "coupled", "orthogonal"),
    ("mu", "rim", 0.03, 0.6, "coupled", "orthogonal"),
    ("interference", "rim", -2.0, 8.0, "coupled", "orthogonal"),
    ("interference", None, 0.1, 20.0, "coupled", "orthogonal"),
    ("force", None, 0.03, 0.6, "coupled", "isotropic"),
    ("mu", None, 0.03, 0.6, "uncoupled", "orthogonal"),
    ("interference", None, -1.0, 6.0, "uncoupled", "isotropic"),
    ("force", None, 0.03, 0.6, "constant-load", "orthogonal"),
    ("mu", None, 0.03, 0.6, "constant-load", "isotropic"),
])  # fmt: skip
def test_values_give_what_systems_changed_by_hand_give(name, joint, low, high, coupling, friction):
    system = two_joints() if friction == "orthogonal" else even(two_joints())
    hertz, options = 1.3 * first_frequency(system), Options(1, coupling, friction)
    values = np.linspace(low, high, 8) if low < 0 else np.geomspace(low, high, 8)
    up, down = (
        parameter_response(
            system, hertz, name, values, replace(options, direction=direction), joint=joint
        )
        for direction in ("up", "down")
    )
    for found in (up, down):
        assert found.response.converged.all()
        np.testing.assert_array_equal(found.parameter, values)
    assert np.any(up.response.dissipation > 0)
    assert len(np.unique(up.response.state)) > 1 or coupling != "coupled"
    for i in (0, 4, 7):
        one = changed(system, name, values[i], MASK if joint else slice(None))
        direct = solved_response(one, [hertz], options)
        for found in (up, down):
            assert differ(found.at(i), direct) < 1e-7
            work, expected = found.response.dissipation[i], direct.dissipation[0]
            np.testing.assert_allclose(work, expected, atol=1e-7 * expected.max())
        np.testing.assert_array_equal(up.at(i).mu, direct.mu)


def test_points_keep_their_own_friction_and_survive_a_file(tmp_path):
    system = two_joints()
    hertz = 1.3 * first_frequency(system)
    found = parameter_response(system, hertz, "mu", [0.2, 0.05], Options(3), joint="root")
    np.testing.assert_array_equal(found.mu, np.where(MASK, 0.3, np.array([[0.2], [0.05]])))
    found.save(tmp_path / "mu.h5")
    again = ParameterResponse.load(tmp_path / "mu.h5")
    assert again.name == "mu"
    np.testing.assert_array_equal(again.response.contact, found.response.contact)
    for point, mu in enumerate((0.2, 0.05)):
        one = again.at(point)
        contact = int(np.flatnonzero(~MASK)[np.argmax(one.dissipation[0, ~MASK])])
        u, f = contact_loop(one, 0, contact, 4000)
        assert np.abs(f[:, 1:]).max() <= mu * f[:, 0].max() * (1 + 1e-9)
        np.testing.assert_allclose(loop_area(u, f), one.dissipation[0, contact], rtol=1e-3)


@pytest.mark.parametrize(("options", "message"), [
    ({"parameter": "kn"}, "parameter: given 'kn'"),
    ({"values": []}, "values: given none"),
    ({"values": [0.0, 1.0]}, "values: given 0: mu must be > 0"),
    ({"values": [[1.0]]}, "needs a list"),
    ({"joint": "hub"}, "joints are rim, root"),
    ({"parameter": "force", "joint": "rim"}, "the force acts on no joint"),
    ({"frequency": [1.0, 2.0]}, r"frequency: given \[1.0, 2.0\]: needs a number"),
])  # fmt: skip
def test_impossible_arguments_are_refused(options, message):
    asked = {"frequency": 1.0, "parameter": "mu", "values": [0.1], **options}
    refused(message, parameter_response, two_joints(), **asked)


@pytest.mark.parametrize(("coupling", "friction"), METHODS)
def test_hysteresis_is_that_of_sweeps_by_frequency(coupling, friction):
    system, options = with_rest(even(random_system(1, preload=3.0))), Options(2, coupling, friction)
    hertz = np.linspace(0.8, 1.5, 7) * first_frequency(system)
    found = hysteresis(system, hertz, options)
    assert found.complete
    assert found.connected
    for sweep, direction in ((found.up, "up"), (found.down, "down")):
        one_way = replace(options, direction=direction)
        direct = solved_response(system, hertz, one_way)
        assert differ(sweep, direct) < 1e-11
        assert (sweep.coupling, sweep.friction) == (coupling, friction)
        assert sweep.samples == 0
    if not len(found.fold):
        direct = solved_response(system, found.branch.frequency, options)
        assert differ(found.branch, direct) < 1e-9
    assert len(found.fold) == (2 if coupling == "coupled" else 0)


@pytest.mark.parametrize(
    ("name", "coupling", "friction"),
    [(list(_NAMES)[::-1][i % len(_NAMES)], *method) for i, method in enumerate(METHODS)],
)
def test_peaks_are_the_largest_of_a_fine_sweep(name, coupling, friction):
    system = sliding_system(preload=0.6)
    exact = 1e-6 if friction == "isotropic" else 1e-9  # slip in the plane is collocated
    options = Options(3, coupling, friction)
    values = [0.5, 1.0, 2.0] if name != "mu" else [0.1, 0.3, 0.6]
    found = peak_response(system, name, values, (0.15, 0.22), options)
    assert found.converged.all()
    assert not np.any(found.response.state == STUCK)
    for i, value in enumerate(values):
        hertz = found.frequency[i] + found.width[i] * np.linspace(-1, 1, 41)
        moved = changed(system, name, value)
        swept = solved_response(moved, hertz, options)
        size = swept.amplitude[:, 0, found.direction]
        assert size.max() < (1 + exact) * found.amplitude[i]
        assert abs(int(size.argmax()) - 20) <= (0 if exact < 1e-8 else 1)
        assert differ(found.at(i), swept.at([20])) < 1e-8


def test_modes_left_out_are_estimated_wherever_a_state_was_solved():
    system = random_system(1, preload=3.0)
    hertz = 1.3 * first_frequency(system)
    # Of a range, the highest frequency counts.
    options, ends = Options(2, static_beyond=2.0), (0.9 * hertz, hertz)
    along = parameter_response(system, hertz, "mu", [0.2, 0.3], options).response
    direct = frequency_response(system, [hertz], options)
    assert differ(along.at([1]), direct) < 1e-8
    assert direct.truncation[0] > 1e-3
    assert along.truncation[1] == pytest.approx(direct.truncation[0], rel=1e-3)
    options = replace(options, coupling="uncoupled")
    both = hysteresis(system, ends, options)
    swept = frequency_response(system, both.branch.frequency, options)
    assert SLIP_OPEN in swept.state
    np.testing.assert_allclose(both.branch.truncation, swept.truncation, rtol=1e-2)
