"""Tables of what a run found, and the order in which the terminal has them.

The table of a run's cases: what is known of each, whatever it is read from.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from vanelock.common.tables import Cell, Column, Flag, Table, counted, heads
from vanelock.fem.matrix_files.model import GENERALISED
from vanelock.nonlinear import ELEMENT, OPEN, Response
from vanelock.pipeline.progress import Done, kind_of
from vanelock.pipeline.tasks import Failure
from vanelock.quantities import warnings
from vanelock.quantities.case_result import Numbers
from vanelock.quantities.run_result import RunResult
from vanelock.render import wave_name
from vanelock.rom import System
from vanelock.stages.accuracy.errors import error_table, left_out_table
from vanelock.stages.matrices.piece import Piece
from vanelock.stages.response.limits import SHOWN, Limits
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


def case_row(summary: Summary, numbers: Numbers = MappingProxyType({})) -> dict[str, Cell]:
    """The cells of a case; stress and damping where they are known.

    Damping and safety factor are withheld at the end of a range, where nothing resonates.
    """
    low, high, wave = summary.lowest, summary.highest, summary.wave
    amplitude, frequency = _place(summary.peak)
    known: dict[str, Any] = {name: value for name, (value, _) in numbers.items()}
    resonates = summary.peak is not None and not summary.peak.at_edge
    return {
        "case": summary.case,
        "harmonics": summary.harmonics,
        "mu": summary.mu,
        "peak_um": amplitude,
        "frequency_hz": frequency,
        "lowest_um": None if low is None else low.amplitude,
        "highest_um": None if high is None else high.amplitude,
        "wave": None if wave is None else wave.verdict,
        "growth": None if wave is None else wave.growth,
        "of_free": summary.of_free,
        "of_stuck": summary.of_stuck,
        "x": summary.position,
        "damping": known.get("damping_ratio") if resonates else None,
        "work_uj": sum(summary.work.values()) if summary.peak is not None else None,
        "slipping_percent": summary.slipping,
        "opening_percent": summary.opening,
        "stress": known.get("alternating_stress"),
        "reserve": known.get("goodman_reserve") if resonates else None,
        "converged": f"{summary.converged}/{summary.points}",
        "seconds": summary.seconds,
    }


def _place(peak: Peak | None) -> tuple[float | None, float | None]:
    """Amplitude and frequency of a peak, if there is one."""
    return (None, None) if peak is None else (peak.amplitude, peak.frequency)


def _extremes(cases: Sequence[Summary]) -> list[Summary]:
    """Cases of the lowest and of the largest peaks, by height."""
    known = [(c.peak.amplitude, i) for i, c in enumerate(cases) if c.peak is not None]
    order = [cases[i] for _, i in sorted(known)]
    half = MOST_ROWS // 2
    return order if len(order) <= MOST_ROWS else [*order[:half], *order[-half:]]


def _response_table(cases: Sequence[Summary], monitor: str, failed: int = 0) -> Table:
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


CORRECTED = (
    "mesh correction: subtracted, the estimate of how much the finite meshes raise the frequency; "
    "a quarter of it is its uncertainty"
)


def stage_times(done: Collection[Done]) -> Table:
    """Time of each kind of stage: in this run, and what it took when it was computed."""
    kinds: dict[str, list[Done]] = {}
    for each in done:
        kinds.setdefault(kind_of(each.stage), []).append(each)
    rows = []
    for kind, entries in kinds.items():
        now = [entry.seconds for entry in entries if not entry.cached]
        rows.append((kind, len(entries), len(now), sum(now), sum(e.seconds for e in entries)))
    number, new = sum(row[1] for row in rows), sum(row[2] for row in rows)
    rows.append(("total", number, new, sum(row[3] for row in rows), sum(row[4] for row in rows)))
    columns = (
        Column("stage"),
        Column("number", key="count"),
        Column("computed now", key="computed"),
        Column("in", "s", ".1f", "seconds_now"),
        Column("took", "s", ".1f", "seconds"),
    )
    return Table("Stages", columns, rows, key="stages")


def components_table(pieces: Sequence[Piece], system: System) -> Table:
    """Coordinates of each component of a scene, and of the system."""
    columns = (
        Column("component"),
        Column("nodes kept", key="nodes"),
        Column("modes"),
        Column("coordinates"),
    )
    rows: list[tuple[Cell, ...]] = []
    for piece in pieces:
        physical = piece.direction < GENERALISED
        nodes, modal = len(np.unique(piece.node[physical])), int(np.sum(~physical))
        rows.append((piece.name, nodes, modal, piece.size))
    size = len(next(iter(system.diameters.values())).K)
    rows.append(("system", None, None, size))
    ks = ", ".join(map(str, sorted(system.diameters)))
    note = counted(system.contacts.count, "contact") + (
        f"; nodal diameters {ks} of {system.sectors} sectors" if system.sectors > 1 else ""
    )
    return Table("Components", columns, rows, (note,), "components")


def limits_table(sets: Mapping[str, Limits]) -> Table:
    """First frequencies with contacts free and stuck, and the mode of interest, by name.

    Where no contacts open there is one limit. The error is the largest estimate among the
    frequencies shown, the mode of interest's included.
    """
    name, limits = next(iter(sets.items()))
    count = min(SHOWN, len(limits.free))
    corrected = not all(np.isnan(each.stuck_lowered) for each in sets.values())
    columns = (
        *(heads("cases") if len(sets) > 1 else ()),
        Column("contacts"),
        Column("mode of interest", key="mode"),
        Column("frequency", "Hz", ".6g", "frequency_hz"),
        Column("frequency shift", "%", "+.4g", "rise_percent"),
        Column("MAC", form=".3f", key="mac"),
        Column("damping ratio", "%", ".3g", "damping_percent"),
        Column("reduction error", form=".0e", key="error"),
        *((Column("mesh correction", "%", ".3g", "mesh_percent"),) if corrected else ()),
        *(Column(f"f{i + 1}", "Hz", ".6g", f"f{i + 1}_hz") for i in range(count)),
    )
    rows: list[tuple[Cell, ...]] = []
    for of, each in sets.items():
        free = each.free_mode, each.free_frequency, None, None, each.free_damping
        stuck = each.stuck_mode, each.stuck_frequency, each.rise, each.mac, each.stuck_damping
        both = (
            ("free", each.free, *free, each.free_error, each.free_lowered),
            ("stuck", each.stuck, *stuck, each.stuck_error, each.stuck_lowered),
        )
        for which, hertz, mode, *rest, error, lowered in both[: 1 + each.opens]:
            worst = error[: max(count, mode + 1)].max()
            own = (of or "all",) if len(sets) > 1 else ()
            off = (lowered,) if corrected else ()
            rows.append((*own, which, mode + 1, *rest, worst, *off, *hertz[:count]))
    notes = dict.fromkeys(note for each in sets.values() for note in warnings.alike(each.mac))
    if corrected:
        notes[CORRECTED] = None
    wave = f": modes of {wave_name(limits.nodal_diameter, limits.sectors)}"
    case = f", {name}" if name and len(sets) == 1 else ""
    title = f"Linear limits{case}{wave if limits.sectors > 1 else ''}"
    return Table(title, columns, rows, tuple(notes), "limits")


def preload_table(name: str, joints: Sequence[str], static: Response) -> Table:
    """Normal forces at rest by joint, and how much of the friction bound is used.

    Open contacts have no force; what the solver leaves there is round-off.
    """
    mu, closed = static.mu, static.state[0] != OPEN
    force = np.where(closed[:, None], static.force[0, 0].real, 0.0)
    normal, both = force[:, 0], np.abs(force[:, 1:])
    friction = np.hypot(*both.T) if static.friction == "isotropic" else both.max(axis=1)
    slid = closed & (friction >= mu * normal * (1 - 1e-9))
    rows = []
    touching = dict(zip(joints, static.state[0] != ELEMENT, strict=True))
    for joint in (name for name, touches in touching.items() if touches):
        own = np.array([other == joint for other in joints])
        n = normal[own]
        pressed = own & (normal > 0)
        # What exceeds the bound is round-off, all of it where there is no friction.
        used = np.minimum(friction[pressed] / normal[pressed], mu[pressed])
        largest = used.max() if len(used) else None
        counts = (int(np.sum(own & each)) for each in (closed, ~closed, slid))
        rows.append((joint, n.min(), n.mean(), n.max(), *counts, largest, mu[own].max()))
    columns = (
        Column("joint"),
        Column("n min", "N", ".4g", "n_min", note="n, t: normal and friction force of a contact"),
        Column("n mean", "N", ".4g", "n_mean"),
        Column("n max", "N", ".4g", "n_max"),
        *heads("closed", "open", "slipped"),
        Column("|t|/n max", form=".3g", key="t_over_n"),
        Column("μ", form=".3g", key="mu"),
    )
    notes = []
    if not static.converged.all():
        notes.append(
            f"NOT CONVERGED: residual {static.residual.max():.1e}; do not use these forces"
        )
    return Table(f"Preload at rest{name and f', {name}'}", columns, rows, notes, "preload")


def linear_table(peaks: Mapping[str, Peak | None], monitor: str, name: str) -> Table:
    """Linear peaks with contacts free and stuck, one line where the two are the same."""
    columns = (Column("contacts"), *PEAK)
    rows = [
        (which, *_place(peak))
        for which, peak in peaks.items()
        if which == "free" or peak != peaks["free"]
    ]
    title = f"Linear responses of {monitor}{name and f', {name}'}"
    return Table(title, columns, rows, key="linear")


def _failed_table(failed: Mapping[str, Failure]) -> Table:
    """Cases of a sweep that could not be computed, and why."""
    columns = (
        Column("case"),
        Column("tried", key="attempts"),
        Column("why it failed", key="reason"),
    )
    rows = [(case, each.attempts, each.reason) for case, each in failed.items()]
    return Table("FAILED cases", columns, rows, ("the same command tries them again",), "failed")


def tables(run: RunResult) -> Iterator[Table]:
    """What analyses and estimates say, what failed, and the responses."""
    for analysis in run.analyses:
        yield from analysis.tables(run.cases)
    for name, (errors, without) in run.errors.items():
        yield error_table(name, errors, run.monitor.name)
        yield left_out_table(name, without)
    for analysis in run.analyses:
        yield from analysis.run_tables(run)
    if run.shapes and "mesh_error" in run.first.products:
        yield run.first.products.get("mesh_error").table
    if run.failed:
        yield _failed_table(run.failed)
    yield _response_table(run.summaries, run.monitor.name, len(run.failed))
