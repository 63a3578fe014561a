"""What to know of a case before its numbers are used: lines for terminal, page and results.

Studies and scenes take them from the same functions, each from the products that show it; where a
sweep jumps, and what the sweep in the other direction reached, is among them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from vanelock.input.cases.names import words
from vanelock.input.schema.response import ResponseKeys
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.summary import AGREE, Summary, Sweep

_ALIKE = 0.8
"""Least modal assurance criterion between the mode of interest free and stuck."""
_NAMED = 8
"""Cases that a line names."""
_SAME = 1e-9
"""Relative difference of peaks below which cases are the same."""
_ASIDE = (
    ("campbell.", "stability.", "mistuning."),
    (".fatigue_limit", ".tensile_strength", ".wear_coefficient"),
)
"""How keys begin and end that have their effect elsewhere than in peaks and their bounds."""


FREE = (
    "rigid-body motions are held by nothing: they vibrate without stiffness, are left out at rest, "
    "and response.mode does not count them"
)
"""What is to be known of a structure that moves freely, behind their number."""


def of_case(summary: Summary) -> list[str]:
    """All that is to be known of a case, a line each."""
    return [*_doubts(summary), *summary.warnings]


def _doubts(summary: Summary) -> list[str]:
    """Why the peak of a case may not be the largest."""
    lines = []
    if summary.peak is None:
        lines.append("no point converged")
    lines += _lost(summary)
    if summary.peak is not None and summary.peak.at_edge:
        lines.append(
            "the largest point is at the end of the frequency range; a peak may lie beyond"
        )
    return lines


def _lost(summary: Summary) -> list[str]:
    """How many points of a case did not converge, if any."""
    if summary.converged == summary.points:
        return []
    return [
        f"{summary.points - summary.converged} of {summary.points} points DID NOT CONVERGE "
        f"(largest residual {summary.worst:.1e}); they are left out"
    ]


def by_text(cases: Mapping[str, Summary], shown: Callable[[str], str] = words) -> list[str]:
    """Sentences on the cases of a run: each line once, with its cases, named as `shown`."""
    named: dict[str, list[str]] = {}
    for name, found in cases.items():
        for line in of_case(found):
            named.setdefault(line, []).append(shown(name))
    sentences = []
    for line, names in named.items():
        who = "; ".join(names[:_NAMED])
        if len(names) > _NAMED:
            who += f" and {len(names) - _NAMED} more"
        if len(names) == len(cases) > 1:
            who = "all cases"
        sentences.append(f"{who}: {line}.")
    return sentences


def alike(mac: float) -> list[str]:
    """Whether the mode of interest is the same with contacts free and stuck."""
    if mac >= _ALIKE:
        return []
    return [
        f"the mode of interest free and the one stuck are alike by MAC {mac:.2f} only: they may be "
        "different modes, and a place between the two means nothing"
    ]


def beside_range(keys: ResponseKeys, limits: Limits) -> list[str]:
    """Whether frequencies are given that hold no mode of interest, from free to stuck."""
    if (asked := keys.frequencies or keys.range) is None:
        return []
    low, high = sorted((limits.free_frequency, limits.stuck_frequency))
    if min(asked) <= high and low <= max(asked):
        return []
    name = "range" if keys.frequencies is None else "frequencies"
    return [
        f"response.{name}: {min(asked):.6g} to {max(asked):.6g} Hz hold no mode of interest: "
        f"mode {keys.mode} lies at {limits.free_frequency:.6g} Hz with contacts free, "
        f"{limits.stuck_frequency:.6g} Hz stuck"
    ]


def without_effect(cases: Sequence[tuple[Mapping[str, float | str], Summary]]) -> list[str]:
    """Swept keys whose values change nothing: cases that differ in one alone are the same."""
    lines = []
    for key in cases[0][0] if cases else ():
        if key.startswith(_ASIDE[0]) or key.endswith(_ASIDE[1]):
            continue
        groups: dict[tuple[object, ...], list[Summary]] = {}
        for values, found in cases:
            others = tuple(value for name, value in values.items() if name != key)
            groups.setdefault(others, []).append(found)
        pairs = [group for group in groups.values() if len(group) > 1]
        if pairs and all(_same(group[0], each) for group in pairs for each in group[1:]):
            lines.append(f"{key} has no effect: cases that differ in it alone are the same")
    return lines


def _same(one: Summary, other: Summary) -> bool:
    if one.peak is None or other.peak is None or one.points != other.points:
        return False
    a, b = (
        [(peak.amplitude, peak.frequency) for peak in (c.peak, c.lowest, c.highest) if peak]
        for c in (one, other)
    )
    return len(a) == len(b) and bool(np.allclose(a, b, rtol=_SAME, atol=0))


_MOST = 4
"""Jumps of a sweep that are named, the largest ones."""


def notes(sweeps: Sequence[Sweep]) -> Iterator[str]:
    """What to know of a case's several solutions, a line each."""
    for sweep in sweeps:
        if not sweep.jumps:
            continue
        largest = sorted(sweep.jumps, key=lambda jump: -abs(np.diff(jump.amplitude)[0]))[:_MOST]
        text = "; ".join(
            f"from {1e6 * jump.amplitude[0]:.4g} to {1e6 * jump.amplitude[1]:.4g} um between "
            f"{min(jump.frequency):.6g} and {max(jump.frequency):.6g} Hz"
            for jump in sorted(largest, key=lambda jump: jump.frequency)
        )
        more = len(sweep.jumps) - len(largest)
        rest = f"; and {more} smaller {'jump' if more == 1 else 'jumps'}" if more else ""
        way = f"sweeping {sweep.direction}"
        if sweep.direction == "both":
            way = "the curve of the highest solutions found"
        yield f"{way} JUMPS {text}{rest}"
    if len(sweeps) > 1:
        yield from _compared(*sweeps)
    elif sweeps and sweeps[0].jumps:
        yield (
            "higher solutions were looked for from every jump and in both directions"
            if sweeps[0].direction == "both"
            else "other solutions were not looked for, and may reach higher: "
            'response.direction = "both"'
        )


def _compared(higher: Sweep, lower: Sweep) -> Iterator[str]:
    """Which of two sweeps the peak is of, where they differ."""
    if higher.peak is None or lower.peak is None:
        yield f"no point converged sweeping {lower.direction}"
        return
    a, b = 1e6 * higher.peak.amplitude, 1e6 * lower.peak.amplitude
    if abs(a - b) > AGREE * a or higher.jumps or lower.jumps:
        yield (
            f"the peak is that of the sweep {higher.direction}; sweeping {lower.direction} "
            f"reaches {b:.4g} um at {lower.peak.frequency:.6g} Hz"
        )
