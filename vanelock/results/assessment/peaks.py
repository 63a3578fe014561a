"""Tables of what responses are worth: bounds over static friction, stability, unlike segments."""

from collections.abc import Mapping
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from vanelock.common.tables import Cell, Column, Flag, Table, heads
from vanelock.nonlinear import STABLE, whitehead
from vanelock.stages.assessment.assessed import Assessment
from vanelock.stages.assessment.stability import WORDS

MOST = 24
"""Cases that a table has; of more it says so."""
ENDS = ("lower bound", "as assembled", "upper bound")
"""What the three places of `PeakBounds` are called."""
PERCENTILES = (5, 50, 95)
"""Of the rings drawn."""
ROUND_OFF = 1e-9
RANK = np.array([0, 2, 1])
"""How bad the verdicts 0 stable, 1 unstable, 2 undecided are."""
FOUND = (
    "found, not proved: the search starts at extreme loads and at random places and follows the "
    "peak's gradient; stationary: the gradient leads no further"
)


def bounds_table(assessments: Mapping[str, Assessment]) -> Table | None:
    """Of each case the least peak, that as assembled and the largest, with loads by joint."""
    found = {name: each.bounds for name, each in assessments.items() if each.bounds is not None}
    known = {name: each.found for name, each in found.items() if each.found is not None}
    if not known:
        return None
    joints = list(dict.fromkeys(joint for each in known.values() for joint in each.joints))
    columns = (
        *heads("case", "static friction"),
        Column("peak", "µm", key="peak_um"),
        Column("at", "Hz", ".6g", "frequency_hz"),
        *(Column(f"{joint} at rest", "N", ".4g", f"{joint}_rest_n") for joint in joints),
        *(Column(f"{joint} at the peak", "N", ".4g", f"{joint}_peak_n") for joint in joints),
        Column("found by", key="found_by"),
        Column("stationary"),
        Column("check", form=".0e", key="residual"),
    )
    rows: list[tuple[Cell, ...]] = []
    for name, each in islice(known.items(), MOST):
        for i, end in enumerate(ENDS):
            loads = [
                _load(dict(zip(each.joints, load.T, strict=True)).get(joint), i)
                for load in (each.rest_load, each.mean_load)
                for joint in joints
            ]
            stationary = "yes" if each.stationary[i] else "no"
            numbers = each.amplitude[i], each.frequency[i], *loads
            search = each.found_by[i], stationary, found[name].residual[i]
            rows.append((name, end, *numbers, *search))
    notes = [
        FOUND,
        "loads: total of a joint in one sector; check: its residual",
    ]
    for name, each in islice(known.items(), MOST):
        if len(each.drawn):
            low, high = 1e6 * each.drawn.min(), 1e6 * each.drawn.max()
            case = "" if len(known) == 1 else f"{name}: "
            places = f"{len(each.drawn)} random place{'s' if len(each.drawn) > 1 else ''}"
            notes.append(f"{case}{places}: {low:.4g} to {high:.4g} µm")
    notes += _cut(len(known))
    title = "Bounds of the peaks over static friction, which the model does not determine"
    made = Table(title, columns, rows, notes, "bounds")
    return made.without("case") if len(known) == 1 else made


def _cut(count: int) -> list[str]:
    """A line where a table has not all of so many cases."""
    return [f"the first {MOST} of {count} cases; results.h5 has all"] if count > MOST else []


def _counted(verdict: NDArray[np.int64]) -> str | None:
    """How many of several points have which verdict."""
    if len(verdict) == 1:
        return None
    counts = ((word, int((verdict == code).sum())) for code, word in WORDS.items())
    return ", ".join(f"{count} {word}" for word, count in counts if count)


def _load(loads: NDArray[np.float64] | None, place: int) -> float | None:
    """One of a joint's loads, N; what is round-off of the largest is zero."""
    if loads is None:
        return None
    return float(loads[place]) if loads[place] > ROUND_OFF * loads.max() else 0.0


