"""Responses cut off after any point go on to the same numbers as those that were not."""

import time
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

from tests.nonlinear.systems import even, random_system, sliding_system
from vanelock.common.cyclic import folded
from vanelock.nonlinear import Options, Shares, adaptive_response, frequency_response
from vanelock.nonlinear.balance.balance import structure


class KilledError(Exception):
    """Stands for a kill."""


class Paper:
    """Points in memory; the run is killed when one beyond the last one allowed is due."""

    def __init__(self, points=None, allowed=np.inf):
        self.before, self.points, self.allowed = dict(points or {}), dict(points or {}), allowed
        self.added: list[str] = []

    def get(self, label):
        """A point that an earlier run has written."""
        return self.before.get(label)

    def add(self, label, numbers, unknowns):
        """Write one."""
        if len(self.added) >= self.allowed:
            raise KilledError
        self.added.append(label)
        self.points[label] = numbers, unknowns.copy()


def close(value, expected):
    """All numbers of a product agree to 1e-9 of the largest beside them, times aside."""
    if is_dataclass(value):
        for each in fields(value):
            if each.name not in ("seconds", "residual"):
                close(getattr(value, each.name), getattr(expected, each.name))
    elif isinstance(value, dict):
        assert value.keys() == expected.keys()
        for key in value:
            close(value[key], expected[key])
    elif isinstance(value, list | tuple):
        for one, other in zip(value, expected, strict=True):
            close(one, other)
    elif isinstance(value, np.ndarray) and value.dtype.kind in "fc":
        largest = np.nanmax(np.abs(expected), initial=0.0)
        np.testing.assert_allclose(value, expected, rtol=0, atol=1e-9 * largest)
    else:
        np.testing.assert_equal(value, expected)


def growing(system):
    """Systems with no nodal diameters but those needed."""

    def systems(harmonics):
        needed = {folded(system.nodal_diameter(h), system.sectors) for h in range(harmonics + 1)}
        kept = {k: each for k, each in system.diameters.items() if k in needed}
        return replace(system, diameters=kept)

    return systems


def _range(store=None):
    return frequency_response(sliding_system(amplitude=2.0), (0.15, 0.21), Options(3), store=store)


def _many_contacts(store=None):
    # More unknowns than are factored: GMRES, whose preconditioner goes from point to point.
    system = random_system(5, size=40, contacts=20, mu=0.1, damping_ratio=0.05, harmonics=3)
    return frequency_response(system, np.linspace(0.02, 0.05, 8), Options(3), store=store)


def _uncoupled(store=None):
    options = Options(3, coupling="uncoupled", direction="down")
    system = sliding_system(amplitude=2.0, preload=0.5)
    return frequency_response(system, np.linspace(0.15, 0.21, 8), options, store=store)


def _adaptive(store=None):
    systems, shares = growing(sliding_system(amplitude=3.0)), Shares(6e-3, 3e-3)
    return adaptive_response(systems, (0.14, 0.22), shares, monitor=(0, 0), store=store)


def _isotropic(store=None):
    systems, options = growing(even(sliding_system(preload=0.5))), Options(friction="isotropic")
    return adaptive_response(systems, (0.15, 0.2), Shares(4e-2, 4e-2), options, store=store)


@pytest.mark.parametrize("compute", [_range, _many_contacts, _uncoupled, _adaptive, _isotropic])
def test_wherever_it_is_cut_off_it_ends_at_the_same_numbers(compute):
    whole = Paper()
    expected = compute()
    close(compute(whole), expected)  # writing down changes nothing
    assert len(whole.added) > 5
    begun = Paper(allowed=2 * len(whole.added) // 3)
    with pytest.raises(KilledError):
        compute(begun)
    again = Paper(begun.points)
    close(compute(again), expected)
    assert {*again.added}.isdisjoint(begun.points)  # nothing that was written is solved again
    assert again.points.keys() == whole.points.keys()


def test_what_was_written_is_checked_by_the_equations():
    system, hertz = sliding_system(), np.linspace(0.15, 0.21, 10)
    paper = Paper()
    expected = frequency_response(system, hertz, Options(3), store=paper)
    points = {}
    for i, (label, (numbers, w)) in enumerate(paper.points.items()):
        points[label] = numbers, w * (1 + 1e-3 * i) if i % 2 else np.full_like(w, np.nan)
    again = Paper(points)
    close(frequency_response(system, hertz, Options(3), store=again), expected)
    assert len(again.added) == 5  # those that no iteration leads on from


@pytest.mark.parametrize("compute", [_range, _adaptive])
def test_no_number_depends_on_the_time_that_something_took(compute, monkeypatch):
    expected = compute()
    rng = np.random.default_rng(0)
    for clock in ("process_time", "perf_counter", "monotonic", "time"):
        monkeypatch.setattr(time, clock, lambda: float(rng.exponential(1e4)))
    close(compute(), expected)


def test_points_of_other_frequencies_are_not_taken():
    one, hertz, paper = sliding_system(), np.linspace(0.15, 0.21, 10), Paper()
    frequency_response(one, hertz, Options(3), store=paper)
    again, elsewhere = Paper(paper.points), np.append(hertz[:4], hertz[4:] + 1e-3)
    found = frequency_response(one, elsewhere, Options(3), store=again)
    close(found, frequency_response(one, elsewhere, Options(3)))
    assert len(again.added) == len(paper.added) - 4


def test_modes_of_a_diameter_do_not_depend_on_what_was_asked_for_before():
    # Engine order 2 of 5: harmonic 2 has diameter 4, which mirrors 1, that of harmonic 3.
    whole = random_system(4, engine_order=2, harmonics=5)
    k = {folded(each, 5): whole.at(folded(each, 5)) for each in whole.diameters}
    system = replace(whole, diameters=k)
    few = structure(system, 2)
    many = structure(system, 3, stuck=structure(system, 1).modes)
    assert few.modes[4].shapes.tobytes() == many.modes[4].shapes.tobytes()
