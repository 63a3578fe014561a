"""Curves: ranges, directions, jumps at folds in closed form, loops, files."""

from dataclasses import fields, replace

import numpy as np
import pytest

from tests.nonlinear.forced_response.test_hysteresis import closed_folds
from tests.nonlinear.systems import (
    alike_contacts,
    coefficients,
    even,
    first_frequency,
    gap_oscillator,
    loop_area,
    random_system,
    sliding_system,
    solved_response,
)
from tests.refusals import refused
from vanelock.nonlinear import (
    SLIP_OPEN,
    Diameter,
    Options,
    Response,
    Shares,
    System,
    adaptive_response,
    contact_loop,
    frequency_response,
    linear_response,
)
from vanelock.nonlinear.forced_response.response import half_peak_to_peak
from vanelock.nonlinear.fourier import TURN


def test_range_follows_the_curve():
    system = random_system(5, preload=10.0, damping_ratio=0.003)
    low, high = np.array([0.6, 2.2]) * first_frequency(system)
    calls = list[tuple[int, int, float, float]]()
    found = frequency_response(
        system, (float(low), float(high)), Options(1), progress=lambda *each: calls.append(each)
    )
    assert found.converged.all()
    assert found.frequency[0] == low
    assert found.frequency[-1] == pytest.approx(high, rel=1e-15)
    assert np.all(np.diff(found.frequency) > 0)
    fine = frequency_response(system, np.linspace(low, high, 1501), Options(1))
    exact, coarse = fine.amplitude[:, 0].max(axis=1), found.amplitude[:, 0].max(axis=1)
    assert found.points < 400
    drawn = np.interp(fine.frequency, found.frequency, coarse)
    assert np.abs(drawn - exact).max() < 0.03 * exact.max()
    assert coarse.max() > 0.999 * exact.max()
    assert [each[0] for each in calls] == list(range(1, len(calls) + 1))
    assert calls[-1][1] == calls[-1][0]
    assert max(each[3] for each in calls) <= found.amplitude.max()


def test_listed_frequencies_come_back_as_given():
    system = random_system(1)
    hertz = first_frequency(system) * np.array([1.4, 0.6, 1.0])
    calls = list[tuple[int, int, float, float]]()
    response = frequency_response(
        system, hertz, Options(1), progress=lambda *each: calls.append(each)
    )
    np.testing.assert_allclose(response.frequency, hertz, rtol=1e-15)
    single = frequency_response(system, hertz[:1], Options(1))
    np.testing.assert_allclose(response.x[1][0], single.x[1][0], atol=1e-8)
    assert [each[:2] for each in calls] == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize("friction", ["orthogonal", "isotropic"])
def test_loop_encloses_the_work_and_has_the_forces_of_the_balance(friction):
    system = even(random_system(0, preload=1.0))
    hertz = [1.2 * first_frequency(system)]
    response = solved_response(system, hertz, Options(3, friction=friction))
    assert np.any(response.state == SLIP_OPEN)
    size, work = np.abs(response.force).max(), response.dissipation[0]
    for contact in range(6):
        u, f = contact_loop(response, 0, contact, 20000)
        expected = response.force[0, :, contact]
        np.testing.assert_allclose(coefficients(f, 3), expected, atol=1e-4 * size)
        np.testing.assert_allclose(loop_area(u, f), work[contact], atol=1e-3 * work.max())
        slip = np.hypot(*f[:, 1:].T) if friction == "isotropic" else np.abs(f[:, 1:]).max(axis=1)
        assert np.all(slip <= 0.3 * f[:, 0] + 1e-12)
    refused("contact: given 6", contact_loop, response, 0, 6)


def test_loop_is_refused_where_it_would_not_have_the_forces_of_the_response():
    system = random_system(0, preload=1.0)
    hertz = [1.2 * first_frequency(system)]
    response = frequency_response(system, hertz, Options(3))
    lost = replace(response, converged=np.zeros(1, bool))
    refused("point: given 0: not converged", contact_loop, lost, 0, 0)
    slipping = int(np.argmax(response.dissipation[0]))
    sampled = frequency_response(system, hertz, Options(3, samples=32))
    assert sampled.converged.all()
    for other in (sampled, linear_response(system, hertz, "all", harmonics=3)):
        refused(f"contact {slipping} has forces", contact_loop, other, 0, slipping)
    # Within the bound of friction, springs are what the law says.
    stuck = linear_response(random_system(1, preload=100.0, mu=50.0), hertz, "all", harmonics=3)
    u, f = contact_loop(stuck, 0, 0, 64)
    np.testing.assert_allclose(f, u * stuck.stiffness[0], rtol=1e-12)


def test_amplitude_is_half_the_peak_to_peak():
    rng = np.random.default_rng(0)
    for harmonics in (1, 2, 5):
        shape = (harmonics + 1, 20)
        q = rng.normal(size=shape) + 1j * rng.normal(size=shape)
        angle = 2 * np.pi * np.arange(100000)[:, None] / 100000
        history = sum((q[h] * np.exp(1j * h * angle)).real for h in range(harmonics + 1))
        np.testing.assert_allclose(half_peak_to_peak(q), np.ptp(history, axis=0) / 2, rtol=1e-7)


