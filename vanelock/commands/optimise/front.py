"""The front of largest peak against wear: values that lower neither without raising the other.

Worn at a peak is, by Archard's law,

    W = ω/2π Σ_c k_c E_c / μ_c,

E the friction work of a contact in a period, k its joint's wear coefficient. For ratios r = 1,
√2, 2, ... the larger of A/A₁ and r W/W₁ is made the smallest (Chebyshev's scalarisation;
K. Miettinen, Nonlinear multiobjective optimization, 1999, section 3.4); r = 1 is where the largest
peak A₁ is smallest, and W₁ the wear there. Each search begins at the lower one of the values before
and of the best among places all over the bounds, tried with one harmonic.

What an optimum comes to: its table, the notes below, and the same for machines.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from vanelock.commands.fit.parameters import Progress, bounds_of, on_bounds, values_of, x_of
from vanelock.commands.optimise.objective import Functions, Peaks
from vanelock.commands.optimise.search import (
    ON_BOUND,
    TRIALS,
    FrontPoint,
    Optimum,
    searched,
    spread,
    tried,
)
from vanelock.common.arrays import Floats
from vanelock.common.tables import Cell, Column, Table, counted
from vanelock.input.cases.sweep import Case
from vanelock.nonlinear.fourier import TURN
from vanelock.nonlinear.peaks.peak import CurvePoint
from vanelock.pipeline.progress import Listener, silent
from vanelock.quantities.contacts import HOUR
from vanelock.rom.system.system import Contacts

RATIO = np.sqrt(2.0)
"""Of one point's r to that of the one before."""
CLOSER = 1e-2
"""Relative difference of wear below which two points are one."""
STEP = 1e-3
"""Of x, over which wear is differenced."""


def worn(
    peaks: Peaks, x: Floats, curve_points: Sequence[CurvePoint], coefficient: Mapping[str, float]
) -> Floats:
    """(j,) volume worn in a second at each of the known peaks at x, m³/s."""
    contacts = peaks.model.system(peaks.values(x)).contacts
    lost = _volume_by_work(contacts, coefficient)
    work = np.array([each.solution.deviation.dissipation for each in curve_points])
    rate = np.array([each.solution.omega for each in curve_points]) / TURN
    return np.asarray(rate * (np.maximum(work, 0.0) @ lost))


def _volume_by_work(contacts: Contacts, coefficient: Mapping[str, float]) -> Floats:
    """(c,) volume that a contact loses for the friction work done on it, k/μ, m³/J."""
    k = np.array([coefficient.get(joint, 0.0) for joint in contacts.joints])
    found = np.zeros(contacts.count)
    np.divide(k, contacts.mu, out=found, where=contacts.springs & (contacts.mu > 0))
    return found


def front(
    peaks: Peaks,
    begun: Optimum,
    coefficient: Mapping[str, float],
    count: int,
    starts: int = 0,
    listener: Listener = silent,
) -> list[FrontPoint]:
    """The front from where the largest peak is smallest towards less wear.

    Wear coefficients, m²/N, are by joint.
    """
    x = x_of(peaks.parameters, begun.value)
    first = FrontPoint(begun.value, *_largest(peaks, x, coefficient), begun.settled)
    found = [first]
    if not first.wear > 0:
        return found
    trials, progress = [], Progress(listener, starts)
    single = peaks.with_one_harmonic()
    for place in spread(*bounds_of(peaks.parameters), starts):
        single.followed = []
        if tried(progress, single(place)) < np.inf:
            trials.append((place, *_largest(single, place, coefficient)))
    progress = Progress(listener, (count - 1) * TRIALS, "peak or wear", "of the first point", 1.0)
    for i in range(1, count):
        ratio, progress.least = RATIO**i, np.inf
        both = partial(_peaks_and_wear, peaks, coefficient, first, ratio)
        last = peaks.followed
        here = tried(progress, both(x))
        sizes = [max(peak / first.peak, ratio * wear / first.wear) for _, peak, wear in trials]
        if min(sizes, default=np.inf) < here:
            other = trials[int(np.argmin(sizes))][0]
            peaks.followed = []
            there = tried(progress, both(other))
            if here < there:
                peaks.followed, peaks.followed_x = last, x
            else:
                x = other
        place = searched(both, peaks.parameters, x, progress)
        if place is None:
            break
        x = place.x
        value = values_of(peaks.parameters, x)
        found.append(FrontPoint(value, *_largest(peaks, x, coefficient), place.settled))
    return undominated(found)


def _largest(peaks: Peaks, x: Floats, coefficient: Mapping[str, float]) -> tuple[float, float]:
    """The largest of the known peaks at x, m, and the most worn at one of them, m³/s."""
    wear = worn(peaks, x, peaks.followed, coefficient)
    return max(each.amplitude for each in peaks.followed), float(wear.max())


def _peaks_and_wear(
    peaks: Peaks,
    coefficient: Mapping[str, float],
    start_point: FrontPoint,
    ratio: float,
    x: Floats,
    afresh: bool = False,
) -> Functions | None:
    """Peaks and `ratio` times the wear at them, as multiples of the first point's."""
    size = peaks(x, afresh)
    if size is None:
        return None
    wear = worn(peaks, x, peaks.followed, coefficient)
    gradient = np.zeros((len(wear), len(x)))
    for i in range(len(x)):
        there = x.copy()
        there[i] += STEP
        moved = peaks.moved(there)
        if not moved:
            return None
        gradient[:, i] = (worn(peaks, there, moved, coefficient) - wear) / STEP
    share = ratio / start_point.wear
    return Functions(
        np.append(size.value / start_point.peak, share * wear),
        np.vstack([size.gradient / start_point.peak, share * gradient]),
    )


