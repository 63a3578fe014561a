"""Curves: points that are hard to reach, ranges, directions, loops, files."""

from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    STUCK,
    Options,
    Response,
    System,
    contact_loop,
    frequency_response,
    linear_response,
)
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.families import Loads
from vanelock.nonlinear.forced_response.response import half_peak_to_peak
from vanelock.nonlinear.newton.newton import solve
from vanelock.rom.system.system import Contacts, Diameter, Force

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]
Make = Callable[..., System]
Lowest = Callable[[System], float]


@pytest.mark.parametrize(("seed", "preload"), [(0, 10.0), (2, 0.1), (3, 1.0)])
def test_every_point_from_stick_to_rattling_converges_and_is_right(
    random_system: Make,
    first_frequency: Lowest,
    march: Callable[..., Floats],
    coefficients: Callable[..., Array],
    seed: int,
    preload: float,
) -> None:
    system = random_system(seed, preload=preload)
    hertz = np.linspace(0.5, 1.7, 16) * first_frequency(system)
    for harmonics in (1, 3):
        response = frequency_response(system, hertz, Options(harmonics), find_jumps=False)
        assert response.converged.all()
        assert response.residual.max() < 1e-10
        q, force = (np.moveaxis(each[::5], 0, 1) for each in (response.contact, response.force))
        apart = coefficients(march(system.contacts, q, 2000), harmonics) - force
        assert np.abs(apart).max() < 2e-2 * np.abs(response.force).max()  # the marching's own error


