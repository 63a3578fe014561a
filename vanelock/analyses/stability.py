"""Whether a ring stays with the periodic waves of a response: Floquet stability of its points."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field

from vanelock import nonlinear, report
from vanelock.analyses.analysis import Analysis, AnalysisPart, CurveLines, products_of
from vanelock.common.arrays import Integers
from vanelock.common.tables import Cell, Column, Flag, Table, by_case
from vanelock.input.schema.structure.structure import KeyTable

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, Problem, SolvedCase, Study, Summary
    from vanelock.stages.response.summary import WaveVerdict

SECONDS, HARMONICS = 3.3, 0.5
"""Of a point, and with each (2H + 1)^1.5 (docs/benchmarks/stability.md)."""
WORDS = ("stable", "unstable", "undecided")
"""What the verdicts 0, 1, 2 are called."""
RANK = np.array([0, 2, 1])
"""How bad they are."""
TEXT = (
    "A periodic solution need not be stable. Small disturbances of all nodal diameters are "
    "linearised about it, including the memory of friction (Floquet): where one grows, the ring "
    "leaves the periodic wave and its vibration is modulated; neither its largest amplitude nor "
    "its friction work is then that of the wave."
)
ABSENT = "**Stability**: a solved point need not be stable; `[stability]` decides whether it is."


class StabilityKeys(KeyTable):
    """Whether the ring stays with the periodic wave, all nodal diameters considered."""

    points: Literal["peaks", "all"] = Field(default="peaks", description="points of the response")


def _check(problem: "Problem", keys: StabilityKeys) -> Iterator[str]:
    """What keeps the stability of all points from being known."""
    if keys.points == "all" and getattr(problem, "accuracy", None) is not None:
        yield 'stability.points = "all": with an accuracy choose "peaks"'


def _cost(study: "Study", keys: StabilityKeys, curve: float) -> float:
    """Seconds."""
    from vanelock.stages.cost_estimate import points_of

    count = points_of(study) if keys.points == "all" else 1
    return float(count * (SECONDS + HARMONICS * (2 * study.response.harmonics + 1) ** 1.5))


def _compute(case: "SolvedCase", keys: StabilityKeys, part: AnalysisPart) -> "nonlinear.Stability":
    """Stability of a response: at its peak, or all along."""
    from vanelock.stages.response.responses import as_solved

    response = case.responses[part.response]
    chosen = np.flatnonzero(response.converged).tolist()
    if keys.points == "peaks":
        peak = case.peak_of(response)
        response, chosen = as_solved(response, 0 if peak is None else peak.point), [0]
    return nonlinear.stability(
        case.whole,
        response,
        chosen,
        progress=case.progress,
        modes=case.modes,
    )


def _verdict_at(stability: "nonlinear.Stability", frequency: float) -> "WaveVerdict | None":
    """What is known of the wave at a frequency, Hz, solved; None where nothing is."""
    from vanelock.stages.response.summary import WaveVerdict

    (at,) = np.nonzero(stability.frequency == frequency)
    if not len(at):
        return None
    i = int(at[0])
    seen, verdict = stability.seen[i, 0], int(stability.verdict[i])
    return WaveVerdict(
        verdict=WORDS[verdict],
        growth=float(np.abs(stability.multiplier[i, 0])),
        diameter=int(stability.diameter[i, 0]),
        growing=int(stability.growing[i]),
        frequencies=tuple(seen[np.isfinite(seen)].tolist()),
        reason=_undecided(stability, i) if verdict == nonlinear.UNDECIDED else "",
    )


def _undecided(stability: "nonlinear.Stability", point: int) -> str:
    """Why the verdict at a point is neither stable nor unstable."""
    from vanelock.nonlinear.floquet.stability import NEUTRAL
    from vanelock.nonlinear.fourier import TURN

    growth = stability.growth[point] / (TURN * stability.frequency[point])
    if np.isnan(growth).any():
        return f"the wave was not found again with {stability.harmonics[1]} harmonics"
    if np.any(np.abs(growth) <= NEUTRAL):
        return "a departure from it neither grows nor dies out"
    if growth.min() < 0 < growth.max():
        return "two numbers of harmonics differ on whether a departure from it grows"
    return "not all departures from it could be followed"


def _summarise(summary: "Summary", products: "Sequence[nonlinear.Stability]") -> "Summary":
    """A case's summary with what becomes of the wave at its peak."""
    if summary.peak is None:
        return summary
    return replace(summary, wave=_verdict_at(products[0], summary.peak.frequency))


