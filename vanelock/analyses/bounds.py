"""Bounds of a peak over static friction, which no model of a joint determines.

Contacts that stick throughout may carry any force within Coulomb's limit; the extreme peaks over
these forces are found by `nonlinear.peak_bounds`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from vanelock import nonlinear
from vanelock.analyses.analysis import Analysis, AnalysisPart, CurveLines, products_of
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.common.tables import Cell, Column, Table, by_case, heads
from vanelock.input.schema.structure.structure import KeyTable

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, Peak, Problem, SolvedCase, State, Summary

LOW, NOMINAL, HIGH = 0, 1, 2
"""Places of `PeakBounds`."""
ENDS = ("lower bound", "as assembled", "upper bound")
"""What they are called."""
CURVES = 40.0
"""Curves that bounds cost (docs/benchmarks/static_friction.md)."""
APART = 0.01
"""Relative difference of a peak from that of the curve from which it is worth a line."""
AUDIT = 1e-6
"""Residual of an independent check from which it is worth a line."""
ROUND_OFF = 1e-9
FOUND = (
    "found, not proved: the search starts at extreme loads and at random places and follows the "
    "peak's gradient; stationary: the gradient leads no further"
)
TEXT = (
    "Contacts that stick throughout may carry any static friction within Coulomb's limit; it "
    "depends on assembly and load history, which the model does not know. It changes the load on "
    "the joints that slip, and so the peak. The curve assumes assembly without stress; the bounds "
    "are the lowest and the highest peak found over all admissible static friction."
)
ABSENT = (
    "**Static friction** of contacts that stick: parts are taken as assembled without stress; "
    "`[bounds]` computes how far other static friction moves the peak."
)


class BoundsKeys(KeyTable):
    """Between which values static friction, which no model determines, may move the peak."""

    share: float = Field(default=1.0, ge=0, le=1, description="share of Coulomb's limit")
    starts: int = Field(default=4, ge=0, le=1000, description="number of random starts")


@dataclass(frozen=True)
class BoundedPeak(Product):
    """Bounds of a peak, and the curves at both; without bounds, why there are none.

    Attributes
    ----------
    found : PeakBounds or None
    low, high : Response or None
        Over the frequencies of the case, with the sliders of the least and of the largest peak.
    residual : (3,) float
        Of an audit of the peaks, see `Audit`.
    reason : str
        Why there are no bounds.
    """

    found: "nonlinear.PeakBounds | None" = None
    low: "nonlinear.Response | None" = None
    high: "nonlinear.Response | None" = None
    residual: Floats = field(default_factory=lambda: np.full(3, np.nan))
    reason: str = ""

    def peak(self, index: int) -> "Peak | None":
        """The least (0), nominal (1) or largest (2) peak; None without bounds."""
        if self.found is None:
            return None
        from vanelock.stages.response.summary import Peak

        at = float(self.found.frequency[index]), float(self.found.amplitude[index])
        return Peak(index, *at, at_edge=False)


def _check(problem: "Problem", keys: BoundsKeys) -> Iterator[str]:
    """What keeps a peak from having bounds."""
    frequencies = problem.response.frequencies
    if frequencies is not None and len(frequencies) < 2:
        yield "response.frequencies: given one: [bounds] is of a peak, which takes a range"


def _compute(case: "SolvedCase", keys: BoundsKeys, part: AnalysisPart) -> BoundedPeak:
    """Bounds of the peak of that sweep which finds the higher one."""
    if case.peak is None:
        return BoundedPeak(reason="no point converged")
    system, watched = case.system, case.monitored
    try:
        found = nonlinear.peak_bounds(
            system,
            case.range,
            case.options,
            (system.output_names[watched.node], watched.component),
            "all",
            keys.share,
            keys.starts,
            seed=part.inputs["seed"],
            progress=lambda done, amplitude: case.count(done, None, amplitude),
            modes=case.modes,
        )
    except InputError as error:
        return BoundedPeak(reason=str(error))
    at = [found.system_at(system, place) for place in (LOW, NOMINAL, HIGH)]
    audits = [
        nonlinear.audit_response(each, found.response.at([place])) for place, each in enumerate(at)
    ]
    low, high = (
        nonlinear.frequency_response(at[place], case.frequencies, case.options, None, case.modes)
        for place in (LOW, HIGH)
    )
    return BoundedPeak(found, low, high, np.array([each.residual[0] for each in audits]))


def _summarise(summary: "Summary", products: Sequence[BoundedPeak]) -> "Summary":
    """A case's summary with both ends."""
    (bounds,) = products
    return replace(summary, lowest=bounds.peak(LOW), highest=bounds.peak(HIGH))


