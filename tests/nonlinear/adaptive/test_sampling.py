"""Where points are put: the curve between them, branches of a closed form, neglected harmonics."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.nonlinear.systems import sliding_system, solved_response
from tests.refusals import refused
from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock.nonlinear import Options, frequency_response, neglected_harmonics
from vanelock.nonlinear.adaptive.interpolant import Interpolant
from vanelock.nonlinear.adaptive.sampling import Exploring


@dataclass(frozen=True)
class Branch:
    """Solutions from one frequency to another."""

    low: float
    high: float
    height: Callable[[float], float]

    def at(self, omega):
        """A point as the solver makes it."""
        step = 1e-5
        slope = (self.height(omega + step) - self.height(omega - step)) / (2 * step)
        return SimpleNamespace(
            omega=omega,
            amplitude=self.height(omega),
            slope=slope,
            harmonics=1,
            wanted=1,
            estimate=True,
            solution=SimpleNamespace(converged=True),
            branch=self,
        )


class Solver:
    """Stays on a branch where it goes on, else takes the first that there is."""

    shares = SimpleNamespace(frequencies=1e-3, harmonics=1e-3)
    chooses_harmonics = False
    least = 1

    def __init__(self, *branches):
        self.branches, self.count = branches, 0
        system = SimpleNamespace(damping_ratio=0.01)
        self.levels = SimpleNamespace(structure=lambda _: SimpleNamespace(system=system))
        self.estimator = SimpleNamespace(monitored=(0, 0))

    def easily(self, omega, neighbours):
        """The branch of the neighbour."""
        if not neighbours or not neighbours[-1].branch.low <= omega <= neighbours[-1].branch.high:
            return None
        return neighbours[-1].branch

    def point(self, omega, neighbours, found=None, least=0):
        """A point."""
        self.count += 1
        branch = found or self.easily(omega, neighbours)
        own = (each for each in self.branches if each.low <= omega <= each.high)
        return (branch or next(own)).at(omega)

    def with_harmonics(self, harmonics):
        """One that takes the same number everywhere."""
        return Solver(*self.branches)

    def with_measured_error(self, point):
        """The same."""
        return point


class Changing(Solver):
    """Leaves a branch where the number of harmonics changes."""

    chooses_harmonics = True
    change = 1.6

    def easily(self, omega, neighbours):
        """Not on the other side of the change."""
        if neighbours and (neighbours[-1].omega < self.change) != (omega < self.change):
            return None
        return super().easily(omega, neighbours)


def highest(solver):
    """Frequency and height of the curve's largest point, no frequency being there twice."""
    points = Exploring(solver, 1.0, 2.0, lambda *_: None).curve()  # type: ignore[arg-type]
    top = max(points, key=lambda p: p.amplitude)
    assert [p.omega for p in points] == sorted({p.omega for p in points})
    return top.omega, top.amplitude


def bump(middle, height, width=0.05):
    """A resonance."""
    return lambda omega: height / np.sqrt(1 + ((omega - middle) / width) ** 2)


FIRST, HIGHER = Branch(1.0, 1.6, bump(1.6, 1.0, 0.3)), bump(1.3, 2.0)
HIDDEN = {
    # At 1.6 a sixth as high as the first.
    "met by a sweep down alone": (1.3, Solver(FIRST, Branch(1.25, 2.0, HIGHER))),
    # A sweep down comes from the third to the first; from the jump the second is followed up.
    "lower where it is jumped to": (
        1.3,
        Solver(
            Branch(1.0, 1.6, bump(1.5, 1.0, 0.4)),
            Branch(1.2, 1.7, HIGHER),
            Branch(1.55, 2.0, bump(1.9, 0.5)),
        ),
    ),
    # Both sweeps, and what is followed from the jump at 1.8, leave it at 1.6 for the first one.
    "left where the harmonics change": (
        1.4,
        Changing(Branch(1.0, 1.8, bump(1.5, 1.0, 0.3)), Branch(1.3, 2.0, bump(1.4, 2.0))),
    ),
}


@pytest.mark.parametrize("name", HIDDEN)
def test_a_higher_branch_is_found_that_is(name):
    place, solver = HIDDEN[name]
    assert highest(solver) == pytest.approx((place, 2.0), abs=1e-3)


