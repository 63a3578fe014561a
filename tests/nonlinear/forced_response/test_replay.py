"""Computations cut off after any point go on to the same bits as those that were not."""

import time
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.common.cyclic import folded
from vanelock.nonlinear import (
    Options,
    Shares,
    System,
    adaptive_response,
    frequency_response,
    peak_response,
)
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.forced_response.replay import SHARED, Journal, Replay
from vanelock.rom.system.system import Contacts

Make = Callable[..., System]
Compute = Callable[[Journal | None], Any]


class KilledError(Exception):
    """Stands for a kill."""


class Paper:
    """A journal in memory; the run is killed when a record beyond the last one allowed is due."""

    def __init__(self, records: list[bytes] | None = None, allowed: float = np.inf) -> None:
        self.records, self.read, self.allowed = records or [], 0, allowed
        self.asked = 0

    def next(self) -> bytes | None:
        """The next record."""
        if self.read == len(self.records):
            return None
        self.read += 1
        return self.records[self.read - 1]

    def drop(self) -> None:
        """Forget the last one and those behind it."""
        self.read -= 1
        del self.records[self.read :]

    def add(self, record: bytes) -> None:
        """Write one."""
        if len(self.records) >= self.allowed:
            raise KilledError
        self.asked += 1
        self.records.append(record)
        self.read = len(self.records)


