"""What an optimum comes to: its table, the notes below, and the same for machines."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vanelock.commands.fit.tables import UNITS, shown
from vanelock.commands.optimise.search import Optimum, on_bounds
from vanelock.common.tables import Cell, Column, Table, counted
from vanelock.input.cases.sweep import Case
from vanelock.quantities.contacts.wear import HOUR

NAME = "optimise"


def optimum_table(found: Optimum, name: str) -> Table:
    """One line for each parameter, what became of the peak below."""
    columns = (
        Column("parameter"),
        Column("study", form=".5g", key="start"),
        Column("optimum", form=".5g", key="value"),
        Column("unit"),
        Column("bounds"),
    )
    rows: list[tuple[Cell, ...]] = []
    for parameter, value in zip(found.parameters, found.value, strict=True):
        unit = UNITS.get(parameter.key.rpartition(".")[2], "-")
        bounds = f"{parameter.low:.3g} to {parameter.high:.3g}"
        rows.append((shown(parameter.key), parameter.start, float(value), unit, bounds))
    return Table(f"Smallest {found.of}: {name}", columns, rows, notes(found), NAME)


def notes(found: Optimum) -> list[str]:
    """What became of the peak, and what should keep one from believing it."""
    places = " and ".join(f"{each:.6g} Hz" for each in found.frequencies)
    said = [
        f"{found.of}: {1e6 * found.before:.4g} um with the study's values, "
        f"{1e6 * found.after:.4g} um at {places}; {counted(found.trials, 'place')}, "
        f"{found.solved:,} frequencies solved"
        + (f", {found.screened:,} with one harmonic before" if found.screened else "")
    ]
    said.append(
        'with joints as assembled; how far static friction moves it: of = "upper bound"'
        if found.of == "largest peak"
        else "of the peaks that static friction, which the model leaves open, allows"
    )
    if len(found.frequencies) > 1:
        said.append("several peaks are equally high there: to lower one raises another")
    for parameter, on in zip(found.parameters, found.held, strict=True):
        if on:
            said.append(f"{shown(parameter.key)} LIES ON A BOUND: beyond it the peak may be lower")
    if not found.settled:
        said.append("NOT SETTLED: the search ended before steps promised nothing more")
    return said


def cases_table(found: Sequence[tuple[Case, Optimum]], name: str) -> Table:
    """A line for each case of a sweep."""
    first = found[0][1]
    columns = (
        Column("case"),
        *_values(first),
        Column("before", "µm", ".4g"),
        Column(f"smallest {first.of}", "µm", ".4g", "after"),
    )
    rows = [(case.name, *each.value.tolist(), each.before, each.after) for case, each in found]
    said = []
    for case, each in found:
        held = zip(each.parameters, each.held, strict=True)
        if names := [shown(parameter.key) for parameter, on in held if on]:
            said.append(f"{case.name}: {' and '.join(names)} ON A BOUND")
        if not each.settled:
            said.append(f"{case.name}: NOT SETTLED")
    return Table(f"Optima of all cases: {name}", columns, rows, said, "optima")


def _values(found: Optimum) -> tuple[Column, ...]:
    """A column for each parameter."""
    return tuple(
        Column(shown(each.key), UNITS.get(each.key.rpartition(".")[2], "-"), ".4g")
        for each in found.parameters
    )


def front_table(found: Optimum, name: str) -> Table:
    """A line for each point of the front."""
    columns = (
        Column("largest peak", "µm", ".4g"),
        Column("worn volume", "mm³/h", ".4g"),
        *_values(found),
    )
    rows = [(p.peak, HOUR * p.wear, *p.value.tolist()) for p in found.front]
    return Table(f"Largest peak against wear: {name}", columns, rows, _front_notes(found), "front")


def _front_notes(found: Optimum) -> list[str]:
    """What a front is, and what should keep one from believing its points."""
    said = [
        "worn volume: while the vane vibrates at the peak; no values were found with less of both"
    ]
    for i, point in enumerate(found.front):
        x = np.array([each.inner(v) for each, v in zip(found.parameters, point.value, strict=True)])
        held = zip(found.parameters, on_bounds(found.parameters, x), strict=True)
        names = [shown(each.key) for each, on in held if on]
        if names:
            said.append(f"line {i + 1}: {' and '.join(names)} ON A BOUND")
        if not point.settled:
            said.append(f"line {i + 1}: NOT SETTLED")
    if len(found.front) == 1:
        said.append("nothing near wears less: there is no front")
    return said


def json_of(found: Optimum) -> dict[str, Any]:
    """An optimum for machines."""
    return {
        "parameters": [
            {
                "key": each.key,
                "start": each.start,
                "bounds": [each.low, each.high],
                "value": float(value),
                "on_bound": on,
            }
            for each, value, on in zip(found.parameters, found.value, found.held, strict=True)
        ],
        "of": found.of,
        "largest_peak_before": found.before,
        "largest_peak": found.after,
        "frequencies": found.frequencies.tolist(),
        "amplitudes": found.amplitudes.tolist(),
        "places": found.trials,
        "frequencies_solved": found.solved,
        "frequencies_solved_with_one_harmonic": found.screened,
        "settled": found.settled,
        "front": [
            {
                "values": point.value.tolist(),
                "largest_peak": point.peak,
                "worn_volume_per_second": point.wear,
                "settled": point.settled,
            }
            for point in found.front
        ],
    }
