"""Wear over cycles: the joints of a case wear while the engine dwells, and its vibration changes.

Archard's law takes a depth off the interference of each contact; see `nonlinear.wear_history`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BeforeValidator, Discriminator, Field, Tag

from vanelock import nonlinear, render, report
from vanelock.analyses.analysis import Analysis, AnalysisPart, products_of
from vanelock.common.checked import OTHER, PLAIN
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.common.tables import Cell, Column, Flag, Table, by_case
from vanelock.input.cases.names import of_case, slug
from vanelock.input.schema.comparison import FrequencyRange, Hertz
from vanelock.input.schema.structure.structure import KeyTable, sequence

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, Problem, RunResult, SolvedCase, State
    from vanelock.nonlinear import Dwell, WearHistory

SHOWN = 8
"""States of a history in a table, about."""
SAME = 1e-3
"""Relative change of a load at rest from which it is worth a word."""
TEXT = (
    "The depth that Archard's law takes off both surfaces of a contact is taken off its "
    "interference; the vibration of every cycle is that of the contacts as worn, settled. Preload "
    "falls, so that joints slip more, wear more or damp less."
)


HeldOrRange = Annotated[
    Annotated[Hertz, Tag(PLAIN)] | Annotated[FrequencyRange, Tag(OTHER)],
    Discriminator(lambda value: OTHER if isinstance(value, list | tuple) else PLAIN),
]
"""A frequency that is held, Hz, or the range of a peak."""


class _DwellKeys(KeyTable):
    """Vibration that stays at a frequency, or at the peak of a range wherever that moves."""

    cycles: float = Field(gt=0, le=1e15, description="number of cycles")
    frequency: HeldOrRange | None = Field(default=None, description="frequency [Hz]")
    load: float = Field(default=1.0, gt=0, le=1e6, description="load over that of the study")

    def dwell(self, ends: tuple[float, float]) -> "Dwell":
        """The same for the solver; without a frequency held at the peak of its range."""
        if isinstance(self.frequency, float):
            return nonlinear.Dwell(self.cycles, frequency=self.frequency, force=self.load)
        low, high = self.frequency or ends
        return nonlinear.Dwell(self.cycles, near=(low, high), force=self.load)


class _WearKeys(KeyTable):
    """How contacts wear over cycles, and how the vibration changes with them."""

    dwells: Annotated[tuple[_DwellKeys, ...], BeforeValidator(sequence)] = Field(
        min_length=1, max_length=1000, description="dwells"
    )


@dataclass(frozen=True)
class WornCase(Product):
    """Wear of a case over cycles; without a history, why there is none.

    Attributes
    ----------
    history : WearHistory or None
    reason : str
    """

    history: "nonlinear.WearHistory | None" = None
    reason: str = ""


def _check(problem: "Problem", keys: _WearKeys) -> Iterator[str]:
    """What keeps joints from wearing."""
    if not _coefficients(problem):
        names = ", ".join(f"joints.{name}.wear_coefficient" for name in problem.joint_names)
        yield f"wear: no joint wears: give one of {names}"


def _coefficients(problem: "Problem") -> dict[str, float]:
    """Of the joints that wear, m²/N."""
    return getattr(problem, "wear_coefficients", {})


def _compute(case: "SolvedCase", keys: _WearKeys, part: AnalysisPart) -> WornCase:
    """Wear of a case over the cycles of its dwells."""
    if case.peak is None:
        return WornCase(reason="no point converged")
    system, watched, places = case.system, case.monitored, case.places
    coefficient = np.nan_to_num(places.coefficient)
    if not np.isfinite(places.area[coefficient > 0]).all():
        return WornCase(reason="the area of some contacts is not known")
    reached = 0

    def progress(cycles: float, total: float, hertz: float, amplitude: float) -> None:
        nonlocal reached
        reached = max(reached, int(100 * cycles / total))
        case.count(reached, 100, amplitude)

    try:
        history = nonlinear.wear_history(
            system,
            [each.dwell(case.range) for each in keys.dwells],
            coefficient,
            np.where(coefficient > 0, places.area, 1.0),
            case.options,
            (system.output_names[watched.node], watched.component),
            progress=progress,
        )
    except InputError as error:
        return WornCase(reason=str(error))
    return WornCase(history)


def _shown_states(history: "WearHistory") -> list[int]:
    """States of a history that tables show: both ends of each dwell, jumps, some between."""
    last = len(history.cycles) - 1
    even = np.interp(np.linspace(0, history.cycles[-1], SHOWN), history.cycles, np.arange(last + 1))
    ends = np.flatnonzero(np.diff(history.dwell))
    jumps = np.flatnonzero(history.jump)[:SHOWN]
    every = (np.round(even).astype(int), ends, ends + 1, jumps)
    return sorted(set(np.concatenate(every).tolist()))


def _states(case: "CaseResult") -> "Iterator[State]":
    """The case as worn at the states shown, with the vibration there as its only point."""
    from vanelock.quantities.case_result import State
    from vanelock.stages.response.summary import Peak

    (worn,) = case.found("wear")
    if (history := worn.history) is None:
        return
    for at in _shown_states(history):
        frequency, amplitude = history.frequency[[at]], history.amplitude[[at]]
        peak = Peak(0, float(frequency[0]), float(amplitude[0]), at_edge=False)
        curve = frequency, amplitude, np.array([True])
        yield State(history.response.at([at]), peak, curve)


def _warnings(case: "CaseResult", products: Sequence[WornCase]) -> Iterator[str]:
    """What keeps wear over cycles from being taken as it is."""
    (worn,) = products
    if (history := worn.history) is None:
        yield f"no wear over cycles: {worn.reason}"
        return
    if np.isfinite(history.cycles_to_loss):
        yield f"wear opens a joint at rest after {history.cycles_to_loss:.3g} cycles"
    elif not _done(history):
        at = f"{history.cycles[-1]:.3g} cycles"
        yield f"wear is known up to {at} only: no vibration was found beyond"
    if history.jump.any():
        at = ", ".join(f"{each:.3g}" for each in history.cycles[history.jump][:3])
        yield f"the vibration JUMPS while joints wear, at {at} cycles"
    for i in np.flatnonzero(np.isfinite(history.higher_amplitude)):
        higher, followed = 1e6 * history.higher_amplitude[i], 1e6 * history.amplitude[i]
        yield (
            f"after {history.cycles[i]:.3g} cycles of wear ANOTHER PEAK is higher, {higher:.4g} um "
            f"at {history.higher_frequency[i]:.6g} Hz, than the one that was followed, "
            f"{followed:.4g} um"
        )


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """Each case's vibration and preload from new to the end of its dwells."""
    from vanelock.quantities.contacts import HOUR

    every, count = products_of(cases, "wear")
    known = {name: worn.history for name, (worn,) in every.items() if worn.history is not None}
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
    for name, history in known.items():
        shown = _shown_states(history)
        safety: Sequence[float | None] = _reserves(cases[name]) or [None] * len(shown)
        for i, reserve in zip(shown, safety, strict=True):
            loads = dict(zip(history.joints, history.rest_load[i].tolist(), strict=True))
            event, hours = "jump" if history.jump[i] else "", history.seconds[i] / HOUR
            if i == len(history.cycles) - 1 and not _done(history):
                event = str(history.status)
            peak = history.amplitude[i], history.frequency[i]
            ends = history.worn[i].max(), reserve, event or None
            begins = name, int(history.dwell[i]) + 1, history.cycles[i], hours
            rows.append((*begins, *peak, *map(loads.get, joints), *ends))
            flags.append("warn" if event else "")
    note = (
        "at rest: total normal force of a joint in one sector; wear: depth that both surfaces "
        "lose together, of the contact that loses most"
    )
    made = Table("Wear over cycles", columns, rows, [note], "wear", flags)
    made = made.without_empty("event", "reserve")
    if not any(history.dwell[-1] for history in known.values()):
        made = made.without("dwell")
    yield from by_case(made, count)