def bits(value: Any) -> Any:
    """All numbers of a product, times aside, as bytes."""
    if is_dataclass(value):
        names = [each.name for each in fields(value) if each.name != "seconds"]
        return {name: bits(getattr(value, name)) for name in names}
    if isinstance(value, dict):
        return {key: bits(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [bits(each) for each in value]
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    return value


def growing(system: System) -> Callable[[int], System]:
    """Systems with no nodal diameters but those needed."""

    def systems(harmonics: int) -> System:
        needed = {folded(system.nodal_diameter(h), system.sectors) for h in range(harmonics + 1)}
        kept = {k: each for k, each in system.diameters.items() if k in needed}
        return replace(system, diameters=kept)

    return systems


def evened(system: System) -> System:
    """Contacts as stiff in both tangential directions."""
    c = system.contacts
    even = Contacts(kn=c.kn, kt=np.repeat(c.kt[:, :1], 2, axis=1), mu=c.mu, v0=c.v0)
    return replace(system, contacts=even)


@dataclass(frozen=True)
class Case:
    name: str
    make: Callable[[Make, Make], Compute]


def _range(random_system: Make, sliding_system: Make) -> Compute:
    system = sliding_system(amplitude=2.0)
    return lambda journal: frequency_response(system, (0.15, 0.21), Options(3), journal=journal)


def _many_contacts(random_system: Make, sliding_system: Make) -> Compute:
    # More unknowns than are factored: GMRES, whose preconditioner goes from point to point.
    system = random_system(5, size=40, contacts=20, mu=0.1, damping_ratio=0.05, harmonics=3)
    hertz = np.linspace(0.02, 0.05, 8)
    return lambda journal: frequency_response(system, hertz, Options(3), journal=journal)


def _uncoupled(random_system: Make, sliding_system: Make) -> Compute:
    system = sliding_system(amplitude=2.0, preload=0.5)
    hertz = np.linspace(0.15, 0.21, 8)
    return lambda journal: frequency_response(
        system, hertz, Options(3, coupling="uncoupled", direction="down"), journal=journal
    )


def _adaptive(random_system: Make, sliding_system: Make) -> Compute:
    system = sliding_system(amplitude=3.0)
    shares = Shares(6e-3, 3e-3)
    return lambda journal: adaptive_response(
        growing(system), (0.14, 0.22), shares, monitor=(0, 0), journal=journal
    )


def _isotropic(random_system: Make, sliding_system: Make) -> Compute:
    system = evened(sliding_system(preload=0.5))
    shares = Shares(4e-2, 4e-2)
    return lambda journal: adaptive_response(
        growing(system), (0.15, 0.2), shares, Options(friction="isotropic"), journal=journal
    )


def _ridge(random_system: Make, sliding_system: Make) -> Compute:
    system, values = sliding_system(), np.geomspace(0.1, 2.0, 3)
    options = Options(1, "uncoupled", "isotropic")
    return lambda journal: peak_response(
        system, "mu", values, (0.14, 0.22), options, journal=journal
    )


CASES = [
    Case("range", _range),
    Case("many contacts", _many_contacts),
    Case("uncoupled", _uncoupled),
    Case("to an accuracy", _adaptive),
    Case("isotropic, to an accuracy", _isotropic),
    Case("ridge", _ridge),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_wherever_it_is_cut_off_it_ends_at_the_same_bits(
    case: Case, random_system: Make, sliding_system: Make
) -> None:
    compute = case.make(random_system, sliding_system)
    whole = Paper()
    expected = bits(compute(whole))
    assert bits(compute(None)) == expected  # writing down changes no bit
    count = len(whole.records)
    read = Paper(list(whole.records), allowed=count)
    assert bits(compute(read)) == expected
    assert count > 5
    for cut in (count // 3, count - 1):
        begun = Paper(allowed=cut)
        with pytest.raises(KilledError):
            compute(begun)
        again = Paper(begun.records)
        assert bits(compute(again)) == expected
        assert again.asked == count - cut  # nothing that was written is solved again


@pytest.mark.parametrize("case", [CASES[0], CASES[3]], ids=lambda case: case.name)
def test_no_number_depends_on_the_time_that_something_took(
    case: Case, random_system: Make, sliding_system: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    compute = case.make(random_system, sliding_system)
    expected = bits(compute(None))
    rng = np.random.default_rng(0)
    for clock in ("process_time", "perf_counter", "monotonic", "time"):
        monkeypatch.setattr(time, clock, lambda: float(rng.exponential(1e4)))
    assert bits(compute(None)) == expected


def test_points_of_another_computation_are_not_taken(sliding_system: Make) -> None:
    one = sliding_system()
    hertz = np.linspace(0.15, 0.21, 10)
    paper = Paper()
    frequency_response(one, hertz, Options(3), journal=paper)
    first = len(paper.records)
    again = Paper(list(paper.records))
    elsewhere = np.append(hertz[:4], hertz[4:] + 1e-3)
    found = frequency_response(one, elsewhere, Options(3), journal=again)
    assert bits(found) == bits(frequency_response(one, elsewhere, Options(3)))
    assert again.asked == first - 4


def test_arrays_come_back_in_their_order_and_objects_as_one() -> None:
    @dataclass(frozen=True)
    class Shared:
        matrix: NDArray[np.float64]

    @dataclass(frozen=True)
    class Answer:
        shared: Shared
        numbers: dict[Any, Any]

    paper = Paper()
    matrix = np.asfortranarray(np.random.default_rng(1).normal(size=(40, 30)))
    sparse = np.zeros((400, 9))
    sparse[[3, 399]] = [[np.nan], [1e300]]
    held = Shared(matrix)
    numbers = {
        (3, None): np.float64(0.1),
        "inf": [np.inf, -0.0, True],
        7: (
            sparse,
            np.arange(6, dtype=np.int32),
            np.ones((2, 0)),
            1 + np.zeros((3, 2, 2), complex),
        ),
    }
    ask = Replay(paper, (Shared,), (Answer,))
    given = ask("what", (1.0, "x"), lambda: Answer(held, numbers))
    given = ask("what", (1.0, "x"), lambda: Answer(given.shared, {}))
    replay = Replay(Paper(paper.records), (Shared,), (Answer,))

    def never() -> Answer:
        raise AssertionError("computed again")

    first, second = (replay("what", (1.0, "x"), never) for _ in range(2))
    assert first.shared is second.shared
    assert first.shared.matrix.flags.f_contiguous
    assert bits(first) == bits(Answer(held, numbers))
    assert type(first.numbers[3, None]) is np.float64
    assert bits(given) == bits(second)
    assert len(paper.records[1]) < 200  # written once


def test_an_answer_may_hold_more_than_is_kept_and_name_any_of_it_again() -> None:
    @dataclass(frozen=True)
    class Shared:
        matrix: NDArray[np.float64]

    def never() -> list[Shared]:
        raise AssertionError("computed again")

    paper = Paper()
    ask = Replay(paper, (Shared,), ())
    first = ask("first", (), lambda: [Shared(np.full(3, 0.5))])
    many = [Shared(np.full(3, float(i))) for i in range(2 * SHARED)]
    given = ask("many", (), lambda: [*many, *first, many[0]])
    replay = Replay(Paper(paper.records), (Shared,), ())
    again, more = replay("first", (), never), replay("many", (), never)
    assert bits(more) == bits([*many, *first, many[0]]) == bits(given)
    assert more[-1] is more[0]
    assert more[-2] is again[0]


def test_modes_of_a_diameter_do_not_depend_on_what_was_asked_for_before(
    random_system: Make,
) -> None:
    # Engine order 2 of 5: harmonic 2 has diameter 4, which mirrors 1, that of harmonic 3.
    whole = random_system(4, engine_order=2, harmonics=5)
    k = {folded(each, 5): whole.at(folded(each, 5)) for each in whole.diameters}
    system = replace(whole, diameters=k)
    few = structure(system, 2)
    many = structure(system, 3, known=structure(system, 1).modes)
    assert few.modes[4].shapes.tobytes() == many.modes[4].shapes.tobytes()
