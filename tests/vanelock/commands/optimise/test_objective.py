"""How peaks are followed from one place to the next: by halves of a step, and those met before."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vanelock.commands.fit.parameters import FitParameter, Progress
from vanelock.commands.optimise.bound import least_bound
from vanelock.commands.optimise.front import front, notes, undominated
from vanelock.commands.optimise.objective import NEAR, Functions, Peaks
from vanelock.commands.optimise.search import optimum, searched, spread
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
    return SimpleNamespace(harmonics=harmonics, prepared=lambda values, near, slider: values)


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


def test_a_step_too_long_is_halved_and_the_second_half_begins_where_the_first_leads():
    one = hills()
    one(at(0.0))
    one(at(1.1))  # 0.275 a quarter: the first quarter by itself, the others by its rate
    assert one.sweeps == 1
    assert one.known[0].solution.omega == pytest.approx(111.0)
    assert one.solved == 3  # quarter, quarter, and by their rate the half that is left
    one(at(2.4))  # 0.325 a quarter
    assert one.sweeps == 2


def test_a_peak_that_a_sweep_met_is_looked_for_again_near_there():
    low = (lambda x: 100.0, lambda x: 1 + 0.01 * x, lambda x: True)
    high = (lambda x: 200.0, lambda x: 5.0, lambda x: x > 1)
    two = hills(hills=(low, high), reach=1.0)
    assert two(at(0.0)).value.tolist() == [1.0]
    assert two(at(1.2)).value.tolist() == [pytest.approx(1.012)]  # follows the low one alone
    assert two(at(1.2), afresh=True).value.tolist() == [5.0, pytest.approx(1.012)]
    two.known = [each for each in two.known if each.amplitude < 2]
    assert two(at(1.2 + 0.9 * NEAR)).value.tolist() == [pytest.approx(1.021), 5.0]
    two.known = [each for each in two.known if each.amplitude < 2]
    assert two(at(1.2 + 1.1 * NEAR)).value.tolist() == [pytest.approx(1.023)]
    assert two(at(0.9)) is not None  # where it does not live no step fails for it
    assert two.sweeps == 2


def test_peaks_of_fewer_harmonics_lead_those_of_more():
    one = Hills(model(3), (FitParameter("mu", 1.0, 0.1, 9.0),), (0.0, 100.0))
    one.led_by([peak(100.0, 2.0)], at(0.0))
    (begun,) = one.known
    assert begun.solution.w.shape == (2, 3, 7)
    assert (begun.solution.w[:, :, :3] == 100.0).all()
    assert not begun.solution.w[:, :, 3:].any()
    assert begun.solution.reuse is None
    there = one(at(0.0))
    assert there is not None
    assert there.value.tolist() == [2.0]
    assert not hasattr(one, "sweeps")


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
        def __call__(self, x, afresh=False):
            return Functions(np.array([9.0]), np.zeros((1, 1))) if afresh else super().__call__(x)

    parameters = (FitParameter("mu", 1.0, 0.1, 10.0),)
    endless = Endless(model(), parameters, (0.0, 100.0))
    found = searched(endless, parameters, at(0.0), Progress(lambda event: None, 1))
    assert found is not None
    assert not found.settled
    nothing = hills(hills=())
    with pytest.raises(InputError, match="no peak lies in the range"):
        optimum(nothing)


def test_a_front_leads_from_the_least_peak_to_the_least_wear(monkeypatch):
    """A = 1 + (x - 1)², W = 1 + (x + 1)²: a front is where -1 < x < 1."""

    def worn(peaks, x, known, coefficient):
        return np.array([1 + (x[0] + 1) ** 2 for _ in known])

    monkeypatch.setattr("vanelock.commands.optimise.front.worn", worn)
    one = hills(reach=9.0)
    begun = optimum(one)
    heard: list[Any] = []
    found = front(one, begun, {}, 12, 8, heard.append)
    x = np.array([np.log(point.value[0]) for point in found])
    assert len(found) > 4
    assert x[0] == pytest.approx(1.0, abs=0.05)
    assert (np.diff(x) < 0).all()
    assert x[-1] == pytest.approx(-1.0, abs=0.05)
    np.testing.assert_allclose([point.peak for point in found], 1 + (x - 1) ** 2)
    for i, point in enumerate(found[1:3], 1):  # both are equal there
        ratio = np.sqrt(2.0) ** i
        assert point.peak / found[0].peak == pytest.approx(
            ratio * point.wear / found[0].wear, rel=1e-2
        )
    assert undominated([*found, found[2]._replace(peak=9.0)]) == found
    assert heard[-1].name == "peak or wear"


def test_the_least_bound_is_where_peaks_of_unlike_sliders_cross():
    """A = 1 + (x - s)², s from -1 to 2: J = 1 + max((x + 1)², (x - 2)²), least at 1/2."""
    peaks = hills(hills=((lambda x: 100.0, lambda x: 1 + x**2, lambda x: True),), reach=9.0)
    asked = []

    def assembled_at(slider):
        (s,) = slider
        return hills(
            hills=((lambda x: 100.0, lambda x: 1 + (x - s) ** 2, lambda x: True),), reach=9.0
        )

    def bounds(x):
        asked.append(x[0])
        s = max((-1.0, 2.0), key=lambda s: abs(x[0] - s))
        size = np.array([1.0, 1 + x[0] ** 2, 1 + (x[0] - s) ** 2])
        return SimpleNamespace(
            amplitude=size,
            frequency=np.full(3, 16.0),
            slider=np.array([[0.0], [0.0], [s]]),
            solved=7,
        )

    peaks.assembled_at = assembled_at
    begun = optimum(peaks)
    found = least_bound(peaks, begun, bounds)
    assert found.before == pytest.approx(5.0)
    assert found.after == pytest.approx(1 + 1.5**2, rel=1e-2)
    assert np.log(found.value[0]) == pytest.approx(0.5, abs=0.01)
    assert found.settled
    assert found.of == "upper bound"
    assert len(asked) == 4  # the study's own, the peak's optimum, and one more for each place
    assert any("static friction" in text for text in notes(found))


def test_starts_spread_over_the_bounds():
    low, high = np.array([0.0, 10.0]), np.array([1.0, 30.0])
    places = spread(low, high, 30)
    assert ((low < places) & (places < high)).all()
    share = (places - low) / (high - low)
    quarters = 2 * (share[:, 0] > 0.5) + (share[:, 1] > 0.5)
    assert np.bincount(quarters.astype(int), minlength=4).min() >= 6