def test_states_run_from_stuck_through_slip_to_opening(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(1, preload=10.0)
    hertz = np.linspace(0.5, 2.5, 30) * first_frequency(system)
    seen: set[int] = set()
    for factor in (0.01, 1.0, 10.0):
        load = {1: Force(system.force[1].vector * factor)}
        response = frequency_response(replace(system, force=load), hertz, Options(1))
        assert response.converged.all()
        seen |= set(response.state.ravel().tolist())
    assert {STUCK, SLIP, SLIP_OPEN} <= seen


def gap_oscillator() -> System:
    """A mass on a spring with a gap to a stop: its curve bends over and folds twice."""
    return System(
        sectors=1,
        engine_order=0,
        diameters={
            0: Diameter(
                K=np.ones((1, 1), complex),
                M=np.ones((1, 1), complex),
                C=np.full((1, 1), 0.02, complex),
                own=np.array([[[1], [0], [0]]], complex),
                output=np.array([[[1], [0], [0]]], complex),
            )
        },
        contacts=Contacts(np.ones(1), np.ones((1, 2)), np.zeros(1), np.full(1, -1.0)),
        force={1: Force(np.array([0.15], complex))},
        output_names=("mass",),
    )


def test_sweeps_up_and_down_take_their_own_branch_through_folds() -> None:
    system = gap_oscillator()
    hertz = np.linspace(0.85, 1.6, 60) / (2 * np.pi)
    up = frequency_response(system, hertz, Options(1, direction="up"))
    down = frequency_response(system, hertz, Options(1, direction="down"))
    assert up.converged.all()
    assert down.converged.all()
    np.testing.assert_array_equal(up.frequency, hertz)
    np.testing.assert_allclose(down.frequency, hertz, rtol=1e-15)
    high, low = up.amplitude[:, 0, 0], down.amplitude[:, 0, 0]
    apart = np.abs(high - low) > 0.1 * high
    assert 4 < apart.sum() < 40
    assert np.all(high[apart] > 1.5 * low[apart])
    # On the low branch the mass does not reach the stop: that branch is linear.
    linear = linear_response(system, hertz, "none").amplitude[:, 0, 0]
    assert np.all(linear[apart] < 1)
    np.testing.assert_allclose(low[apart], linear[apart], rtol=1e-9)


def test_load_raised_step_by_step_meets_the_direct_solution(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(4, preload=3.0)
    balance = structure(system, 3).balance(2 * np.pi * 1.5 * first_frequency(system))
    law = contact_law(system.contacts, 3)
    direction = balance.linear.copy()
    direction[:, :, 0] = 0
    family = Loads(replace(balance, linear=balance.linear - direction), direction, law)
    still = solve(family, np.zeros_like(direction), 0.0)
    assert still.converged
    arc = follow(family, still, 1.0)
    assert arc.solution is not None
    direct = frequency_response(system, [balance.omega / (2 * np.pi)], Options(3))
    assert direct.converged.all()
    expected = np.moveaxis(direct.contact[0, 1:].real, 0, -1)
    np.testing.assert_allclose(arc.solution.u[:, :, 1::2], expected, atol=1e-8)


def test_range_follows_the_curve(random_system: Make, first_frequency: Lowest) -> None:
    system = random_system(5, preload=10.0, damping_ratio=0.003)
    low, high = np.array([0.6, 2.2]) * first_frequency(system)
    calls: list[tuple[int, int, float, float]] = []
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


def test_listed_frequencies_come_back_as_given(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(1)
    hertz = first_frequency(system) * np.array([1.4, 0.6, 1.0])
    calls: list[tuple[int, int, float, float]] = []
    response = frequency_response(
        system, hertz, Options(1), progress=lambda *each: calls.append(each)
    )
    np.testing.assert_allclose(response.frequency, hertz, rtol=1e-15)
    single = frequency_response(system, hertz[:1], Options(1))
    np.testing.assert_allclose(response.x[1][0], single.x[1][0], atol=1e-8)
    assert [each[:2] for each in calls] == [(1, 3), (2, 3), (3, 3)]


def test_loop_encloses_the_work_and_has_the_forces_of_the_balance(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(0, preload=1.0)
    response = frequency_response(system, [1.2 * first_frequency(system)], Options(3))
    assert np.any(response.state == SLIP_OPEN)
    for contact in range(6):
        u, f = contact_loop(response, 0, contact, 20000)
        spectrum = np.fft.rfft(f, axis=0)[:4] / len(f)
        spectrum[1:] *= 2
        np.testing.assert_allclose(spectrum, response.force[0, :, contact], atol=1e-5)
        area = sum(float(np.sum(f[:, d] * np.gradient(wrapped(u[:, d]))[1:-1])) for d in (1, 2))
        np.testing.assert_allclose(area, response.dissipation[0, contact], atol=1e-4)
        assert np.all(np.abs(f[:, 1:]) <= 0.3 * f[:, :1] + 1e-12)
    with pytest.raises(InputError, match="contact: given 6"):
        contact_loop(response, 0, 6)


def test_loop_is_refused_where_it_would_not_have_the_forces_of_the_response(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(0, preload=1.0)
    hertz = [1.2 * first_frequency(system)]
    response = frequency_response(system, hertz, Options(3))
    lost = replace(response, converged=np.zeros(1, bool))
    with pytest.raises(InputError, match="point: given 0: not converged"):
        contact_loop(lost, 0, 0)
    slipping = int(np.argmax(response.dissipation[0]))
    sampled = frequency_response(system, hertz, Options(3, samples=32))
    assert sampled.converged.all()
    for other in (sampled, linear_response(system, hertz, "all", harmonics=3)):
        with pytest.raises(InputError, match=f"contact {slipping} has forces"):
            contact_loop(other, 0, slipping)
    # Within the bound of friction, springs are what the law says.
    stuck = linear_response(random_system(1, preload=100.0, mu=50.0), hertz, "all", harmonics=3)
    u, f = contact_loop(stuck, 0, 0, 64)
    np.testing.assert_allclose(f, u * stuck.stiffness[0], rtol=1e-12)


def wrapped(history: Floats) -> Floats:
    """A period with its neighbours, so that differences close on themselves."""
    return np.concatenate([history[-1:], history, history[:1]])


def test_amplitude_is_half_the_peak_to_peak() -> None:
    rng = np.random.default_rng(0)
    for harmonics in (1, 2, 5):
        shape = (harmonics + 1, 20)
        q = rng.normal(size=shape) + 1j * rng.normal(size=shape)
        angle = 2 * np.pi * np.arange(100000)[:, None] / 100000
        history = sum((q[h] * np.exp(1j * h * angle)).real for h in range(harmonics + 1))
        np.testing.assert_allclose(half_peak_to_peak(q), np.ptp(history, axis=0) / 2, rtol=1e-7)


def test_response_survives_its_file(
    random_system: Make, first_frequency: Lowest, tmp_path: Path
) -> None:
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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"frequencies": [0.0, 1.0]}, "frequencies: given 0.0 Hz"),
        ({"frequencies": (2.0, 1.0)}, "a range is"),
        ({"frequencies": []}, "at least one"),
    ],
)
def test_impossible_frequencies_are_refused(
    random_system: Make, options: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        frequency_response(random_system(0), **options)


def test_a_structure_without_contacts_is_linear() -> None:
    bare = System(
        sectors=1,
        engine_order=0,
        diameters={
            0: Diameter(
                np.eye(1) + 0j, np.eye(1) + 0j, np.zeros((0, 3, 1)) + 0j, C=0.1j * -1j * np.eye(1)
            )
        },
        contacts=Contacts(np.ones(0), np.ones((0, 2)), np.zeros(0), np.ones(0)),
        force={0: Force(np.full(1, 2.0 + 0j)), 1: Force(np.ones(1, complex))},
    )
    hertz = np.array([0.1, 0.2])
    omega = 2 * np.pi * hertz
    expected = 1 / (1 - omega**2 + 0.1j * omega)
    for response in (frequency_response(bare, hertz, Options(2)), linear_response(bare, hertz)):
        assert response.converged.all()
        np.testing.assert_allclose(response.x[1][:, 0], expected, rtol=1e-12)
        np.testing.assert_allclose(response.x[0][:, 0], 2, rtol=1e-12)


@pytest.mark.parametrize(
    ("stiffness", "mass", "expected"),
    [
        (-1.0, 1.0, "some motion meets a negative stiffness"),
        (0.0, 0.0, "motion without mass is held"),
    ],
)
def test_what_no_contact_can_hold_is_refused(stiffness: float, mass: float, expected: str) -> None:
    loose = System(
        sectors=1,
        engine_order=0,
        diameters={
            0: Diameter(
                np.diag([0, stiffness]) + 0j,
                np.diag([1, mass]) + 0j,
                np.array([[[1, 0], [0, 0], [0, 0]]]) + 0j,
            )
        },
        contacts=Contacts(np.ones(1), np.ones((1, 2)), np.zeros(1), np.ones(1)),
    )
    with pytest.raises(InputError, match=expected):
        frequency_response(loose, [1.0], Options(1))


def test_a_system_without_outputs_has_none_in_three_directions(sliding_system: Make) -> None:
    bare = {k: replace(each, output=None) for k, each in sliding_system().diameters.items()}
    system = replace(sliding_system(), diameters=bare, output_names=())
    assert frequency_response(system, [0.18], Options(3)).output.shape == (1, 4, 0, 3)
