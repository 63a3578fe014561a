"""What a ring does instead of an unstable wave: followed in time from the peak of a response."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vanelock import nonlinear
from vanelock.analyses.analysis import Analysis, AnalysisPart, products_of
from vanelock.common.product import Product
from vanelock.common.tables import Cell, Column, Table, by_case
from vanelock.input.schema.structure.structure import KeyTable

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, Problem, SolvedCase, Summary
    from vanelock.stages.response.summary import Settled

STEPS, PERIODS = 128, 1000
"""Steps a period, and periods at most; some tenths of a second each for a coarse vane's ring."""
MODES = 60
"""Modes of a nodal diameter that keep their inertia; the others follow statically."""
DISTURBANCE = 1e-4


class _SettledKeys(KeyTable):
    """What a ring does instead of an unstable wave, followed in time."""


@dataclass(frozen=True)
class FollowedPeak(Product):
    """What the ring does at the peak of a response.

    Attributes
    ----------
    found : SettledResponse or None
        None where the peak's wave is not unstable, so that it was not followed.
    node, component : int
        The monitored displacement among the outputs.
    """

    found: "nonlinear.SettledResponse | None" = None
    node: int = 0
    component: int = 0

    @property
    def settled(self) -> "Settled | None":
        """The monitored displacement in numbers."""
        from vanelock.stages.response.summary import Settled

        if (found := self.found) is None:
            return None
        at = self.node, self.component
        words = {nonlinear.STEADY: "steady", nonlinear.MODULATED: "modulated"}
        return Settled(
            verdict=words.get(found.verdict, "not settled"),
            **{name: float(getattr(found, name)[at]) for name in ("mean", "largest", "smallest")},
            periods=found.periods,
            returned=found.returned,
            unsolved=found.unsolved,
        )


def _check(problem: "Problem", keys: _SettledKeys) -> Iterator[str]:
    """What keeps unstable peaks from being known."""
    if getattr(problem, "stability", None) is None:
        yield "settled: needs [stability], which says whether a peak is unstable"


def _compute(case: "SolvedCase", keys: _SettledKeys, part: AnalysisPart) -> FollowedPeak:
    """What the ring does at the peak of a response, if its wave is unstable."""
    from vanelock.stages.response.responses import as_solved

    response = case.responses[part.response]
    stability: nonlinear.Stability = case.product("stability", part.response)
    if (peak := case.peak_of(response)) is None:
        return FollowedPeak()
    at = np.flatnonzero(stability.frequency == peak.frequency)
    if not len(at) or stability.verdict[at[0]] != nonlinear.UNSTABLE:
        return FollowedPeak()
    alone = as_solved(response, peak.point)
    found = nonlinear.settled_response(
        case.whole,
        alone,
        0,
        steps=max(STEPS, 4 * alone.harmonics + 4),
        periods=PERIODS,
        disturbance=DISTURBANCE,
        modes=MODES,
        growth=float(stability.growth[at[0]].min()),
        progress=case.progress,
    )
    return FollowedPeak(found, case.monitored.node, case.monitored.component)


def _summarise(summary: "Summary", products: Sequence[FollowedPeak]) -> "Summary":
    """A case's summary with what the ring does instead of the wave at its peak."""
    if summary.wave is None:
        return summary
    return replace(summary, wave=replace(summary.wave, settled=products[0].settled))


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """What the ring does instead of the unstable wave at the peak of each case."""
    every, count = products_of(cases, "settled")
    known = {name: each for name, (each, *_) in every.items() if each.found is not None}
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
    for name, each in known.items():
        settled = each.settled
        balance = each.found.balance[each.node, each.component]
        size = balance, settled.mean, settled.smallest, settled.largest
        ends = settled.words, settled.periods, settled.unsolved or None
        rows.append((name, each.found.frequency, *size, *ends))
    title = "Rings followed in time from unstable peaks"
    made = Table(title, columns, rows, (), "settled").without_empty("unsolved")
    yield from by_case(made, count)


TEMPLATE = """\
# The ring integrated in time where its wave at the peak does not last, which [stability] says; the
# table's name alone is enough. See `vanelock manual bounds_and_stability`.
# [settled]
"""

SETTLED = Analysis(
    key="settled",
    title="unstable peaks in time",
    keys=_SettledKeys,
    scene_keys=_SettledKeys,
    product=lambda: FollowedPeak,
    compute=_compute,
    by_response=True,
    whole_ring=lambda problem, keys: True,
    after=("stability",),
    check=_check,
    places=lambda product: "" if product.found is None else "settled",
    summarise=_summarise,
    tables=_tables,
    template=TEMPLATE,
)
