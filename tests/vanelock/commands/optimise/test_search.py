"""How peaks are followed from place to place; known minima: smooth, at a ridge, at a bound."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vanelock.commands.fit.parameters import FitParameter
from vanelock.commands.optimise.front import front, undominated
from vanelock.commands.optimise.objective import NEAR, Functions, Peaks, minimax
from vanelock.commands.optimise.search import Progress, optimum, searched, spread
from vanelock.common.errors import InputError
from vanelock.nonlinear.peaks.peak import CurvePoint


@dataclass(frozen=True)
class Place:
    """What a solution has that counts here."""

    omega: float
    w: np.ndarray[Any, Any]
    reuse: Any = None


def peak(omega, amplitude):
    where = Place(omega, np.full((2, 3, 3), omega), "a preconditioner")
    return CurvePoint(where, amplitude, -1.0, 0.0, 1, False)  # type: ignore[arg-type]


def model(harmonics=1):
    study = SimpleNamespace(response=SimpleNamespace(harmonics=harmonics))
    return SimpleNamespace(study=study, prepared=lambda values, near, slider: values)


class Hills(Peaks):
    """Peaks at circular frequencies that follow x; those close enough to be found are found.

    Attributes
    ----------
    reach : float
        Farthest step, of x or beyond where rates lead, on which a peak is found.
    hills : list of (frequency at x, amplitude at x, where it exists)
    """

    reach = 0.3
    hills = ((lambda x: 100 + 10 * x, lambda x: 1 + (x - 1) ** 2, lambda x: True),)

    def _stepped(self, ready, known, rates):
        x, found = np.log(ready["mu"]), []
        for i, last in enumerate(known):
            omega = last.solution.omega + (rates[i][0] if rates else 0.0)
            for where, size, lives in self.hills:
                if lives(x) and abs(where(x) - omega) < 10 * self.reach:
                    found.append(peak(where(x), size(x)))
                    break
            else:
                return []
        self.solved += len(found)
        return found

    def _swept(self, ready):
        self.sweeps = getattr(self, "sweeps", 0) + 1
        x = np.log(ready["mu"])
        every = [peak(where(x), size(x)) for where, size, lives in self.hills if lives(x)]
        highest = max((each.amplitude for each in every), default=0.0)
        return [each for each in every if each.amplitude > 0.5 * highest]

    def _functions(self, ready, x, found):
        if not found:
            return None
        self.known, self.place = found, x
        sizes = [each.amplitude for each in found]
        step, slopes = 1e-6, []
        for each in found:
            size = min(self.hills, key=lambda hill: abs(hill[0](x[0]) - each.solution.omega))[1]
            slopes.append([(size(x[0] + step) - size(x[0] - step)) / (2 * step)])
        return Functions(np.array(sizes), np.array(slopes))

    def with_one_harmonic(self):  # noqa: D102
        return replace(self)


def hills(**attributes):
    kind = type("Hills", (Hills,), attributes)
    return kind(model(), (FitParameter("mu", 1.0, np.exp(-4.0), np.exp(4.0)),), (0.0, 100.0))


def at(x):
    return np.array([float(x)])


def test_a_peak_that_a_sweep_met_is_looked_for_again_near_there():
    low = (lambda x: 100.0, lambda x: 1 + 0.01 * x, lambda x: True)
    high = (lambda x: 200.0, lambda x: 5.0, lambda x: x > 1)
    two = hills(hills=(low, high), reach=1.0)
    assert two(at(0.0)).value.tolist() == [1.0]
    assert two(at(1.2)).value.tolist() == [pytest.approx(1.012)]  # follows the low one alone
    assert two.afresh(at(1.2)).value.tolist() == [5.0, pytest.approx(1.012)]
    two.known = [each for each in two.known if each.amplitude < 2]
    assert two(at(1.2 + 0.9 * NEAR)).value.tolist() == [pytest.approx(1.021), 5.0]
    two.known = [each for each in two.known if each.amplitude < 2]
    assert two(at(1.2 + 1.1 * NEAR)).value.tolist() == [pytest.approx(1.023)]
    assert two(at(0.9)) is not None  # where it does not live no step fails for it
    assert two.sweeps == 2


def test_the_lowest_of_many_starts_leads_to_the_lowest_minimum():
    """Two valleys, that of the study's own values the higher one."""

    def size(x):
        return min(2 + (x - 0.5) ** 2, 1 + (x + 3) ** 2)

    valleys = hills(hills=((lambda x: 100 + x, size, lambda x: True),), reach=9.0)
    assert optimum(valleys).after == pytest.approx(2.0, rel=1e-3)
    valleys.known = []
    found = optimum(valleys, 8)
    assert found.after == pytest.approx(1.0, rel=1e-3)
    assert found.before == pytest.approx(2.25)
    assert np.log(found.value[0]) == pytest.approx(-3, abs=0.05)
    assert found.settled


