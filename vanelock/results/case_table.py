"""The table of a run's cases: what is known of each, whatever it is read from."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from vanelock.common.tables import Cell, Column, Flag, Table
from vanelock.quantities import warnings
from vanelock.quantities.case_result import Numbers
from vanelock.stages.response.summary import Peak, Summary

MOST_ROWS = 40
"""Cases that a table prints."""
PEAK = (Column("peak", "µm", key="peak_um"), Column("at", "Hz", ".6g", "frequency_hz"))
CASE_COLUMNS = (
    Column("case"),
    Column("H", key="harmonics", minor=True),
    Column("μ", form=".3g", key="mu", minor=True),
    *PEAK,
    Column("lower bound", "µm", key="lowest_um"),
    Column(
        "upper bound",
        "µm",
        key="highest_um",
        note="bounds: of the peak, over the static friction states that are possible at rest",
    ),
    Column("stability", key="wave"),
    Column(
        "growth per cycle",
        key="growth",
        note="growth: of the fastest growing disturbance (Floquet multiplier)",
    ),
    Column("relative to free", key="of_free"),
    Column(
        "relative to stuck",
        key="of_stuck",
        note="relative to free, stuck: over the peak of that linear response",
    ),
    Column(
        "frequency shift",
        form=".3g",
        key="x",
        note="frequency shift: 0 at the free, 1 at the stuck natural frequency",
    ),
    Column("damping ratio", "%", key="damping", note="damping ratio: equivalent, by energy"),
    Column("dissipated", "µJ", key="work_uj", note="dissipated: by friction, per cycle"),
    Column("slip", "%", ".0f", "slipping_percent"),
    Column(
        "open",
        "%",
        ".0f",
        "opening_percent",
        "slip, open: share that slips, and separates, in the cycle at the peak, of the contacts "
        "that are open in the free limit",
    ),
    Column("vibratory stress", "MPa", key="stress"),
    Column(
        "HCF safety factor",
        key="reserve",
        note="stress, safety factor (Goodman): at the critical location of vane and casing",
    ),
    Column("converged", minor=True),
    Column("time", "s", ".1f", "seconds", minor=True),
)
"""What is known of every case."""
ASKED = ("mu", "lowest_um", "highest_um", "wave", "growth", "damping", "stress", "reserve")
"""Of these, the columns that are left out where they hold nothing."""


def case_table(rows: Sequence[Mapping[str, Cell]], monitor: str) -> Table:
    """One line for each case: its cells by the names of their columns."""
    made = [[row[column.name] for column in CASE_COLUMNS] for row in rows]
    counts = [str(row["converged"]).partition("/") for row in rows]
    flags: list[Flag] = ["" if some == every else "warn" for some, _, every in counts]
    found = Table(f"Responses of {monitor}", CASE_COLUMNS, made, key="cases", flags=flags)
    return found.without_empty(*ASKED)


def case_row(found: Summary, numbers: Numbers = MappingProxyType({})) -> dict[str, Cell]:
    """The cells of a case; stress and damping where they are known.

    Damping and safety factor are withheld at the end of a range, where nothing resonates.
    """
    low, high, wave = found.lowest, found.highest, found.wave
    amplitude, frequency = place(found.peak)
    known: dict[str, Any] = {name: value for name, (value, _) in numbers.items()}
    resonates = found.peak is not None and not found.peak.at_edge
    return {
        "case": found.case,
        "harmonics": found.harmonics,
        "mu": found.mu,
        "peak_um": amplitude,
        "frequency_hz": frequency,
        "lowest_um": None if low is None else low.amplitude,
        "highest_um": None if high is None else high.amplitude,
        "wave": None if wave is None else wave.verdict,
        "growth": None if wave is None else wave.growth,
        "of_free": found.of_free,
        "of_stuck": found.of_stuck,
        "x": found.position,
        "damping": known.get("damping_ratio") if resonates else None,
        "work_uj": sum(found.work.values()) if found.peak is not None else None,
        "slipping_percent": found.slipping,
        "opening_percent": found.opening,
        "stress": known.get("alternating_stress"),
        "reserve": known.get("goodman_reserve") if resonates else None,
        "converged": f"{found.converged}/{found.points}",
        "seconds": found.seconds,
    }


def place(peak: Peak | None) -> tuple[float | None, float | None]:
    """Amplitude and frequency of a peak, if there is one."""
    return (None, None) if peak is None else (peak.amplitude, peak.frequency)


def _extremes(cases: Sequence[Summary]) -> list[Summary]:
    """Cases of the lowest and of the largest peaks, by height."""
    known = [(c.peak.amplitude, i) for i, c in enumerate(cases) if c.peak is not None]
    order = [cases[i] for _, i in sorted(known)]
    half = MOST_ROWS // 2
    return order if len(order) <= MOST_ROWS else [*order[:half], *order[-half:]]


def response_table(cases: Sequence[Summary], monitor: str, failed: int = 0) -> Table:
    """The same for a terminal: of many cases the extreme ones, with warnings."""
    shown = cases if len(cases) <= MOST_ROWS else _extremes(cases)
    notes = warnings.without_effect([(c.values, c) for c in cases])
    notes += warnings.by_text({c.case: c for c in cases}, str)
    if failed:
        text = f"{failed} of {len(cases) + failed} cases FAILED; the same command tries them again"
        notes.insert(0, text)
    notes = [f"warning: {note}" for note in notes]
    if len(shown) < len(cases):
        text = f"{len(shown)} of {len(cases)} cases: those of the lowest and the largest peaks"
        notes = [f"{text}; results.h5 and --json have all", *notes]
    return replace(case_table(list(map(case_row, shown)), monitor), notes=notes)
