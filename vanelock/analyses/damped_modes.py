"""Damped nonlinear modes of a case, and where the air keeps them going (flutter).

Natural frequency and damping ratio against amplitude, from stuck to gross slip, by the extended
periodic motion concept: `nonlinear.damped_mode`, `nonlinear.limit_cycles`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, ClassVar
from warnings import catch_warnings

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BeforeValidator, Field

from vanelock import nonlinear, render, report
from vanelock.analyses.analysis import Analysis, AnalysisPart, products_of
from vanelock.common.arrays import Floats
from vanelock.common.checked import Check
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.common.tables import Cell, Column, Flag, Table, by_case
from vanelock.input.cases.names import of_case, slug
from vanelock.input.schema.structure.structure import KeyTable, sequence

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, Problem, RunResult, SolvedCase

BEGIN = 1e-3
"""Least amplitude drawn, of the largest: below it nothing changes."""
ALONE = "limit cycle: stable in its amplitude; waves of other nodal diameters are not looked at"
TEXT = (
    "With friction a natural frequency and its damping ratio depend on the amplitude: contacts "
    "stick, slip and open. Each mode is the periodic motion that a force along its velocity keeps "
    "up against all damping (extended periodic motion concept), all harmonics and the mean "
    "included, without excitation. Where aerodynamic influence coefficients are given, the air's "
    "work in a cycle is theirs, in travelling waves of each nodal diameter, on the fundamental of "
    "one mode whose shape it does not change. Where it equals what structure and friction take, "
    "the ring vibrates by itself: it returns to a **limit cycle** after a small change; a kick "
    "beyond the last amplitude grows without end."
)

Number = Annotated[int, Field(ge=1, le=40, description="number of a mode")]
Diameter = Annotated[int, Field(ge=-500, le=500, description="nodal diameter")]
Coefficient = Annotated[
    tuple[
        Annotated[int, Field(ge=-500, le=500, description="segment")],
        Annotated[float, Field(description="real part of an influence coefficient [1/s^2]")],
        Annotated[float, Field(description="imaginary part of an influence coefficient [1/s^2]")],
    ],
    BeforeValidator(sequence),
]


class ModeKeys(KeyTable):
    """Natural frequency and damping ratio against amplitude, from stuck to gross slip."""

    modes: Annotated[tuple[Number, ...], BeforeValidator(sequence)] | None = Field(
        default=None, min_length=1, max_length=40, description="modes"
    )
    nodal_diameters: Annotated[tuple[Diameter, ...], BeforeValidator(sequence)] | None = Field(
        default=None, min_length=1, max_length=1000, description="nodal diameters"
    )
    influence: Annotated[tuple[Coefficient, ...], BeforeValidator(sequence)] | None = Field(
        default=None,
        min_length=1,
        max_length=1000,
        description="aerodynamic influence coefficients",
    )

    def _distinct(self) -> Iterator[str]:
        for name in ("modes", "nodal_diameters"):
            given = getattr(self, name)
            if given is not None and len(set(given)) < len(given):
                yield f"{name} = {list(given)}: must differ from each other"

    checks: ClassVar[tuple[Check, ...]] = (_distinct,)

    @property
    def air(self) -> dict[int, complex] | None:
        """Influence coefficients by segment, 1/s²; None where none are given."""
        given = self.influence
        return None if given is None else {m: complex(real, im) for m, real, im in given}


@dataclass(frozen=True)
class NumberedMode(Product):
    """A mode of a nodal diameter.

    Attributes
    ----------
    number, nodal_diameter : int
        The mode's, from 1, and that of its wave, -N/2 to N/2.
    """

    number: int
    nodal_diameter: int

    @property
    def name(self) -> str:
        """What legends call it."""
        return f"mode {self.number}, ND {self.nodal_diameter}"

    @property
    def place(self) -> str:
        """Where it is in the results of an analysis."""
        return f"mode_{self.number}_nd_{self.nodal_diameter}"

    @property
    def cells(self) -> tuple[int, int]:
        """What tables begin with."""
        return self.nodal_diameter, self.number


HEADS = (
    Column("case"),
    Column("ND", key="diameter", note="ND: nodal diameter, negative of a backward wave"),
    Column("mode"),
)
"""Of the columns that tables of modes begin with."""


def mode_columns(modes: Sequence[NumberedMode], counts: Sequence[int]) -> dict[str, ArrayLike]:
    """What files of modes begin with, each mode so many times."""
    diameter, number = np.repeat(np.array([each.cells for each in modes]), counts, axis=0).T
    return {"nodal diameter": diameter, "mode": number}


@dataclass(frozen=True)
class FollowedMode(NumberedMode):
    """A damped mode of a case; without one, why there is none.

    Attributes
    ----------
    node, component : int
        The monitored displacement among the outputs.
    alone : DampedMode or None
        Where no air is given.
    driven : LimitCycles or None
        Where it is; `mode` is the same without it.
    reason : str
    """

    node: int
    component: int
    alone: "nonlinear.DampedMode | None" = None
    driven: "nonlinear.LimitCycles | None" = None
    reason: str = ""

    @property
    def mode(self) -> "nonlinear.DampedMode | None":
        """The mode without the air."""
        return self.alone if self.driven is None else self.driven.mode

    @property
    def amplitude(self) -> Floats:
        """(p,) the monitored displacement of a mode that was followed, m."""
        assert self.mode is not None
        return np.asarray(self.mode.response.amplitude[:, self.node, self.component])

    @property
    def cycles(self) -> Floats:
        """(k,) the monitored displacement at which the air's work is taken in all, m."""
        if self.driven is None:
            return np.empty(0)
        return np.asarray(self.driven.output[:, self.node, self.component])


