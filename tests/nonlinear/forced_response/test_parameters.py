"""Responses and peaks against a parameter, and hysteresis: every coupling and friction."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import (
    even,
    first_frequency,
    loop_area,
    random_system,
    sliding_system,
    with_contacts,
    with_rest,
)
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    SLIP_OPEN,
    STUCK,
    Force,
    Options,
    ParameterResponse,
    contact_loop,
    frequency_response,
    hysteresis,
    parameter_response,
    peak_response,
)
from vanelock.nonlinear.forced_response.options import COUPLINGS
from vanelock.nonlinear.forced_response.parameter_response import _NAMES, checked_parameter
from vanelock.nonlinear.fourier import TURN

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


@pytest.mark.parametrize(
    ("name", "joint", "low", "high", "coupling", "friction"),
    [
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
    ],
)
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
        direct = frequency_response(one, [hertz], options)
        assert direct.converged.all()
        for found in (up, down):
            assert differ(found.at(i), direct) < 1e-7
            work, expected = found.response.dissipation[i], direct.dissipation[0]
            np.testing.assert_allclose(work, expected, atol=1e-7 * expected.max())
        np.testing.assert_array_equal(up.at(i).mu, direct.mu)


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("name", _NAMES)
def test_derivative_to_each_parameter_is_exact(name, coupling):
    system = two_joints()
    hertz = 1.3 * first_frequency(system)
    ready = Options(3, coupling=coupling).prepare(system, [hertz], 1)
    joint = None if name == "force" else "rim"
    varied, _ = checked_parameter(name, system, [0.5, 2.0], joint)
    family = varied.family(ready, TURN * hertz)
    w = 0.1 * np.random.default_rng(0).normal(size=(6, 3, 7))
    place, step = varied.coordinate(0.7), 1e-6

    def deviation(parameter, w=w):
        return family.law(parameter)(family.at(parameter).displacement(w))

    exact = family.rate(place, w, deviation(place), np.arange(w.size))
    measured = (deviation(place + step).w - deviation(place - step).w).reshape(-1) / (2 * step)
    assert np.abs(exact).max() > 0.01
    assert np.abs(measured - exact).max() < 1e-6 * np.abs(exact).max()
    # Nothing at all deviates: the balance must not be written to.
    before, zero = family.at(place).linear.copy(), np.zeros_like(w)
    family.rate(place, zero, deviation(place, zero), np.arange(w.size))
    np.testing.assert_array_equal(family.at(place).linear, before)


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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"parameter": "kn"}, "parameter: given 'kn'"),
        ({"values": []}, "values: given none"),
        ({"values": [0.0, 1.0]}, "values: given 0: mu must be > 0"),
        ({"values": [[1.0]]}, "needs a list"),
        ({"joint": "hub"}, "joints are rim, root"),
        ({"parameter": "force", "joint": "rim"}, "the force acts on no joint"),
        ({"frequency": [1.0, 2.0]}, r"frequency: given \[1.0, 2.0\]: needs a number"),
    ],
)
def test_impossible_arguments_are_refused(options, message):
    asked = {"frequency": 1.0, "parameter": "mu", "values": [0.1], **options}
    with pytest.raises(InputError, match=message):
        parameter_response(two_joints(), **asked)


@pytest.mark.parametrize(("coupling", "friction"), METHODS)
def test_hysteresis_is_that_of_sweeps_by_frequency(coupling, friction):
    system, options = with_rest(even(random_system(1, preload=3.0))), Options(2, coupling, friction)
    hertz = np.linspace(0.8, 1.5, 7) * first_frequency(system)
    found = hysteresis(system, hertz, options)
    assert found.complete
    assert found.connected
    for sweep, direction in ((found.up, "up"), (found.down, "down")):
        one_way = replace(options, direction=direction)
        direct = frequency_response(system, hertz, one_way, find_jumps=False)
        assert direct.converged.all()
        assert differ(sweep, direct) < 1e-11
        assert (sweep.coupling, sweep.friction) == (coupling, friction)
        assert sweep.samples == 0
    if not len(found.fold):
        direct = frequency_response(system, found.branch.frequency, options, find_jumps=False)
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
        swept = frequency_response(moved, hertz, options, find_jumps=False)
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
