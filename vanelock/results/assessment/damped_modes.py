"""Tables of damped modes: frequency and damping against amplitude, and flutter."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from vanelock.common.tables import Cell, Column, Flag, Table
from vanelock.nonlinear import LimitCycles
from vanelock.results.assessment.peaks import MOST
from vanelock.stages.assessment.assessed import Assessment
from vanelock.stages.assessment.damped_modes import FollowedMode


def damped_modes_table(assessments: Mapping[str, Assessment]) -> Table | None:
    """Each mode at rest, where it damps most and at its largest amplitude."""
    found = list(_every(assessments))
    if not any(each.mode for _, each in found):
        return None
    columns = (
        Column("case"),
        Column("ND", key="diameter", note="ND: nodal diameter, negative of a backward wave"),
        Column("mode"),
        Column("at rest", "Hz", ".6g", "rest_hz"),
        Column("damping", "%", ".3g", "rest_damping"),
        Column("most damping", "%", ".3g", "most_damping"),
        Column("at", "µm", ".4g", "most_um", note="at: amplitude of the monitored displacement"),
        Column("at", "Hz", ".6g", "most_hz"),
        Column("largest", "µm", ".4g", "end_um", note="largest: as far as the mode was followed"),
        Column("at", "Hz", ".6g", "end_hz"),
        Column("damping", "%", ".3g", "end_damping"),
        Column("points"),
        Column("not followed beyond", key="ended"),
    )
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for name, each in found:
        mode = each.mode
        if mode is None:
            rows.append((name, each.nodal_diameter, each.number, *[None] * 9, each.reason))
            flags.append("bad")
            continue
        size = mode.response.amplitude[:, each.node, each.component]
        most, last = int(np.argmax(mode.damping_ratio)), -1
        rows.append(
            (
                name,
                each.nodal_diameter,
                each.number,
                mode.linear[0],
                mode.linear[1],
                mode.damping_ratio[most],
                size[most],
                mode.frequency[most],
                size[last],
                mode.frequency[last],
                mode.damping_ratio[last],
                len(size),
                mode.ended or None,
            )
        )
        flags.append("warn" if mode.ended else "")
    title = "Damped modes: natural frequency and damping ratio against amplitude"
    notes = ["damping: of structure and friction, over the critical one; without the air"]
    made = Table(title, columns, rows, notes, "damped_modes", flags).without_empty("ended")
    return made.without("case") if len(assessments) == 1 else made


ALONE = "limit cycle: stable in its amplitude; waves of other nodal diameters are not looked at"


def flutter_table(assessments: Mapping[str, Assessment]) -> Table | None:
    """Each mode that the air acts on: whether it starts by itself, and where it settles."""
    found = [(name, each) for name, each in _every(assessments) if each.driven is not None]
    if not found:
        return None
    columns = (
        Column("case"),
        Column("ND", key="diameter"),
        Column("mode"),
        Column("damping by air", "%", ".3g", "air"),
        Column("in all", "%", ".3g", "total", note="in all: at small amplitudes, with structure"),
        Column("from rest", key="rest"),
        Column("limit cycle", "µm", ".4g", "cycle_um", note=ALONE),
        Column("at", "Hz", ".6g", "cycle_hz"),
        Column(
            "grows beyond",
            "µm",
            ".4g",
            "kick_um",
            note="grows beyond: a kick to more than this grows without end",
        ),
    )
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for name, each in found:
        driven = each.driven
        assert driven is not None
        cycle, kick = settles(each), grows_beyond(each)
        place = (None, None) if cycle is None else cycle
        rest = "grows" if driven.linear_damping < 0 else "decays"
        own = each.nodal_diameter, each.number
        air = driven.aerodynamic_damping, driven.linear_damping
        rows.append((name, *own, *air, rest, *place, kick))
        flags.append("bad" if kick == 0 else "warn" if rest == "grows" else "good")
    title = "Flutter: damping by the air, limit cycles and critical kicks"
    made = Table(title, columns, rows, (), "flutter", flags)
    made = made.without_empty("cycle_um", "cycle_hz", "kick_um")
    return made.without("case") if len(assessments) == 1 else made


def settles(mode: FollowedMode) -> tuple[float, float] | None:
    """Amplitude, m, and frequency, Hz, of the cycle at which a wave from rest settles."""
    driven = mode.driven
    if driven is None or not driven.amplitude_stable.any():
        return None
    first = int(np.argmax(driven.amplitude_stable))
    return float(_size(mode, driven)[first]), float(driven.frequency[first])


def grows_beyond(mode: FollowedMode) -> float | None:
    """Amplitude, m, from which vibration grows without end; None where none is known."""
    driven = mode.driven
    if driven is None or np.isinf(driven.critical_kick):
        return None
    return float(_size(mode, driven)[-1]) if len(driven.amplitude) else 0.0


def _size(mode: FollowedMode, driven: LimitCycles) -> NDArray[np.float64]:
    """(k,) amplitude of the monitored displacement, m."""
    return np.asarray(driven.output[:, mode.node, mode.component])


def _every(assessments: Mapping[str, Assessment]) -> Iterator[tuple[str, FollowedMode]]:
    """All followed modes of the first cases."""
    cases: Iterable[tuple[str, Assessment]] = islice(assessments.items(), MOST)
    return ((name, each) for name, found in cases for each in found.damped_modes)