def _lines(products: "Sequence[nonlinear.Stability]") -> CurveLines:
    """Where each curve is stable."""
    return (), [dict(zip(s.frequency.tolist(), s.verdict.tolist(), strict=True)) for s in products]


def _warnings(case: "CaseResult", products: "Sequence[nonlinear.Stability]") -> Iterator[str]:
    """Whether the ring leaves the wave at the peak."""
    verdict, peak = case.summary.wave, case.peak
    if verdict is None or peak is None or verdict.verdict == "stable":
        return
    if verdict.verdict == "undecided":
        growth = f", growth {verdict.growth:.3g} per cycle" if verdict.growth > 0 else ""
        yield (
            f"the stability of the periodic wave at the peak is UNDECIDED: {verdict.reason}{growth}"
        )
        return
    beside = [f"{f:.4g}" for f in verdict.frequencies if abs(f - peak.frequency) > 1e-3 * f]
    gauge = f"; a gauge shows {', '.join(beside)} Hz beside {peak.frequency:.4g} Hz"
    yield (
        "the periodic wave at the peak is UNSTABLE, the ring does not settle on it: a "
        f"disturbance of nodal diameter {verdict.diameter} grows by a factor "
        f"{verdict.growth:.3g} per cycle{gauge if beside else ''}{verdict.followed}"
    )


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """What becomes of small departures from the waves of each case: of its most unstable one."""
    known, count = products_of(cases, "stability")
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
    for name, (each, *_) in known.items():
        growth = np.exp(each.growth / each.frequency[:, None])
        worst = int(np.lexsort((np.nan_to_num(np.fmax(*growth.T)), RANK[each.verdict]))[-1])
        seen, verdict = each.seen[worst, 0], int(each.verdict[worst])
        fastest = abs(each.multiplier[worst, 0]), int(each.diameter[worst, 0])
        shows = ", ".join(f"{f:.4g}" for f in seen[np.isfinite(seen)]) or None
        ends = int(each.growing[worst]), shows, *growth[worst], _counted(each.verdict)
        rows.append((name, each.frequency[worst], WORDS[verdict], *fastest, *ends))
        flags.append("good" if verdict == nonlinear.STABLE else "warn")
    title = "Stability of the periodic waves, all nodal diameters considered"
    made = Table(title, columns, rows, (), "stability", flags).without_empty("points")
    yield from by_case(made, count)


def _counted(verdict: Integers) -> str | None:
    """How many of several points have which verdict."""
    if len(verdict) == 1:
        return None
    counts = ((word, int((verdict == code).sum())) for code, word in enumerate(WORDS))
    return ", ".join(f"{count} {word}" for word, count in counts if count)


def _answers(case: "CaseResult") -> "Iterator[report.Answer]":
    """Whether the ring stays with the wave of the peak."""
    wave = case.summary.wave
    if wave is None or case.peak is None:
        return
    if wave.verdict == "stable":
        slowest = f"a factor {wave.growth:.4g}" if wave.growth > 0 else "0.53 or less"
        note = f"disturbances decay, the slowest by {slowest} per cycle"
        yield report.Answer("Periodic wave", "stable", note, "good")
    elif wave.verdict == "undecided":
        yield report.Answer("Periodic wave", "undecided", wave.reason, "warn")
    else:
        shows = ", ".join(f"{f:.4g}" for f in wave.frequencies)
        note = (
            f"the ring does not settle on it: a disturbance of nodal diameter {wave.diameter} "
            f"grows by a factor {wave.growth:.3g} per cycle, visible at {shows} Hz{wave.followed}; "
            "amplitude, stress and wear here are those of the periodic wave"
        ).replace(" um", " µm")
        yield report.Answer("Periodic wave", "unstable", note, "warn")


TEMPLATE = """\
# Whether the ring stays with the periodic wave; the casing is then reduced at all nodal diameters.
# The table's name alone is enough. See `vanelock manual bounds_and_stability`.
# [stability]
# points = "peaks"              # or "all" solved points of the curve, each some seconds
"""

STABILITY = Analysis(
    key="stability",
    title="stability",
    keys=StabilityKeys,
    scene_keys=StabilityKeys,
    product=lambda: nonlinear.Stability,
    compute=_compute,
    by_response=True,
    whole_ring=lambda problem, keys: True,
    check=_check,
    cost=_cost,
    summarise=_summarise,
    lines=_lines,
    warnings=_warnings,
    tables=_tables,
    answers=_answers,
    text=TEXT,
    template=TEMPLATE,
    absent=lambda case: ABSENT,
)
