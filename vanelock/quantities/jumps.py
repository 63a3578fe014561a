"""Several solutions: where a sweep jumps, and what the sweep in the other direction found."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from vanelock.stages.response.summary import ALIKE, Sweep

MOST = 4
"""Jumps of a sweep that are named, the largest ones."""


def rows(sweep: Sweep) -> NDArray[np.float64]:
    """(j, 4) frequencies before and after each jump, Hz, and amplitudes, m."""
    found = [(*each.frequency, *each.amplitude) for each in sweep.jumps]
    return np.array(found, float).reshape(-1, 4)


def notes(sweeps: Sequence[Sweep]) -> Iterator[str]:
    """What to know of a case's several solutions, a line each."""
    for sweep in sweeps:
        if not sweep.jumps:
            continue
        largest = sorted(sweep.jumps, key=lambda jump: -abs(np.diff(jump.amplitude)[0]))[:MOST]
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
    if abs(a - b) > ALIKE * a or higher.jumps or lower.jumps:
        yield (
            f"the peak is that of the sweep {higher.direction}; sweeping {lower.direction} "
            f"reaches {b:.4g} um at {lower.peak.frequency:.6g} Hz"
        )
