"""Table of wear over cycles: peak, preload and worn depth at some of the states."""

from collections.abc import Mapping, Sequence
from itertools import islice

from vanelock.common.tables import Cell, Column, Flag, Table
from vanelock.nonlinear import WearHistory
from vanelock.nonlinear.following.wear.wear_history import DONE
from vanelock.quantities.contacts.wear import HOUR
from vanelock.results.assessment.peaks import MOST
from vanelock.stages.assessment.assessed import Assessment
from vanelock.stages.assessment.wear import shown_states


def wear_table(
    assessments: Mapping[str, Assessment], reserves: Mapping[str, Sequence[float]] = {}
) -> Table | None:
    """Each case's vibration and preload from new to the end of its dwells.

    `reserves` has safety factors of the states shown, where they are known.
    """
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
        Column("HCF safety factor", form=".3g", key="reserve"),
        Column("", key="event"),
    )
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for name, each in islice(known.items(), MOST):
        hours, worn_depth = each.seconds / HOUR, each.worn
        shown = shown_states(each)
        safety: Sequence[float | None] = reserves.get(name) or [None] * len(shown)
        for i, reserve in zip(shown, safety, strict=True):
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
                    reserve,
                    event or None,
                )
            )
            flags.append("warn" if event else "")
    notes = [
        "at rest: total normal force of a joint in one sector; wear: depth that both surfaces "
        "lose together, of the contact that loses most",
    ]
    made = Table("Wear over cycles", columns, rows, notes, "wear", flags)
    made = made.without_empty("event", "reserve")
    if not any(each.dwell[-1] for each in known.values()):
        made = made.without("dwell")
    return made.without("case") if len(known) == 1 else made


def _event(history: WearHistory, i: int) -> str:
    """What happens at a state."""
    if i == len(history.cycles) - 1 and history.status != DONE:
        return str(history.status)
    return "jump" if history.jump[i] else ""