def _check(problem: "Problem", keys: ModeKeys) -> Iterator[str]:
    """What keeps modes from being of the ring."""
    if getattr(problem, "system", None) is not None:  # whose file says how many segments
        return
    N = problem.ring.sectors
    for k in keys.nodal_diameters or ():
        if 2 * abs(k) > N:
            allowed = f"of {N} segments allowed are {-(N // 2)} to {N // 2}"
            yield f"damped_modes.nodal_diameters: given {k}: {allowed}"
    segments = [m % N for m, *_ in keys.influence or ()]
    if len(set(segments)) < len(segments):
        yield f"damped_modes.influence: of {N} segments one is given twice"


def parts(problem: "Problem", keys: ModeKeys) -> Sequence[AnalysisPart]:
    """One for each mode of each nodal diameter; without any, those of the excitation."""
    from vanelock.input.cases.values import ring_of

    N, order = ring_of(problem)
    wave = order % N if 2 * (order % N) <= N else order % N - N
    return [
        AnalysisPart(f"mode {number} ND {k}", {"mode": number, "nodal_diameter": k})
        for k in keys.nodal_diameters or (wave,)
        for number in keys.modes or (problem.response.mode,)
    ]


def _compute(case: "SolvedCase", keys: ModeKeys, part: AnalysisPart) -> FollowedMode:
    """One mode of one nodal diameter, with the harmonics of the peak."""
    number, k = part.inputs["mode"], part.inputs["nodal_diameter"]
    options, N = replace(case.options, direction=None), case.system.sectors
    of = case.system_at([h * k for h in range(options.harmonics + 1)]), number
    at = number, k, case.monitored.node, case.monitored.component

    with catch_warnings(category=RuntimeWarning, action="ignore"):  # `ended` says it
        try:
            if keys.air is None:
                alone = nonlinear.damped_mode(*of, None, options, k % N, progress=case.progress)
                return FollowedMode(*at, alone=alone)
            air = keys.air, None, options, k % N
            driven = nonlinear.limit_cycles(*of, *air, progress=case.progress)
        except InputError as error:
            return FollowedMode(*at, reason=str(error))
    return FollowedMode(*at, driven=driven)


def _warnings(case: "CaseResult", products: Sequence[FollowedMode]) -> Iterator[str]:
    """Which modes were not followed to gross slip, and which waves grow from rest."""
    for each in products:
        called = f"mode {each.number} of nodal diameter {each.nodal_diameter}"
        if each.mode is None:
            yield f"{called} was NOT FOLLOWED: {each.reason}"
        elif each.mode.ended:
            yield f"{called} was not followed to gross slip: {each.mode.ended}"
        if each.driven is not None and each.driven.linear_damping < 0:
            ratio = 100 * each.driven.linear_damping
            yield f"{called} FLUTTERS: with the air its damping ratio is {ratio:.2g} %"


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """Frequency and damping against amplitude; and, where air is given, flutter."""
    known, count = products_of(cases, "damped_modes")
    modes = [(name, each) for name, found in known.items() for each in found]
    if any(each.mode for _, each in modes):
        yield from by_case(_modes_table(modes), count)
    yield from by_case(_flutter_table(modes), count)


