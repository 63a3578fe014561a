"""Table of wear over cycles: peak, preload and worn depth at some of the states."""

from collections.abc import Mapping
from itertools import islice

import numpy as np

from vanelock.common.tables import Cell, Column, Flag, Table
from vanelock.nonlinear import WearHistory
from vanelock.results.assessment.peaks import MOST
from vanelock.stages.assessment.assessed import Assessment

SHOWN = 8
"""States of a case in the table, about."""
HOUR = 3600.0


def wear_table(assessments: Mapping[str, Assessment]) -> Table | None:
    """Each case's vibration and preload from new to the end of its dwells."""
    worn = {name: each.wear for name, each in assessments.items() if each.wear is not None}
    known = {name: each.history for name, each in worn.items() if each.history is not None}
    if not known:
        return None
    joints = list(dict.fromkeys(joint for each in known.values() for joint in each.joints))
    columns = (
        Column("case"),
        Column("dwell"),
        Column("cycles", form=".4g"),
        Column("time", "h", ".4g", "hours"),
        Column("amplitude", "µm", key="amplitude_um"),
        Column("at", "Hz", ".6g", "frequency_hz"),
        *(Column(f"{joint} at rest", "N", ".4g", f"{joint}_rest_n") for joint in joints),
        Column("deepest wear", "µm", ".3g", "worn_um"),
        Column("", key="event"),
    )
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for name, each in islice(known.items(), MOST):
        hours, worn_depth = each.seconds / HOUR, (each.interference[0] - each.interference)
        for i in shown_states(each):
            own = dict(zip(each.joints, each.rest_load[i].tolist(), strict=True))
            event = _event(each, i)
            rows.append(
                (
                    name,
                    int(each.dwell[i]) + 1,
                    each.cycles[i],
                    hours[i],
                    each.amplitude[i],
                    each.frequency[i],
                    *(own.get(joint) for joint in joints),
                    float(worn_depth[i].max()),
                    event or None,
                )
            )
            flags.append("warn" if event else "")
    notes = [
        "at rest: total normal force of a joint in one sector; wear: depth that both surfaces "
        "lose together, of the contact that loses most",
    ]
    made = Table("Wear over cycles", columns, rows, notes, "wear", flags).without_empty("event")
    made = (
        made
        if max(row[1] for row in rows if isinstance(row[1], int)) > 1
        else made.without("dwell")
    )
    return made.without("case") if len(known) == 1 else made


def shown_states(history: WearHistory) -> list[int]:
    """States of a history that a table shows: both ends of each dwell, jumps, some between."""
    last = len(history.cycles) - 1
    even = np.interp(np.linspace(0, history.cycles[-1], SHOWN), history.cycles, np.arange(last + 1))
    ends = np.flatnonzero(np.diff(history.dwell))
    jumps = np.flatnonzero(history.jump)[:SHOWN]
    every = (np.round(even).astype(int), ends, ends + 1, jumps)
    return sorted(set(np.concatenate(every).tolist()))


def _event(history: WearHistory, i: int) -> str:
    """What happens at a state."""
    if i == len(history.cycles) - 1 and history.status != "cycles done":
        return str(history.status)
    return "jump" if history.jump[i] else ""
