"""Jumps of a sweep against the folds of an oscillator that hits a stop, in closed form."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.nonlinear.following.test_hysteresis import closed_folds, gap_oscillator
from vanelock.nonlinear import Options, Shares, adaptive_response, frequency_response
from vanelock.nonlinear.fourier import TURN

LOW, HIGH = 0.85, 1.6
ENDS = (LOW / TURN, HIGH / TURN)


@pytest.mark.parametrize("direction", ["up", "down"])
@pytest.mark.parametrize("points", [None, 12])
def test_a_sweep_says_where_it_jumps_and_from_what_to_what(
    direction: str, points: int | None
) -> None:
    upper, lower = closed_folds()
    fold = (upper if direction == "up" else lower)[0]
    wanted: tuple[float, float] | NDArray[np.float64] = ENDS
    if points is not None:
        wanted = np.linspace(*ENDS, points)
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
def test_where_nothing_folds_nothing_jumps(points: int | None) -> None:
    ends = (1.2 / TURN, 1.6 / TURN)
    wanted = ends if points is None else np.linspace(*ends, points)
    found = frequency_response(gap_oscillator(), wanted, Options(3))
    assert found.jump is not None
    assert found.jump.shape == (0, 2)


def test_points_of_a_response_alone_have_no_jumps() -> None:
    found = frequency_response(gap_oscillator(), np.linspace(*ENDS, 12), Options(1))
    some = found.at([3, 4])
    assert some.jump is None
    assert some.direction == "up"
    again = frequency_response(gap_oscillator(), found.frequency, Options(1), find_jumps=False)
    assert again.jump is None
    np.testing.assert_array_equal(again.x[1], found.x[1])


@pytest.mark.parametrize("direction", ["up", "down"])
def test_with_an_accuracy_one_way_is_that_way_s_branch(direction: str) -> None:
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
        same = frequency_response(system, found.frequency, options, find_jumps=False)
        np.testing.assert_allclose(found.amplitude, same.amplitude, rtol=0, atol=1e-9)
    chosen = adaptive_response(
        lambda _: system, ENDS, Shares(0.01, 0.01), Options(direction=direction)
    )
    exact = frequency_response(system, ENDS, Options(9, direction=direction), find_jumps=False)
    assert chosen.harmonics > 1
    assert chosen.amplitude.max() == pytest.approx(exact.amplitude.max(), rel=0.01)


def test_with_an_accuracy_the_jump_is_that_of_the_highest_solutions() -> None:
    (fold, height), _ = closed_folds()
    shares = Shares(harmonics=0.03, frequencies=0.03)
    found = adaptive_response(lambda _: gap_oscillator(), ENDS, shares, Options(1))
    assert found.direction == "both"
    assert found.jump is not None
    ((before, after),) = found.jump
    assert TURN * found.frequency[before] <= fold <= TURN * found.frequency[after]
    assert found.amplitude[before, 0, 0] == pytest.approx(height, rel=0.05)