def _modes_table(modes: Sequence[tuple[str, FollowedMode]]) -> Table:
    """Each mode at rest, where it damps most and at its largest amplitude."""
    columns = (
        *HEADS,
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
    for name, each in modes:
        mode = each.mode
        if mode is None:
            rows.append((name, *each.cells, *[None] * 9, each.reason))
            flags.append("bad")
            continue
        size, frequency, damping = each.amplitude, mode.frequency, mode.damping_ratio
        most = int(np.argmax(damping))
        numbers = [*mode.linear, damping[most], size[most], frequency[most]]
        numbers += [size[-1], frequency[-1], damping[-1]]
        ended = mode.ended or None
        rows.append((name, *each.cells, *numbers, len(size), ended))
        flags.append("warn" if ended else "")
    title = "Damped modes: natural frequency and damping ratio against amplitude"
    notes = ["damping: of structure and friction, over the critical one; without the air"]
    return Table(title, columns, rows, notes, "damped_modes", flags).without_empty("ended")


def _flutter_table(modes: Sequence[tuple[str, FollowedMode]]) -> Table:
    """Each mode that the air acts on: whether it starts by itself, and where it settles."""
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
    for name, each in modes:
        if each.driven is None:
            continue
        place, kick = _settles(each) or (None, None), _grows_beyond(each)
        rest = "grows" if each.driven.linear_damping < 0 else "decays"
        air = each.driven.aerodynamic_damping, each.driven.linear_damping
        rows.append((name, *each.cells, *air, rest, *place, kick))
        flags.append("bad" if kick == 0 else "warn" if rest == "grows" else "good")
    title = "Flutter: damping by the air, limit cycles and critical kicks"
    made = Table(title, columns, rows, (), "flutter", flags)
    return made.without_empty("cycle_um", "cycle_hz", "kick_um")


def _settles(mode: FollowedMode) -> tuple[float, float] | None:
    """Amplitude, m, and frequency, Hz, of the cycle at which a wave from rest settles."""
    driven = mode.driven
    if driven is None or not driven.amplitude_stable.any():
        return None
    first = int(np.argmax(driven.amplitude_stable))
    return float(mode.cycles[first]), float(driven.frequency[first])


def _grows_beyond(mode: FollowedMode) -> float | None:
    """Amplitude, m, from which vibration grows without end; None where none is known."""
    if mode.driven is None or np.isinf(mode.driven.critical_kick):
        return None
    return float(mode.cycles[-1]) if len(mode.driven.amplitude) else 0.0


def _answers(case: "CaseResult") -> "Iterator[report.Answer]":
    """Whether the air makes a wave grow from rest."""
    driven = [(m, m.driven) for m in case.found("damped_modes") if m.driven is not None]
    if not driven:
        return
    worst, of = min(driven, key=lambda pair: pair[1].linear_damping)
    value = f"{100 * of.linear_damping:.2g} %"
    note = f"of structure and air at small amplitudes: {worst.name}"
    if of.linear_damping >= 0:
        yield report.Answer("Least damping", value, note, "good")
        return
    cycle = _settles(worst)
    ends = "nothing holds it"
    if cycle is not None:
        ends = f"its amplitude settles at {1e6 * cycle[0]:.3g} µm"
    yield report.Answer("Flutter", value, f"{note}; {ends}", "bad" if cycle is None else "warn")


def _pictures(run: "RunResult", case: "CaseResult") -> "Iterator[report.Picture]":
    """Frequency and damping ratio of the modes against amplitude, and what the air adds."""
    modes = [mode for mode in case.found("damped_modes") if mode.mode is not None]
    if not modes:
        return
    name = case.name
    title = f"Damped modes{of_case(name)}"
    subtitle = f"over half the peak-to-peak of {case.monitor.name}"
    frequency, damping, total = (list[render.PanelCurve]() for _ in range(3))
    for each in modes:
        mode, size = each.mode, 1e6 * each.amplitude
        seen = size > BEGIN * size.max()
        ratio, percent = mode.frequency[seen] / mode.linear[0], 100 * mode.damping_ratio[seen]
        frequency.append(render.PanelCurve(each.name, size[seen], ratio))
        damping.append(render.PanelCurve(each.name, size[seen], percent))
        if each.driven is not None:
            stable = each.driven.amplitude_stable.tolist()
            ends = [(1e6 * x, 0.0, s) for x, s in zip(each.cycles.tolist(), stable, strict=True)]
            with_air = percent + 100 * _air(case, each)[seen]
            total.append(render.PanelCurve(each.name, size[seen], with_air, ends))
    panels = [
        render.CurvePanel("frequency ratio", frequency),
        render.CurvePanel("damping ratio (%)", damping, from_zero=True),
    ]
    if total:
        panels.append(render.CurvePanel("with the air (%)", total, from_zero=True))
    caption = (
        f"Natural frequency and damping ratio{of_case(name)}, of structure and friction together, "
        "from small vibration with the contacts stuck to gross slip, as far as each was followed "
        "(dot); frequencies over those at rest. The table has them in Hz."
    )
    if total:
        caption += (
            " Below, the damping of the air is in it: where it is negative vibration grows. Its "
            "amplitude settles at full circles; beyond open ones it grows without end."
        )
    yield run.picture(
        f"figures/damped_modes_{slug(name)}",
        "Damped modes",
        [*case.key_of("damped_modes"), title, subtitle],
        lambda path: render.panels_picture(
            path, panels, "amplitude (µm)", title, subtitle, logarithmic=True
        ),
        lambda: _columns(case, modes),
        [f"{title}; {subtitle}"],
        caption,
    )


def _air(case: "CaseResult", mode: FollowedMode) -> Floats:
    """(p,) damping ratio of the air, negative where it drives; zero where none is given."""
    assert mode.mode is not None
    keys = DAMPED_MODES.keys_of(case.problem)
    if keys is None or keys.air is None:
        return np.zeros(len(mode.mode.frequency))
    N = case.ring[0]
    ratios = (nonlinear.aerodynamic_damping(keys.air, N, float(f)) for f in mode.mode.frequency)
    return np.array([each[mode.nodal_diameter % N] for each in ratios])


def _columns(case: "CaseResult", modes: Sequence[FollowedMode]) -> dict[str, ArrayLike]:
    curves = [each.mode for each in modes if each.mode is not None]
    counts = [len(curve.frequency) for curve in curves]
    columns: dict[str, ArrayLike] = {
        **mode_columns(modes, counts),
        "modal amplitude (kg^0.5 m)": np.concatenate([curve.amplitude for curve in curves]),
        "amplitude (µm)": np.concatenate([1e6 * each.amplitude for each in modes]),
        "frequency (Hz)": np.concatenate([curve.frequency for curve in curves]),
        "damping ratio (%)": np.concatenate([100 * curve.damping_ratio for curve in curves]),
    }
    if any(mode.driven is not None for mode in modes):
        air = [100 * _air(case, mode) for mode in modes]
        columns["damping ratio of the air (%)"] = np.concatenate(air)
    return columns


TEMPLATE = """\
# Natural frequency and damping ratio against amplitude, from stuck to gross slip, without
# excitation; the table's name alone is enough. See `vanelock manual damped_modes`.
# [damped_modes]
# modes = [2]                   # default: response.mode
# nodal_diameters = [1]         # negative: backward waves; default: that of the excitation
# influence = [[0, 0, -2e3], [1, -4e4, 0], [-1, 4e4, 0]]
                                # the air's modal force on a segment by the motion of those beside
                                # it, [segment, real, imaginary], 1/s^2: flutter and limit cycles
"""

DAMPED_MODES = Analysis(
    key="damped_modes",
    title="damped modes",
    keys=ModeKeys,
    scene_keys=ModeKeys,
    product=lambda: FollowedMode,
    compute=_compute,
    parts=parts,
    whole_ring=lambda problem, keys: keys.nodal_diameters is not None,
    check=_check,
    cost=lambda study, keys, curve: len(parts(study, keys)) * curve,
    places=lambda product: f"damped_modes/{product.place}",
    warnings=_warnings,
    tables=_tables,
    pictures=_pictures,
    answers=_answers,
    text=TEXT,
    template=TEMPLATE,
)
