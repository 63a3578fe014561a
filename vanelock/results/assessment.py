"""Tables of what responses are worth: bounds over static friction, and stability."""

from collections.abc import Mapping
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from vanelock.common.tables import Cell, Column, Flag, Table, heads
from vanelock.nonlinear import STABLE, Stability
from vanelock.stages.assessment.bounds import BoundedPeak
from vanelock.stages.assessment.stability import WORDS

MOST = 24
"""Cases that a table has; of more it says so."""
ENDS = ("lower bound", "as assembled", "upper bound")
"""What the three places of `PeakBounds` are called."""
ROUND_OFF = 1e-9
RANK = np.array([0, 2, 1])
"""How bad the verdicts 0 stable, 1 unstable, 2 undecided are."""
FOUND = (
    "found, not proved: the search starts at extreme loads and at random places and follows the "
    "peak's gradient; stationary: the gradient leads no further"
)


def bounds_table(found: Mapping[str, BoundedPeak]) -> Table:
    """Of each case the least peak, that as assembled and the largest, with loads by joint."""
    known = {name: each.found for name, each in found.items() if each.found is not None}
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


def stability_table(found: Mapping[str, Stability]) -> Table:
    """What becomes of small departures from the waves of each case: of its most unstable one."""
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
