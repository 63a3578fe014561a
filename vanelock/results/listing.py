"""Tables of what a run found, and the order in which the terminal has them."""

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from vanelock.common.tables import Cell, Column, Table, counted, heads
from vanelock.fem.matrix_files.model import GENERALISED
from vanelock.nonlinear import ELEMENT, OPEN, Response
from vanelock.pipeline.progress import Done, kind_of
from vanelock.pipeline.tasks import Failure
from vanelock.quantities import warnings
from vanelock.quantities.run_result import RunResult
from vanelock.render import wave_name
from vanelock.results.case_table import PEAK, place, response_table
from vanelock.rom import System
from vanelock.stages.accuracy.errors import error_table
from vanelock.stages.accuracy.left_out import left_out_table
from vanelock.stages.matrices.piece import Piece
from vanelock.stages.response.limits import SHOWN, Limits
from vanelock.stages.response.summary import Peak

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
        (which, *place(peak))
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
    yield response_table(run.summaries, run.monitor.name, len(run.failed))
