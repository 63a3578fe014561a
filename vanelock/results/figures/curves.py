"""Forced response of all cases in one figure, with its linear limits.

Curves as one table: a row for each point of each curve, one value in a column.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from vanelock import render
from vanelock.common.arrays import Floats
from vanelock.input.cases.names import words
from vanelock.input.measured.units import DISPLACEMENT
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.products import Drawn
from vanelock.quantities.run_result import MANY, PERCENT, RunResult, band, in_words, named
from vanelock.report import Picture
from vanelock.stages.response.limits import Limit

NOTE = (
    "a row for each point of each curve; case: its name in tables, empty where a curve is of none "
    "or of several; converged: 1, or 0 where the point is not to be trusted; stability: where known"
)
STABILITY = ("stable", "unstable", "undecided", None)
"""By the verdict on a point; the last one is that of -1."""

Row = tuple[str, str, float, float, int | None, str | None]


def _columns(
    curves: Sequence[render.Curve], band: render.Band | None = None
) -> Mapping[str, ArrayLike]:
    """Columns of some curves, with their bounds, and of percentiles of many."""
    rows = [row for curve in curves for row in _rows(curve)]
    if band is not None:
        for percent, level in zip(PERCENT, band.levels, strict=True):
            rows += _points(f"{band.label}, {percent} %", "", band.frequency, level)
    heads = "curve", "case", "frequency (Hz)", "amplitude (µm)", "converged", "stability"
    kinds = str, str, float, float, object, object
    cells = list(zip(*rows, strict=True)) or [()] * len(heads)
    return {
        head: np.array(column, kind) for head, kind, column in zip(heads, kinds, cells, strict=True)
    }


def _rows(curve: render.Curve) -> Iterator[Row]:
    count = len(curve.frequency)
    converged: Sequence[int | None] = [None] * count
    if curve.converged is not None:
        converged = curve.converged.astype(int).tolist()
    verdict = [-1] * count if curve.verdict is None else curve.verdict
    points = _points(curve.label, curve.case, curve.frequency, curve.amplitude)
    for point, solved, code in zip(points, converged, verdict, strict=True):
        yield (*point[:4], solved, STABILITY[code])
    if (around := curve.envelope) is not None:
        for end, level in (("lower bound", around.low), ("upper bound", around.high)):
            yield from _points(f"{curve.label}, {end}", curve.case, around.frequency, level)


def _points(label: str, case: str, frequency: Floats, amplitude: Floats) -> list[Row]:
    points = zip(frequency.tolist(), (1e6 * amplitude).tolist(), strict=True)
    return [(label, case, f, a, None, None) for f, a in points]


RESPONSE = "Forced response"
MOST = 16
"""Linear limits that are drawn, free and stuck ones together."""


def all_curves(run: RunResult) -> list[render.Curve]:
    """Linear limits, responses and measured curves, as they are drawn."""
    made = _linear(run)
    for each in _drawn_alone(run):
        name, verdicts, ends = each.name, each.verdicts, each.ends
        for direction, curve in each.curves.items():
            frequency, amplitude, converged = curve
            verdict = verdicts.get(direction)
            along = verdict is not None and np.count_nonzero(verdict >= 0) > 1
            made.append(
                render.Curve(
                    frequency,
                    amplitude,
                    # Where line styles separate stable from unstable, colours all else.
                    group=words(name) if along and name != "nominal" else called(name),
                    harmonics=None if along else each.summary.harmonics,
                    converged=converged,
                    joined=each.problem.response.frequencies is None,
                    variant=direction,
                    envelope=_envelope([curve, *ends]) if ends else None,
                    verdict=verdict,
                    case=name,
                )
            )
    return made + [
        render.Curve(
            each.frequency, each.amplitude, group=each.label, kind="measured", joined=False
        )
        for each in run.measured
        if each.quantity == DISPLACEMENT
    ]


def _drawn_alone(run: RunResult) -> list[CaseResult]:
    """Cases with a curve of their own."""
    return list(run.cases.values()) if len(run.cases) <= MANY else named(run)


def curves(run: RunResult) -> Picture:
    """The figure of the curves, and what it draws as CSV."""
    made = all_curves(run)
    keys = [(*each.solved_keys, each.name) for each in run.cases.values()]
    monitor = run.monitor.name
    shows = [keys, monitor, run.problem.name, *(each.shown for each in run.measured)]
    order = one_order(run.cases.values())
    title = f"{run.problem.name}: forced response"
    shade = band(run)
    path = run.output_files.draw(
        "figures/response.png",
        shows,
        lambda path: render.response_curves(
            path, made, title, monitor, engine_order=order, band=shade
        ),
    )
    notes = [
        f"{title}, {monitor}: half the peak-to-peak over the excitation frequency",
        NOTE,
    ]
    data = run.table("figures/response.csv", shows, lambda: _columns(made, shade), notes)
    limits = (
        f"The thin lines are the linear limits, with {run.opens} free (dashed) and "
        "stuck (dotted): without friction's damping the peak would be as high as theirs. "
        if run.opens
        else "The thin dashed line is the linear limit: the same structure without friction's "
        "damping. "
    )
    caption = (
        f"Amplitude of {monitor} (half the peak-to-peak) over the excitation frequency. {limits}"
        "The other lines are the responses with friction, each with a marker at its peak, whose "
        "value stands in the legend. Read off how far friction lowers the peak, and how far it "
        "moves the resonance from the free towards the stuck frequency."
        f"{' Black dots are measured.' if run.measured else ''}"
    )
    caption += key_to_lines(made)
    if shade is not None:
        caption += (
            f" Shaded: where {shade.label} lie at each frequency, and their median; lines of their "
            f"own have {in_words(run)}."
        )
    return Picture(path, RESPONSE, caption, (data,), section="summary")


def one_order(cases: Iterable[CaseResult]) -> int | None:
    """The engine order of the speed axis, where all cases on rings have the same one."""
    found = {
        abs(order) for sectors, order in (each.ring for each in cases) if sectors > 1 and order
    }
    return found.pop() if len(found) == 1 else None


def key_to_lines(curves: Sequence[render.Curve]) -> str:
    """What shades and line styles say of bounds and stability, if anything."""
    text = ""
    if any(curve.envelope is not None for curve in curves):
        text += (
            " Shaded: between the curves whose peaks are the least and the largest that static "
            "friction, which no model determines, allows."
        )
    if any(len(curve.pieces) > 1 for curve in curves):
        text += " Solid where the periodic wave is stable, dashed where it is unstable, grey where "
        text += "that is undecided."
    return text


def _envelope(curves: Sequence[Drawn]) -> render.Envelope:
    """Between which amplitudes a curve and others lie at each frequency."""
    frequency = np.unique(np.concatenate([f[solved] for f, _, solved in curves]))
    lines = []
    for f, amplitude, solved in curves:
        order = np.argsort(f, kind="stable")
        order = order[solved[order]]
        lines.append((f[order], amplitude[order]))
    every = [np.interp(frequency, *line) for line in lines]
    return render.Envelope(frequency, np.min(every, axis=0), np.max(every, axis=0), lines[1:])


def called(name: str) -> str:
    """A case in the legend, where its harmonics stand apart."""
    return "with friction" if name == "nominal" else words(name, without="harmonics")


def _linear(run: RunResult) -> list[render.Curve]:
    """Linear limits, equal ones once."""
    limits = run.limits
    if len(limits) > MOST:  # a stiffness is swept: those of the cases that are shown
        own = {each.linear_name for each in named(run)}
        limits = {key: curve for key, curve in limits.items() if key[0] in own}
    return limit_curves(limits)


def limit_curves(
    limits: Mapping[tuple[str, Limit], tuple[Floats, Floats]],
) -> list[render.Curve]:
    """Curves of linear limits by name and kind, equal ones once."""
    found: list[tuple[list[str], Limit, Floats, Floats]] = []
    for (name, which), (f, a) in limits.items():
        for names, other, *curve in found:
            if other == which and _equal(curve[0], f) and _equal(curve[1], a):
                names.append(name)
                break
        else:
            found.append(([name], which, f, a))
    groups = {name for name, _ in limits}
    return [
        render.Curve(f, a, kind=which, group="" if len(names) == len(groups) else _merged(names))
        for names, which, f, a in found
    ]


def _merged(names: Sequence[str]) -> str:
    """Words for cases that share a curve: the values that differ are listed, equal ones once."""
    values: dict[str, list[str]] = {}
    for name in names:
        for text in words(name).split(", "):
            key, _, value = text.partition(" = ")
            if value not in values.setdefault(key, []):
                values[key].append(value)
    return ", ".join(
        f"{key} = {' or '.join(found)}" if any(found) else key for key, found in values.items()
    )


def _equal(a: Floats, b: Floats) -> bool:
    """Whether two curves are the same but for round-off."""
    return a.shape == b.shape and bool(np.allclose(a, b, rtol=1e-6, atol=0, equal_nan=True))