def stability_table(assessments: Mapping[str, Assessment]) -> Table | None:
    """What becomes of small departures from the waves of each case: of its most unstable one."""
    found = {name: each.stability[0] for name, each in assessments.items() if each.stability}
    if not found:
        return None
    columns = (
        Column("case"),
        Column("at", "Hz", ".6g", "frequency_hz"),
        Column("stability", key="wave"),
        Column(
            "growth per cycle",
            key="growth",
            note="growth: of the fastest growing disturbance (Floquet multiplier)",
        ),
        Column("ND", key="diameter", note="ND: its nodal diameter"),
        Column("unstable multipliers", key="growing"),
        Column("visible at", "Hz", key="seen_hz"),
        Column("growth with H", key="first"),
        Column(
            "growth with H + 2", key="second", note="with H, H + 2: with two numbers of harmonics"
        ),
        Column("points"),
    )
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for name, each in islice(found.items(), MOST):
        growth = np.exp(each.growth / each.frequency[:, None])
        worst = int(np.lexsort((np.nan_to_num(np.fmax(*growth.T)), RANK[each.verdict]))[-1])
        seen = each.seen[worst, 0]
        rows.append(
            (
                name,
                each.frequency[worst],
                WORDS[int(each.verdict[worst])],
                abs(each.multiplier[worst, 0]),
                int(each.diameter[worst, 0]),
                int(each.growing[worst]),
                ", ".join(f"{f:.4g}" for f in seen[np.isfinite(seen)]) or None,
                *growth[worst],
                _counted(each.verdict),
            )
        )
        flags.append("good" if each.verdict[worst] == STABLE else "warn")
    title = "Stability of the periodic waves, all nodal diameters considered"
    made = Table(title, columns, rows, _cut(len(found)), "stability", flags).without_empty("points")
    return made.without("case") if len(found) == 1 else made


def settled_table(assessments: Mapping[str, Assessment]) -> Table | None:
    """What the ring does instead of the unstable wave at the peak of each case."""
    found = {name: each.settled[0] for name, each in assessments.items() if each.settled}
    known = {name: each for name, each in found.items() if each.found is not None}
    if not known:
        return None
    columns = (
        Column("case"),
        Column("at", "Hz", ".6g", "frequency_hz"),
        Column("balance", "µm", key="balance_um", note="balance: peak of the periodic wave"),
        Column(
            "mean",
            "µm",
            key="mean_um",
            note="mean, smallest, largest: in time, over all sectors and the last periods",
        ),
        Column("smallest", "µm", key="smallest_um"),
        Column("largest", "µm", key="largest_um"),
        Column("in time", key="settled"),
        Column("periods", note="periods: followed in all"),
        Column("not solved", key="unsolved"),
    )
    rows: list[tuple[Cell, ...]] = []
    for name, each in islice(known.items(), MOST):
        settled = each.settled
        assert settled is not None
        assert each.found is not None
        size = each.balance, settled.mean, settled.smallest, settled.largest
        count = settled.periods, settled.unsolved or None
        rows.append((name, each.found.frequency, *size, settled.words, *count))
    title = "Rings followed in time from unstable peaks"
    made = Table(title, columns, rows, _cut(len(known)), "settled").without_empty("unsolved")
    return made.without("case") if len(known) == 1 else made


def unlike_table(assessments: Mapping[str, Assessment]) -> Table | None:
    """Of each case how far rings of unlike segments are amplified, and the worst segment."""
    found = {name: each.unlike for name, each in assessments.items() if each.unlike is not None}
    if not found:
        return None
    columns = (
        Column("case"),
        Column("rings"),
        Column(
            "amplification, 5 %",
            form=".4f",
            key="p5",
            note="amplification: of the worst segment, over the peak of alike ones",
        ),
        Column("50 %", form=".4f", key="p50"),
        Column("95 %", form=".4f", key="p95"),
        Column("largest", form=".4f", key="largest"),
        Column("peak", "µm", key="peak_um", note="peak, at: of the worst segment of all rings"),
        Column("at", "Hz", ".6g", "frequency_hz"),
        Column("ring"),
        Column("segment"),
        Column("points"),
        Column("not converged", key="lost"),
    )
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for name, each in islice(found.items(), MOST):
        known = each.largest[np.isfinite(each.largest)]
        many = len(known) > 1
        shares = np.percentile(known, PERCENTILES).tolist() if many else [None] * 3
        worst: tuple[Cell, ...] = (None,) * 5
        if (place := each.place) is not None:
            amplitude = each.amplitude[place]
            worst = (float(known.max()), amplitude, each.frequency[place], *(i + 1 for i in place))
        lost = int(each.lost.sum())
        rows.append(
            (name, len(each.largest), *shares, *worst, int(each.points.sum()), lost or None)
        )
        flags.append("warn" if lost else "")
    sectors = next(iter(found.values())).amplitude.shape[1]
    notes = [
        f"one linear mode a segment, without friction, reaches at most {whitehead(sectors):.2f} "
        "(Whitehead, 1966)",
        *_cut(len(found)),
    ]
    made = Table("Rings of unlike segments", columns, rows, notes, "unlike", flags)
    made = made.without_empty("p5", "p50", "p95", "lost")
    return made.without("case") if len(found) == 1 else made