def _done(history: "WearHistory") -> bool:
    """Whether it reaches the end of its dwells."""
    from vanelock.nonlinear.wear.wear_history import DONE

    return bool(history.status == DONE)


def _reserves(case: "CaseResult") -> list[float]:
    """Safety factors of the states shown, where they are known."""
    states = case.states(WEAR) if case.detailed else ()
    return [each.stress.governing.reserve for each in states if each.margins]


def _answers(case: "CaseResult") -> "Iterator[report.Answer]":
    """What becomes of the case while its joints wear."""
    for history in (worn.history for worn in case.found("wear") if worn.history is not None):
        loads = [
            f"{joint} at rest {new:.3g} → {last:.3g} N"
            for joint, new, last in zip(history.joints, *history.rest_load[[0, -1]], strict=True)
            if abs(last - new) > SAME * new
        ]
        size = 1e6 * history.amplitude
        top = int(size.argmax())
        texts = [f"largest amplitude, at {history.cycles[top]:.3g}; {size[0]:.3g} µm when new"]
        texts += loads
        if reserves := _reserves(case):
            texts.append(f"least HCF safety factor n = {min(reserves):.3g}")
        done = _done(history)
        if not done:
            texts.append(f"**{history.status}**, so that it ends there")
        title = f"Over {history.cycles[-1]:.3g} cycles of wear"
        yield report.Answer(title, f"{size[top]:.3g} µm", "; ".join(texts), "" if done else "warn")