def test_a_search_that_keeps_meeting_higher_peaks_is_not_settled():
    class Endless(Hills):
        def afresh(self, x):
            return Functions(np.array([9.0]), np.array([[0.0]]))

    parameters = (FitParameter("mu", 1.0, 0.1, 10.0),)
    endless = Endless(model(), parameters, (0.0, 100.0))
    found = searched(endless, endless.afresh, parameters, at(0.0), Progress(lambda event: None, 1))
    assert found is not None
    assert not found.settled
    nothing = hills(hills=())
    with pytest.raises(InputError, match="no peak lies in the range"):
        optimum(nothing)




def test_starts_spread_over_the_bounds():
    low, high = np.array([0.0, 10.0]), np.array([1.0, 30.0])
    places = spread(low, high, 30)
    assert ((low < places) & (places < high)).all()
    share = (places - low) / (high - low)
    quarters = 2 * (share[:, 0] > 0.5) + (share[:, 1] > 0.5)
    assert np.bincount(quarters.astype(int), minlength=4).min() >= 6


WIDE = np.full(2, -3.0), np.full(2, 3.0)


def rosen(x):
    value = 1 + (1 - x[0]) ** 2 + 10 * (x[1] - x[0] ** 2) ** 2
    slope = [-2 * (1 - x[0]) - 40 * x[0] * (x[1] - x[0] ** 2), 20 * (x[1] - x[0] ** 2)]
    return Functions(np.array([value]), np.array([slope]))


def cb2(x):
    """Charalambous and Bandler's second: 1.9522245 at (1.139, 0.900)."""
    a, b = x
    value = [a**2 + b**4, (2 - a) ** 2 + (2 - b) ** 2, 2 * np.exp(b - a)]
    e = 2 * np.exp(b - a)
    slope = [[2 * a, 4 * b**3], [2 * a - 4, 2 * b - 4], [-e, e]]
    return Functions(np.array(value), np.array(slope))


def solved(*given):
    found = minimax(*given)
    assert found is not None
    return found


def test_a_smooth_valley():
    found = solved(rosen, np.array([-1.2, 1.0]), WIDE, 1e-9, 200)
    np.testing.assert_allclose(found.x, [1, 1], atol=1e-3)
    assert found.settled


def test_a_corner_of_three_functions():
    tried = []

    def counted(x):
        tried.append(x)
        return cb2(x)

    found = solved(counted, np.array([2.0, 2.0]), WIDE, 1e-9)
    assert found.functions.largest == pytest.approx(1.9522245, rel=1e-6)
    assert len(tried) < 30


def test_bounds_hold_and_lost_places_are_left():
    def slope(x):
        if x[0] < 0.2:
            return None
        return Functions(np.array([1 + x[0]]), np.array([[1.0]]))

    found = solved(slope, np.array([1.0]), (np.array([0.0]), np.array([3.0])), 1e-6)
    assert 0.2 <= found.x[0] < 0.201
    high = solved(
        lambda x: Functions(np.array([9 - x[0]]), np.array([[-1.0]])),
        np.array([1.0]),
        (np.array([0.0]), np.array([2.5])),
        1e-6,
    )
    assert abs(high.x[0] - 2.5) <= np.spacing(2.5)
    assert minimax(lambda x: None, np.array([1.0]), (np.zeros(1), np.ones(1))) is None
