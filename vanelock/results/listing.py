"""Tables of what a run found."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from vanelock.fem.matrix_files.model import GENERALISED
from vanelock.nonlinear import OPEN, Response
from vanelock.pipeline.executor.tasks import Failure
from vanelock.pipeline.progress import Done
from vanelock.pipeline.tables import Cell, Column, Table
from vanelock.quantities import warnings
from vanelock.render import wave_name
from vanelock.rom import System
from vanelock.stages.matrices.piece import Piece
from vanelock.stages.response.gauges import Strain
from vanelock.stages.response.limits import SHOWN, Limits
from vanelock.stages.response.summary import Peak, Summary

MOST_ROWS = 40
"""Cases that a table prints."""
TOGETHER = {
    "preload": "preloads",
    "response": "responses",
    "figures": "pictures",
    "shapes": "pictures",
}
"""Stages that share a line of the table of times, by the first word of their names."""


def stage_times(done: Collection[Done]) -> Table:
    """Time of each kind of stage: in this run, and what it took when it was computed."""
    kinds: dict[str, list[Done]] = {}
    for each in done:
        word = each.stage.replace("/", " ").partition(" ")[0]
        kind = each.stage.partition(", ND")[0]
        kinds.setdefault(TOGETHER.get(word, kind), []).append(each)
    rows = []
    for kind, entries in kinds.items():
        now = [entry.seconds for entry in entries if not entry.cached]
        rows.append((kind, len(entries), len(now), sum(now), sum(e.seconds for e in entries)))
    number, new = sum(row[1] for row in rows), sum(row[2] for row in rows)
    rows.append(("total", number, new, sum(row[3] for row in rows), sum(row[4] for row in rows)))
    columns = (
        Column("stage", "stage"),
        Column("count", "number", "d"),
        Column("computed", "computed now", "d"),
        Column("seconds_now", "in [s]", ".1f"),
        Column("seconds", "all took [s]", ".1f"),
    )
    return Table("stages", "Stages", columns, tuple(rows))


def components_table(pieces: Sequence[Piece], system: System) -> Table:
    """Coordinates of each component of a scene, and of the system."""
    columns = (
        Column("component", "component"),
        Column("nodes", "nodes kept", "d"),
        Column("modes", "modes", "d"),
        Column("coordinates", "coordinates", "d"),
    )
    rows: list[tuple[Cell, ...]] = []
    for piece in pieces:
        physical = piece.direction < GENERALISED
        nodes, modal = len(np.unique(piece.node[physical])), int(np.sum(~physical))
        rows.append((piece.name, nodes, modal, piece.size))
    size = len(next(iter(system.diameters.values())).K)
    rows.append(("system", None, None, size))
    ks = ", ".join(map(str, sorted(system.diameters)))
    note = f"{system.contacts.count} contacts" + (
        f"; nodal diameters {ks} of {system.sectors} sectors" if system.sectors > 1 else ""
    )
    return Table("components", "Components", columns, tuple(rows), (note,))


def limits_table(name: str, limits: Limits) -> Table:
    """First frequencies with contacts free and stuck, and the mode of interest.

    Where no contacts open there is one limit. The error is the largest estimate among the
    frequencies shown, the mode of interest's included.
    """
    count = min(SHOWN, len(limits.free))
    columns = (
        Column("contacts", "contacts"),
        *(Column(f"f{i + 1}_hz", f"f{i + 1} [Hz]", ".6g") for i in range(count)),
        Column("mode", "mode of interest", "d"),
        Column("frequency_hz", "its f [Hz]", ".6g"),
        Column("rise_percent", "rise [%]", "+.4g"),
        Column("mac", "MAC", ".3f"),
        Column("error", "reduction error ~", ".0e"),
    )
    errors = [
        _known(float(error[: max(count, mode + 1)].max()))
        for error, mode in (
            (limits.free_error, limits.free_mode),
            (limits.stuck_error, limits.stuck_mode),
        )
    ]
    free = (limits.free_mode + 1, limits.free_frequency, None, None, errors[0])
    rise = _known(100 * limits.rise)
    stuck = (limits.stuck_mode + 1, limits.stuck_frequency, rise, limits.mac, errors[1])
    rows: list[tuple[Cell, ...]] = [("free", *limits.free[:count].tolist(), *free)]
    if limits.opens:
        rows.append(("stuck", *limits.stuck[:count].tolist(), *stuck))
    notes = warnings.alike(limits.mac)
    wave = f": modes of {wave_name(limits.nodal_diameter, limits.sectors)}"
    title = f"Linear limits{name and f', {name}'}{wave if limits.sectors > 1 else ''}"
    return Table("limits", title, columns, tuple(rows), tuple(notes))


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
    for joint in dict.fromkeys(joints):
        own = np.array([other == joint for other in joints])
        n = normal[own]
        pressed = own & (normal > 0)
        # What exceeds the bound is round-off, all of it where there is no friction.
        used = np.minimum(friction[pressed] / normal[pressed], mu[pressed])
        largest = float(used.max()) if len(used) else None
        rows.append(
            (
                joint,
                *(float(value) for value in (n.min(), n.mean(), n.max())),
                int((own & closed).sum()),
                int((own & ~closed).sum()),
                int((own & slid).sum()),
                largest,
                float(mu[own].max()),
            )
        )
    columns = (
        Column("joint", "joint"),
        Column("n_min", "n min [N]", ".4g"),
        Column("n_mean", "mean", ".4g"),
        Column("n_max", "max", ".4g"),
        Column("closed", "closed", "d"),
        Column("open", "open", "d"),
        Column("slipped", "slipped", "d"),
        Column("t_over_n", "largest |t|/n", ".3g"),
        Column("mu", "mu", ".3g"),
    )
    notes = []
    if not static.converged.all():
        notes.append(
            f"NOT CONVERGED: residual {static.residual.max():.1e}; do not use these forces"
        )
    return Table(
        "preload", f"Preload at rest{name and f', {name}'}", columns, tuple(rows), tuple(notes)
    )


def linear_table(peaks: Mapping[str, Peak | None], monitor: str, name: str) -> Table:
    """Linear peaks with contacts free and stuck, one line where the two are the same."""
    columns = (
        Column("contacts", "contacts"),
        Column("peak_um", "peak [um]", ".4g"),
        Column("frequency_hz", "at [Hz]", ".6g"),
    )
    rows = tuple(
        (which, 1e6 * peak.amplitude, peak.frequency) if peak else (which, None, None)
        for which, peak in peaks.items()
        if which == "free" or peak != peaks["free"]
    )
    title = f"Linear responses of {monitor}{name and f', {name}'}"
    return Table("linear", title, columns, rows)


def _extremes(cases: Sequence[Summary]) -> list[Summary]:
    """Cases of the lowest and of the largest peaks, by height."""
    known = [(c.peak.amplitude, i) for i, c in enumerate(cases) if c.peak is not None]
    order = [cases[i] for _, i in sorted(known)]
    return [*order[: MOST_ROWS // 2], *order[-MOST_ROWS // 2 :]]


def response_table(cases: Sequence[Summary], monitor: str) -> Table:
    """One line for each case."""
    known = any(c.mu is not None for c in cases)
    columns = (
        Column("case", "case"),
        Column("harmonics", "H", "d"),
        *([Column("mu", "mu", ".3g")] if known else []),
        Column("peak_um", "peak [um]", ".4g"),
        Column("frequency_hz", "at [Hz]", ".6g"),
        Column("of_free", "/ free", ".4g"),
        Column("of_stuck", "/ stuck", ".4g"),
        Column("x", "x", ".3g"),
        Column("slipping_percent", "slip [%]", ".0f"),
        Column("opening_percent", "open [%]", ".0f"),
        Column("work_uj", "work [uJ]", ".4g"),
        Column("converged", "converged"),
        Column("seconds", "s", ".1f"),
    )
    rows: list[tuple[Cell, ...]] = []
    shown = cases if len(cases) <= MOST_ROWS else _extremes(cases)
    for c in shown:
        found = (None, None) if c.peak is None else (1e6 * c.peak.amplitude, c.peak.frequency)
        rest = (c.of_free, c.of_stuck, c.position, 100 * c.slipping, 100 * c.opening)
        work = 1e6 * sum(c.work.values()) if c.peak is not None else None
        mu = (c.mu,) if known else ()
        done = f"{c.converged}/{c.points}"
        rows.append((c.case, c.harmonics, *mu, *found, *map(_known, rest), work, done, c.seconds))
    notes = [
        "/ free, / stuck: peak over the linear peaks; x: 0 at the free, 1 at the stuck frequency, "
        "- where the range holds none between; slip, open: contacts that rub, that lift off in a "
        "period at the peak (or both), of those that are open in the free limit; work: friction "
        "work of all contacts in a period there."
    ]
    if len(shown) < len(cases):
        notes.append(
            f"{len(shown)} of {len(cases)} cases: those of the lowest and the largest peaks; "
            "results.h5 and --json tell of all"
        )
    notes += warnings.without_effect([(c.values, c) for c in cases])
    notes += warnings.by_text({c.case: c for c in cases}, str)
    return Table("cases", f"Responses of {monitor}", columns, tuple(rows), tuple(notes))


def failed_table(failed: Mapping[str, Failure]) -> Table:
    """Cases of a sweep that could not be computed, and why."""
    columns = (
        Column("case", "case"),
        Column("attempts", "tried", "d"),
        Column("reason", "why it failed"),
    )
    rows = tuple((case, each.attempts, each.reason) for case, each in failed.items())
    notes = ("the same command tries them again",)
    return Table("failed", "FAILED cases", columns, rows, notes)


def gauge_table(strains: Mapping[str, tuple[Strain, Peak]]) -> Table:
    """Strain of each gauge at the peak of each case."""
    columns = (
        Column("case", "case"),
        Column("gauge", "gauge"),
        Column("amplitude", "amplitude [um/m]", ".4g"),
        Column("mean", "mean [um/m]", ".4g"),
        Column("frequency_hz", "at [Hz]", ".6g"),
    )
    rows = []
    for case, (strain, peak) in strains.items():
        amplitude, mean = 1e6 * strain.amplitude, 1e6 * strain.harmonics[:, 0].real
        for g, gauge in enumerate(strain.gauges.names):
            at_peak = float(amplitude[peak.point, g]), float(mean[peak.point, g])
            rows.append((case, gauge, *at_peak, peak.frequency))
    notes = ("at the peak of the monitored displacement; amplitude: half the peak-to-peak",)
    return Table("gauges", "Strain gauges", columns, tuple(rows), notes)


def _known(value: float) -> float | None:
    return None if np.isnan(value) else value