def _pictures(run: "RunResult", case: "CaseResult") -> "Iterator[report.Picture]":
    """Amplitude, preload and worn depth over the cycles of the dwells."""
    from vanelock.quantities.contacts import HOUR

    (worn,), name = case.found("wear"), case.name
    if (history := worn.history) is None:
        return
    title = f"Wear over cycles{of_case(name)}"
    ended = "" if _done(history) else f"; {history.status} at the end"
    subtitle = f"{case.monitor.name}{ended}"
    depth, wears = 1e6 * history.worn, history.worn[-1] > 0
    mean = depth[:, wears].mean(axis=1) if wears.any() else depth[:, 0]

    def curve(name: str, y: ArrayLike) -> render.PanelCurve:
        return render.PanelCurve(name, history.cycles, y)

    loads = zip(history.joints, history.rest_load.T, strict=True)
    panels = (
        render.CurvePanel("amplitude (µm)", [curve("all", 1e6 * history.amplitude)]),
        render.CurvePanel("load at rest, relative", [curve(j, n / n[0]) for j, n in loads if n[0]]),
        render.CurvePanel(
            "worn depth (µm)",
            [curve("deepest", depth.max(axis=1)), curve("mean", mean)],
            from_zero=True,
        ),
    )
    changes = history.cycles[1:][np.diff(history.dwell) > 0]
    caption = (
        f"Wear{of_case(name)}: the amplitude of the dwell, each joint's load at rest over that "
        "when new, and the depth that both surfaces have lost, of the contact that loses most and "
        "on average over those that wear."
    ) + (" Dotted: where the next dwell begins." if len(changes) else "")
    columns = {
        "cycles": history.cycles,
        "time (h)": history.seconds / HOUR,
        "dwell": history.dwell + 1,
        "frequency (Hz)": history.frequency,
        "amplitude (µm)": 1e6 * history.amplitude,
        "jump": history.jump,
        **{
            f"{joint} at rest (N)": load
            for joint, load in zip(history.joints, history.rest_load.T, strict=True)
        },
        "deepest wear (µm)": depth.max(axis=1),
    }
    yield run.picture(
        f"figures/wear_over_cycles_{slug(name)}",
        "Wear over cycles",
        [*case.key_of("wear"), title, subtitle],
        lambda path: render.panels_picture(path, panels, "cycles", title, subtitle, marks=changes),
        lambda: columns,
        [title],
        caption,
    )


TEMPLATE = """\
# What the joints with a wear coefficient lose while the engine dwells, and how the vibration
# changes with it. See `vanelock manual fatigue_and_wear`.
# [wear]
# dwells = [{ cycles = 1e8 }]   # one after another: at the peak of response.range, or of their own
                                # frequency = [240, 260], or held at one; at a load over the study's
"""

WEAR = Analysis(
    key="wear",
    title="wear over cycles",
    keys=_WearKeys,
    product=lambda: WornCase,
    compute=_compute,
    parts=lambda problem, keys: (AnalysisPart(inputs=_coefficients(problem)),),
    check=_check,
    cost=lambda study, keys, curve: len(keys.dwells) * curve,  # a sweep, and some peaks
    states=_states,
    state="worn, after all cycles",
    reserve="goodman_reserve_worn",
    warnings=_warnings,
    tables=_tables,
    pictures=_pictures,
    answers=_answers,
    text=TEXT,
    template=TEMPLATE,
)