def _lines(products: Sequence[BoundedPeak]) -> CurveLines:
    """Between which curves the response may lie."""
    (bounds,) = products
    return (() if bounds.found is None else (bounds.low, bounds.high)), ()


def _states(case: "CaseResult") -> "Iterator[State]":
    """The case with the sliders of its largest peak."""
    from vanelock.quantities.case_result import State

    (bounds,) = case.found("bounds")
    if (high := bounds.peak(HIGH)) is not None:
        response = bounds.found.response.at([HIGH])
        yield State(response, replace(high, point=0), case.curve(bounds.high))


def _warnings(case: "CaseResult", products: Sequence[BoundedPeak]) -> Iterator[str]:
    """What keeps bounds from being taken as they are."""
    (bounds,), peak = products, case.peak
    if peak is None:
        return
    if bounds.found is None:
        yield f"no bounds of the peak over static friction: {bounds.reason}"
        return
    for i, end in ((LOW, "least"), (HIGH, "largest")):
        if not bounds.found.converged[i]:
            yield f"the {end} peak over static friction DID NOT CONVERGE"
    if (worst := float(bounds.residual.max())) > AUDIT:
        yield f"peaks over static friction miss an independent check by {worst:.1e}"
    nominal = bounds.peak(NOMINAL)
    if nominal is not None and abs(nominal.amplitude - peak.amplitude) > APART * peak.amplitude:
        here, there = (
            f"{1e6 * each.amplitude:.4g} um at {each.frequency:.6g} Hz" for each in (nominal, peak)
        )
        yield (
            "the bounds over static friction are of ANOTHER PEAK than the curve's: as assembled "
            f"theirs is {here}, the curve's {there}"
        )


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """Of each case the least peak, that as assembled and the largest, with loads by joint."""
    every, count = products_of(cases, "bounds")
    known = {name: (each, each.found) for name, (each,) in every.items() if each.found is not None}
    joints = list(dict.fromkeys(joint for _, found in known.values() for joint in found.joints))
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
    notes = [FOUND, "loads: total of a joint in one sector; check: its residual"]
    for name, (bounds, found) in known.items():
        for i, end in enumerate(ENDS):
            loads = [
                _load(dict(zip(found.joints, load.T, strict=True)).get(joint), i)
                for load in (found.rest_load, found.mean_load)
                for joint in joints
            ]
            numbers = found.amplitude[i], found.frequency[i], *loads
            stationary = "yes" if found.stationary[i] else "no"
            search = found.found_by[i], stationary, bounds.residual[i]
            rows.append((name, end, *numbers, *search))
        if len(found.drawn):
            low, high = 1e6 * found.drawn.min(), 1e6 * found.drawn.max()
            of = "" if count == 1 else f"{name}: "
            places = f"{len(found.drawn)} random place{'s' if len(found.drawn) > 1 else ''}"
            notes.append(f"{of}{places}: {low:.4g} to {high:.4g} µm")
    title = "Bounds of the peaks over static friction, which the model does not determine"
    yield from by_case(Table(title, columns, rows, notes, "bounds"), count)


def _load(loads: Floats | None, index: int) -> float | None:
    """One of a joint's loads, N; what is round-off of the largest is zero."""
    if loads is None:
        return None
    return float(loads[index]) if loads[index] > ROUND_OFF * loads.max() else 0.0


TEMPLATE = """\
# Between which values static friction in contacts that stick, which no model determines, may move
# the peak; the table's name alone is enough. See `vanelock manual bounds_and_stability`.
# [bounds]
# share = 1.0                   # 0: friction as assembled without stress
# starts = 4                    # random places to search from, beside the extreme loads
"""

BOUNDS = Analysis(
    key="bounds",
    title="bounds over static friction",
    keys=BoundsKeys,
    scene_keys=BoundsKeys,
    product=lambda: BoundedPeak,
    compute=_compute,
    parts=lambda problem, keys: (AnalysisPart(inputs={"seed": problem.seed}),),
    check=_check,
    cost=lambda study, keys, curve: CURVES * curve,
    summarise=_summarise,
    lines=_lines,
    states=_states,
    state="upper bound of the peak over static friction",
    reserve="goodman_reserve_at_largest_peak",
    warnings=_warnings,
    tables=_tables,
    text=TEXT,
    template=TEMPLATE,
    absent=lambda case: ABSENT,
)