class Losing(Solver):
    """Has no solution where one is looked for at a summit."""

    def point(self, omega, neighbours, *more):
        """A point, or none."""
        point = super().point(omega, neighbours, *more)
        if abs(omega - 1.4) < 1e-3:
            point.estimate, point.amplitude, point.slope = None, 0.0, np.nan
            point.solution.converged = False
        return point


def test_a_frequency_without_a_solution_is_tried_once():
    assert highest(Losing(Branch(1.0, 2.0, bump(1.4, 1.0, 0.01))))[1] < 0.999


def _resonance(x):
    """A peak of unit height and half-width at 0, and its slope."""
    return 1 / np.sqrt(1 + x**2), -x / (1 + x**2) ** 1.5


@pytest.mark.parametrize("points", [9, 15, 25])
def test_estimated_error_is_no_less_than_the_true_one_and_not_far_more(points):
    x = np.sinh(np.linspace(-2, 2, points))
    curve = Interpolant(x, *_resonance(x))
    estimated = curve.uncertainty()
    fine = x[:-1, None] + np.diff(x)[:, None] * np.linspace(0, 1, 40)
    true = np.abs(curve.at(fine.ravel()).reshape(fine.shape) - _resonance(fine)[0]).max(axis=1)
    assert estimated.max() > true.max()
    assert estimated.max() < 80 * true.max()


def test_no_curve_is_trusted_across_a_gap_where_it_is_high():
    # Two peaks: seen from points that miss the narrow one, the curve is smooth.
    x = np.linspace(-8, 8, 17)
    y, slope = _resonance(x / 8)
    curve = Interpolant(x, y, slope / 8)
    assert not len(curve.wanted(0.05, 1e-3))
    wanted = curve.wanted(0.05, 1e-3, 0.5)
    np.testing.assert_allclose(wanted, x[:-1] + 0.5)


def test_every_high_maximum_is_located():
    # Two maxima, the lower one between points: it may turn out the higher one.
    x = np.array([-3.0, -2.5, -2.0, -1.5, -1.0, -0.5, 0.0, 0.6, 1.3, 2.0, 2.5, 3.0])
    lower = 0.95 * np.exp(-((x - 1.0) ** 2))
    higher = np.exp(-((x + 2.0) ** 2))
    curve = Interpolant(x, lower + higher, -2 * (x - 1.0) * lower - 2 * (x + 2.0) * higher)
    (place,) = curve.wanted(0.05, 1e-3)
    assert abs(place - 1.0) < 0.02


@pytest.mark.parametrize("coupling", ["coupled", "uncoupled"])
@pytest.mark.parametrize("harmonics", [1, 3])
def test_estimate_is_the_change_by_many_more(coupling, harmonics):
    system, hertz = sliding_system(preload=0.5), np.linspace(0.17, 0.19, 5)
    found, best = (solved_response(system, hertz, Options(H, coupling)) for H in (harmonics, 15))
    own = [neglected_harmonics(system, found, point, (0, 0)) for point in range(5)]
    made = np.abs(best.amplitude[:, 0, 0] / found.amplitude[:, 0, 0] - 1)
    assert made.max() > 1e-5
    assert 0.5 < max(own) / made.max() < 2


def test_where_the_first_step_leads_astray_the_balance_is_solved():
    """Near a fold, where it would change the amplitude 169 times over."""
    system = loaded(spring_ring(4), 2 * worst_of(4)["slip"][1])
    few, more = (frequency_response(system, [0.18619], Options(H)) for H in (1, 3))
    made = abs(more.amplitude[0, 0, 0] / few.amplitude[0, 0, 0] - 1)
    assert neglected_harmonics(system, few, 0, (0, 0)) == pytest.approx(made, rel=1e-6)


def test_what_sticks_neglects_nothing_and_what_is_lost_is_not_judged():
    system = sliding_system(preload=50.0)
    found = frequency_response(system, [0.17], Options(3))
    assert neglected_harmonics(system, found, 0, (0, 0)) == pytest.approx(0.0, abs=1e-12)
    lost = replace(found, converged=np.zeros(1, bool))
    assert np.isnan(neglected_harmonics(system, lost, 0, (0, 0)))
    refused("points: given 1: there are 1", neglected_harmonics, system, found, 1, (0, 0))
