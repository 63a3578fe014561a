"""The choice of frequencies on branches given in closed form, ends and all."""

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

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


def test_where_nothing_jumps_further_sweeps_are_no_waste(monkeypatch):
    monkeypatch.delattr(Solver, "with_harmonics")
    solver = Solver(Branch(1.0, 2.0, bump(1.4, 1.0)))
    solver.chooses_harmonics = True
    omega, height = highest(solver)
    assert (omega, height) == pytest.approx((1.4, 1.0), abs=1e-3)
    assert solver.count < 130


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