def test_response_survives_its_file(tmp_path):
    system = random_system(1, size=6, contacts=2)
    system.save(tmp_path / "system.h5")
    again = System.load(tmp_path / "system.h5")
    hertz = first_frequency(system) * np.array([0.9, 1.1])
    response, other = (frequency_response(s, hertz, Options(3)) for s in (system, again))
    response.save(tmp_path / "response.h5")
    loaded = Response.load(tmp_path / "response.h5")
    for field in fields(Response):
        kept, read, same = (getattr(r, field.name) for r in (response, loaded, other))
        if isinstance(kept, dict):
            assert list(kept) == list(read)
            kept, read, same = (np.concatenate(list(d.values()), 1) for d in (kept, read, same))
        np.testing.assert_array_equal(kept, read)
        if field.name != "seconds":
            np.testing.assert_array_equal(kept, same)


@pytest.mark.parametrize(("options", "message"), [
    ({"frequencies": [0.0, 1.0]}, "frequencies: given 0.0 Hz"),
    ({"frequencies": (2.0, 1.0)}, "a range is"),
    ({"frequencies": []}, "at least one"),
])  # fmt: skip
def test_impossible_frequencies_are_refused(options, message):
    refused(message, frequency_response, random_system(0), **options)


@pytest.mark.parametrize(("stiffness", "mass", "expected"), [
    (-1.0, 1.0, "some motion meets a negative stiffness"),
    (0.0, 0.0, "motion without mass is held"),
])  # fmt: skip
def test_what_no_contact_can_hold_is_refused(stiffness, mass, expected):
    one = Diameter(np.diag([0, stiffness]), np.diag([1, mass]), [[[1, 0], [0, 0], [0, 0]]])
    loose = System(1, 0, {0: one}, alike_contacts(mu=0.0))
    refused(expected, frequency_response, loose, [1.0], Options(1))


def test_a_system_without_outputs_has_none_in_three_directions():
    bare = {k: replace(each, output=None) for k, each in sliding_system().diameters.items()}
    system = replace(sliding_system(), diameters=bare, output_names=())
    assert frequency_response(system, [0.18], Options(3)).output.shape == (1, 4, 0, 3)


LOW, HIGH = 0.85, 1.6
ENDS = (LOW / TURN, HIGH / TURN)


@pytest.mark.parametrize("direction", ["up", "down"])
@pytest.mark.parametrize("points", [None, 12])
def test_a_sweep_says_where_it_jumps_and_from_what_to_what(direction, points):
    upper, lower = closed_folds()
    fold = (upper if direction == "up" else lower)[0]
    wanted = ENDS if points is None else np.linspace(ENDS[0], ENDS[1], points).tolist()
    found = frequency_response(gap_oscillator(), wanted, Options(1, direction=direction))
    assert found.direction == direction
    assert found.jump is not None
    assert found.jump.shape == (1, 2)
    before, after = found.jump[0]
    ends = sorted(TURN * found.frequency[[before, after]])
    assert ends[0] <= fold <= ends[1]
    assert ends[1] - ends[0] <= (HIGH - LOW) / (400 if points is None else points - 1) * 1.01
    big, small = found.amplitude[[before, after], 0, 0][:: 1 if direction == "up" else -1]
    assert big > 2 * small


@pytest.mark.parametrize("points", [None, 30])
def test_where_nothing_folds_nothing_jumps(points):
    ends = (1.2 / TURN, 1.6 / TURN)
    wanted = ends if points is None else np.linspace(*ends, points)
    found = frequency_response(gap_oscillator(), wanted, Options(3))
    assert found.jump is not None
    assert found.jump.shape == (0, 2)


def test_points_of_a_response_alone_have_no_jumps():
    found = frequency_response(gap_oscillator(), np.linspace(*ENDS, 12), Options(1))
    some = found.at([3, 4])
    assert some.jump is None
    assert some.direction == "up"
    again = solved_response(gap_oscillator(), found.frequency, Options(1))
    assert again.jump is None
    np.testing.assert_array_equal(again.x[1], found.x[1])


@pytest.mark.parametrize("direction", ["up", "down"])
def test_with_an_accuracy_one_way_is_that_way_s_branch(direction):
    system, shares = gap_oscillator(), Shares(harmonics=0.03, frequencies=0.03)
    upper, lower = closed_folds()
    fold = (upper if direction == "up" else lower)[0]
    options = Options(1, direction=direction)
    for wanted in (ENDS, np.linspace(*ENDS, 20)):
        found = adaptive_response(lambda _: system, wanted, shares, options)
        assert found.direction == direction
        assert found.jump is not None
        ((before, after),) = found.jump
        ends = TURN * found.frequency[[before, after]]
        assert ends.min() <= fold <= ends.max()
        assert (ends[0] < ends[1]) == (direction == "up")
        same = solved_response(system, found.frequency, options)
        np.testing.assert_allclose(found.amplitude, same.amplitude, rtol=0, atol=1e-9)
    chosen = adaptive_response(
        lambda _: system, ENDS, Shares(0.01, 0.01), Options(direction=direction)
    )
    exact = solved_response(system, ENDS, Options(9, direction=direction))
    assert chosen.harmonics > 1
    assert chosen.amplitude.max() == pytest.approx(exact.amplitude.max(), rel=0.01)