def undominated(points: Sequence[FrontPoint]) -> list[FrontPoint]:
    """Those that wear less than all that have a smaller peak, by falling wear."""
    kept: list[FrontPoint] = []
    for each in sorted(points, key=lambda point: (point.peak, point.wear)):
        if not kept or each.wear < (1 - CLOSER) * kept[-1].wear:
            kept.append(each)
    return kept


NAME = "optimise"


def optimum_table(best: Optimum, name: str) -> Table:
    """One line for each parameter, what became of the peak below."""
    columns = (
        Column("parameter"),
        Column("study", form=".5g", key="start"),
        Column("optimum", form=".5g", key="value"),
        Column("unit"),
        Column("bounds"),
    )
    rows: list[tuple[Cell, ...]] = []
    for parameter, value in zip(best.parameters, best.value, strict=True):
        values = parameter.start, float(value)
        rows.append((parameter.name, *values, parameter.unit, parameter.span))
    return Table(f"Smallest {best.of}: {name}", columns, rows, notes(best), NAME)


def notes(optimum: Optimum) -> list[str]:
    """What became of the peak, and what should keep one from believing it."""
    places = " and ".join(f"{each:.6g} Hz" for each in optimum.frequencies)
    said = [
        f"{optimum.of}: {1e6 * optimum.before:.4g} um with the study's values, "
        f"{1e6 * optimum.after:.4g} um at {places}; {counted(optimum.trials, 'place')}, "
        f"{optimum.solved:,} frequencies solved"
        + (f", {optimum.screened:,} with one harmonic before" if optimum.screened else "")
    ]
    said.append(
        'with joints as assembled; how far static friction moves it: of = "upper bound"'
        if optimum.of == "largest peak"
        else "of the peaks that static friction, which the model leaves open, allows"
    )
    if len(optimum.frequencies) > 1:
        said.append("several peaks are equally high there: to lower one raises another")
    for name in _held(optimum, optimum.value):
        said.append(f"{name} LIES ON A BOUND: beyond it the peak may be lower")
    if not optimum.settled:
        said.append("NOT SETTLED: the search ended before steps promised nothing more")
    return said


def cases_table(by_case: Sequence[tuple[Case, Optimum]], name: str) -> Table:
    """A line for each case of a sweep."""
    first = by_case[0][1]
    columns = (
        Column("case"),
        *_values(first),
        Column("before", "µm", ".4g"),
        Column(f"smallest {first.of}", "µm", ".4g", "after"),
    )
    rows = [(case.name, *each.value.tolist(), each.before, each.after) for case, each in by_case]
    said = []
    for case, each in by_case:
        if names := _held(each, each.value):
            said.append(f"{case.name}: {' and '.join(names)} ON A BOUND")
        if not each.settled:
            said.append(f"{case.name}: NOT SETTLED")
    return Table(f"Optima of all cases: {name}", columns, rows, said, "optima")


def _values(optimum: Optimum) -> tuple[Column, ...]:
    """A column for each parameter."""
    return tuple(Column(each.name, each.unit, ".4g") for each in optimum.parameters)


def _held(optimum: Optimum, values: Floats) -> list[str]:
    """Names of the parameters that lie on a bound with some values."""
    held = on_bounds(optimum.parameters, values, ON_BOUND)
    return [each.name for each, on in zip(optimum.parameters, held, strict=True) if on]


def front_table(optimum: Optimum, name: str) -> Table:
    """A line for each point of the front."""
    columns = (
        Column("largest peak", "µm", ".4g"),
        Column("worn volume", "mm³/h", ".4g"),
        *_values(optimum),
    )
    rows = [(p.peak, HOUR * p.wear, *p.value.tolist()) for p in optimum.front]
    return Table(
        f"Largest peak against wear: {name}", columns, rows, _front_notes(optimum), "front"
    )


def _front_notes(optimum: Optimum) -> list[str]:
    """What a front is, and what should keep one from believing its points."""
    said = [
        "worn volume: while the vane vibrates at the peak; no values were found with less of both"
    ]
    for i, point in enumerate(optimum.front):
        if names := _held(optimum, point.value):
            said.append(f"line {i + 1}: {' and '.join(names)} ON A BOUND")
        if not point.settled:
            said.append(f"line {i + 1}: NOT SETTLED")
    if len(optimum.front) == 1:
        said.append("nothing near wears less: there is no front")
    return said


def json_of(best: Optimum) -> dict[str, Any]:
    """An optimum for machines."""
    return {
        "parameters": [
            {**each.record(value), "on_bound": on}
            for each, value, on in zip(best.parameters, best.value, best.held, strict=True)
        ],
        "of": best.of,
        "largest_peak_before": best.before,
        "largest_peak": best.after,
        "frequencies": best.frequencies.tolist(),
        "amplitudes": best.amplitudes.tolist(),
        "places": best.trials,
        "frequencies_solved": best.solved,
        "frequencies_solved_with_one_harmonic": best.screened,
        "settled": best.settled,
        "front": [
            {
                "values": point.value.tolist(),
                "largest_peak": point.peak,
                "worn_volume_per_second": point.wear,
                "settled": point.settled,
            }
            for point in best.front
        ],
    }
