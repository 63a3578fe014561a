"""The tables that a scene's run prints."""

from collections.abc import Mapping, Sequence

import numpy as np

from vanelock.fem.matrix_files.model import GENERALISED
from vanelock.pipeline.tables import Cell, Column, Table
from vanelock.quantities import warnings
from vanelock.rom import System
from vanelock.stages.response.summary import Peak
from vanelock.stages.scene.modes import SHOWN, SceneModes
from vanelock.stages.scene.monitor import Found
from vanelock.stages.scene.piece import Piece

LOOSE = (
    "at rest a part is held by no closed contact: where it lies, and so its response, is "
    "NOT DETERMINED"
)
"""What is to be known where nothing presses a loose part."""


def components_table(pieces: Sequence[Piece], system: System) -> Table:
    """Coordinates of each component, and of the system."""
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


def modes_table(name: str, found: SceneModes, peaks: Mapping[str, Peak | None]) -> Table:
    """First frequencies with contacts open and stuck, and the linear peaks."""
    count = min(SHOWN, len(found.free))
    columns = (
        Column("contacts", "contacts"),
        *(Column(f"f{i + 1}_hz", f"f{i + 1} [Hz]", ".6g") for i in range(count)),
        Column("mode", "mode of interest", "d"),
        Column("peak_um", "linear peak [um]", ".4g"),
        Column("at_hz", "at [Hz]", ".6g"),
    )
    rows: list[tuple[Cell, ...]] = []
    limits = (
        ("open", "free", found.free, found.free_mode),
        ("stuck", "stuck", found.stuck, found.stuck_mode),
    )
    for word, which, own, mode in limits:
        peak = peaks[which]
        height = (None, None) if peak is None else (1e6 * peak.amplitude, peak.frequency)
        rows.append((word, *own[:count].tolist(), mode + 1, *height))
    notes = [f"the two modes of interest are alike by MAC {found.mac:.3f}"]
    if any(peaks[which] is None for which in ("free", "stuck")):
        notes.append("no linear peak where its frequency is out of the range")
    notes += warnings.alike(found.mac)
    title = f"Linear limits{name and f', {name}'}"
    return Table("limits", title, columns, tuple(rows), tuple(notes))


def cases_table(cases: Sequence[Found], monitor: str) -> Table:
    """One line for each case."""
    columns = (
        Column("case", "case"),
        Column("peak_um", "peak [um]", ".4g"),
        Column("frequency_hz", "at [Hz]", ".6g"),
        Column("of_free", "/ open", ".4g"),
        Column("of_stuck", "/ stuck", ".4g"),
        Column("slipping_percent", "slip [%]", ".0f"),
        Column("opening_percent", "open [%]", ".0f"),
        Column("work_uj", "friction work [uJ]", ".4g"),
        Column("converged", "converged"),
        Column("seconds", "s", ".1f"),
    )
    rows: list[tuple[Cell, ...]] = []
    notes = [
        "/ open, / stuck: peak over the linear peaks; slip, open: contacts that rub, that lift off "
        "in a period at the peak; work: of all contacts in a period there."
    ]
    for c in cases:
        top = (None, None) if c.peak is None else (1e6 * c.peak.amplitude, c.peak.frequency)
        shares = [_known(v) for v in (c.of_free, c.of_stuck, 100 * c.slipping, 100 * c.opening)]
        work = 1e6 * sum(c.work.values()) if c.peak is not None else None
        done = f"{c.converged}/{c.points}"
        rows.append((c.case.name, *top, *shares, work, done, c.seconds))
    notes += warnings.without_effect([(c.case.values, c) for c in cases])
    notes += warnings.by_text({c.case.name: c for c in cases}, str)
    return Table("cases", f"Responses of {monitor}", columns, tuple(rows), tuple(notes))


def _known(value: float) -> float | None:
    return None if np.isnan(value) else value
