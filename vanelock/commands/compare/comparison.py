"""Two runs side by side: what they were given, what they found, and what they cost."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from vanelock.common.tables import Cell, Column, Table, counted
from vanelock.files import Study
from vanelock.input.settings import as_text, described, flattened, same
from vanelock.results.reading.contents import CaseFound, Loaded

QUANTITIES = (
    Column("peak", "µm", ".4g", "peak_amplitude"),
    Column("peak frequency", "Hz", ".6g", "peak_frequency"),
    Column("lower bound of the peak", "µm", ".4g", "lowest_peak_amplitude"),
    Column("upper bound of the peak", "µm", ".4g", "highest_peak_amplitude"),
    Column("growth per cycle", "", ".4g", "growth_in_a_period"),
    Column("damping ratio by energy", "%", ".3g", "damping_ratio"),
    Column("damping ratio by bandwidth", "%", ".3g", "bandwidth_ratio"),
    Column("relative to the free linear peak", key="of_free"),
    Column("relative to the stuck linear peak", key="of_stuck"),
    Column("interlock's share of friction", "%", ".4g", "friction_share"),
    Column("alternating stress", "MPa", ".4g", "alternating_stress"),
    Column("mean stress", "MPa", ".4g", "mean_stress"),
    Column("HCF safety factor", key="goodman_reserve"),
    Column("largest slip per cycle", "µm", ".4g", "largest_slip"),
    Column("harmonics", form=".0f"),
    Column("points", form=".0f"),
    Column("converged", form=".0f"),
    Column("time", "s", ".3g", "seconds"),
)
"""Of a case, by their keys in the results."""
COUNTS = ("harmonics", "points", "converged")
"""Of these, settings and counts, no relative difference is reported."""


@dataclass(frozen=True)
class Pair:
    """A case of each run that belong together, and by what."""

    one: CaseFound
    other: CaseFound
    by: str

    @property
    def name(self) -> str:
        """What tables call it."""
        if self.one.name == self.other.name:
            return self.one.name
        return f"{self.one.name} | {self.other.name}"


@dataclass(frozen=True)
class Line:
    """A number of both runs: what it is of, what it is, and both values in the unit shown."""

    of: str
    column: Column
    one: float | None
    other: float | None

    @property
    def what(self) -> str:
        """What it is."""
        return self.column.head

    def text(self, value: float | None) -> str | None:
        """A value with its unit."""
        return None if value is None else f"{self.column.text(value)} {self.column.unit}".rstrip()

    @property
    def change(self) -> float | None:
        """Relative difference, the other less the first over the first; None where undefined.

        None of counts, too.
        """
        if self.one is None or self.other is None or self.one == 0 or self.what in COUNTS:
            return None
        return self.other / self.one - 1


@dataclass(frozen=True)
class Comparison:
    """Two runs, their cases in pairs, and what could not be compared, a line each."""

    one: Loaded
    other: Loaded
    pairs: tuple[Pair, ...]
    notes: tuple[str, ...]

    @property
    def inputs(self) -> list[tuple[str, str, str]]:
        """Keys that differ, with both values in words."""
        return list(_differing(self.one, self.other))

    @property
    def results(self) -> list[Line]:
        """Numbers of all pairs of cases."""
        return [line for pair in self.pairs for line in _lines(pair)]

    @property
    def sizes(self) -> list[Line]:
        """Model sizes and times."""
        found = []
        for what in dict.fromkeys([*self.one.sizes, *self.other.sizes]):
            both = (self.one.sizes.get(what), self.other.sizes.get(what))
            found.append(Line("model", Column(what, form=",.0f"), *both))
        for what in dict.fromkeys([*self.one.seconds, *self.other.seconds]):
            both_times = (self.one.seconds.get(what), self.other.seconds.get(what))
            found.append(Line("time", Column(what, "s", ".3g"), *both_times))
        return found


def compared(one: Loaded, other: Loaded) -> Comparison:
    """Cases in pairs, and what is missing."""
    pairs, notes = matched(one, other)
    missing = [
        f"{run.folder}: the run is not complete; compared: {counted(len(run.cases), 'case')}"
        for run in (one, other)
        if not run.complete
    ]
    if one.monitor and other.monitor and one.monitor != other.monitor:
        missing.append(
            f"amplitudes are of different displacements: {one.monitor} in {one.label}, "
            f"{other.monitor} in {other.label}"
        )
    return Comparison(one, other, tuple(pairs), (*missing, *notes))


def matched(one: Loaded, other: Loaded) -> tuple[list[Pair], list[str]]:
    """Cases that belong together: by name, else by the values they share, else by their order."""
    pairs = [Pair(c, other.cases[n], "name") for n, c in one.cases.items() if n in other.cases]
    taken = {pair.one.name for pair in pairs}
    left = [case for name, case in one.cases.items() if name not in taken]
    right = [case for name, case in other.cases.items() if name not in taken]
    for case in list(left):
        alike = [each for each in right if _agree(case, each)]
        if len(alike) == 1 and [c for c in left if _agree(c, alike[0])] == [case]:
            pairs.append(Pair(case, alike[0], "values"))
            left.remove(case)
            right.remove(alike[0])
    pairs += [Pair(a, b, "order") for a, b in zip(left, right, strict=False)]
    notes = [
        f"{p.one.name} in {one.label} is compared with {p.other.name} in {other.label}, by {p.by}"
        for p in pairs
        if p.by != "name"
    ]
    alone = [(one, c) for c in left[len(right) :]] + [(other, c) for c in right[len(left) :]]
    notes += [f"{case.name} is in {run.label} alone" for run, case in alone]
    return pairs, notes


def _agree(one: CaseFound, other: CaseFound) -> bool:
    """Whether cases share swept keys and have the same values of all that they share."""
    shared = one.values.keys() & other.values.keys()
    return bool(shared) and all(same(one.values[key], other.values[key]) for key in shared)


def tables(found: Comparison) -> list[Table]:
    """Differing inputs, results, sizes and times, and programs."""
    both = Column(found.one.label, key="one"), Column(found.other.label, key="other")
    inputs = Table(
        "Inputs that differ, defaults included" if found.inputs else "Inputs: all the same",
        (Column("key"), Column("what it is", key="meaning"), *both),
        [(key, described(key, Study)[0], *values) for key, *values in found.inputs],
        key="inputs",
    )
    programs = Table("Programs", (Column("program"), *both), list(_programs(found)), key="versions")
    columns = (Column("of"), Column("what"), *both, Column("difference", key="change"))
    kinds = (
        ("results", "Results", found.results),
        ("sizes", "Models and times", found.sizes),
    )
    numbers = [
        Table(title, columns, list(map(_numbers, lines)), key=key) for key, title, lines in kinds
    ]
    return [inputs, *numbers, programs]


def _programs(found: Comparison) -> Iterator[tuple[Cell, ...]]:
    runs = found.one, found.other
    yield "folder", *(str(run.folder) for run in runs)
    yield "date", *(run.date for run in runs)
    yield "complete", *("yes" if run.complete else "NO" for run in runs)
    one, other = (run.versions for run in runs)
    for name in dict.fromkeys([*one, *other]):
        if one.get(name) != other.get(name) or name == "vanelock":
            yield name, one.get(name), other.get(name)


def _numbers(line: Line) -> tuple[Cell, ...]:
    """Both values with their unit, and the relative difference in per cent."""
    change = None if line.change is None else f"{100 * line.change:+.3g} %"
    difference = "same" if line.one == line.other else change
    return line.of, line.what, line.text(line.one), line.text(line.other), difference


def _lines(pair: Pair) -> Iterator[Line]:
    for column in QUANTITIES:
        found = [case.numbers.get(column.name, np.nan) for case in (pair.one, pair.other)]
        if np.isfinite(found).any():
            both: list[Any] = [column.shown(each) if np.isfinite(each) else None for each in found]
            yield Line(pair.name, column, *both)


def _differing(one: Loaded, other: Loaded) -> Iterator[tuple[str, str, str]]:
    first, second = flattened(one.settings), flattened(other.settings)
    for key in dict.fromkeys([*first, *second]):
        if same(first.get(key), second.get(key)):  # a key of a later version that is not set, too
            continue
        both = [as_text(key, known[key]) if key in known else "-" for known in (first, second)]
        yield key, both[0], both[1]
