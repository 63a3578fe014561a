"""What an engineer asks of a run, case by case: margins, wear, damping, and a check of the peak."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vanelock import nonlinear
from vanelock.nonlinear import Audit, Response
from vanelock.pipeline.cache import key_of
from vanelock.pipeline.step import Stages, Step
from vanelock.quantities.contacts.energy import EnergyBalance, balance, bandwidth_ratio
from vanelock.quantities.contacts.wear import Wear, wear
from vanelock.quantities.run_result import Drawn, RunResult
from vanelock.quantities.selection import lowest_first, named, sampled
from vanelock.quantities.sensitivities import Sensitivities, sensitivities
from vanelock.quantities.stress.cycles import Stressed, stressed_step
from vanelock.quantities.stress.locations import SurfaceLocations, locations_of
from vanelock.quantities.stress.margins import Margins, margins
from vanelock.stages.parts.places import Places, places
from vanelock.stages.plan import Planned
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import Peak, WaveVerdict

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis

MOST = 8
"""Cases that are looked into; of more, some."""
FEW = 60
"""Cases that all get their damping ratio: each takes its system anew."""
AUDITED = 2**14
"""Samples of the period at which a peak is marched again."""


@dataclass(frozen=True)
class CaseAnswers:
    """Answers of one case at its peak.

    Attributes
    ----------
    name : str
    key : str
        Hash of what they depend on, the response included.
    planned : Planned
        Its steps, as solved.
    top : Response
        The largest point alone.
    peak : Peak
    margins : Margins or None
        Of its stresses; None where parts are matrices, which have no field.
    places : Places
        The contacts.
    wear : Wear
    balance : EnergyBalance
    bandwidth : float
        Damping ratio by the half-power bandwidth; NaN where the curve is too short.
    audit : Audit or None
        The peak checked by marching; None for what an audit does not cover, and at the largest
        peak by static friction, which its bounds check.
    sensitivities : Sensitivities or None
        What moves the peak; None at the largest by static friction.
    states : dict of str to tuple of CaseAnswers
        The same at other states that an analysis leads to.
    wave : WaveVerdict or None
        Whether the ring stays with the peak's wave; None where that was not asked.
    """

    name: str
    key: str
    planned: Planned
    top: Response
    peak: Peak
    margins: Margins | None
    places: Places
    wear: Wear
    balance: EnergyBalance
    bandwidth: float
    audit: Audit | None = None
    sensitivities: Sensitivities | None = None
    states: "Mapping[str, tuple[CaseAnswers, ...]]" = field(default_factory=dict)
    wave: WaveVerdict | None = None

    @property
    def stress(self) -> Margins:
        """The margins of a case that has stresses."""
        assert self.margins is not None
        return self.margins

    def numbers(
        self, analyses: "Sequence[Analysis[Any, Any]]"
    ) -> dict[str, tuple[float | str | list[float], str]]:
        """What the results file holds of this, each with its unit."""
        b = self.balance
        found: dict[str, tuple[float | str | list[float], str]] = {
            "damping_ratio": (b.damping_ratio, "1"),
            "bandwidth_ratio": (self.bandwidth, "1"),
            "input_work": (b.input, "J"),
            "friction_work": (b.friction, "J"),
            "stored_energy": (b.stored, "J"),
            "largest_slip": (float(np.nanmax(self.wear.slip, initial=0.0)), "m"),
        }
        if self.margins is None:
            return found
        for analysis in analyses:
            if states := self.states.get(analysis.key):
                found[analysis.reserve] = (states[-1].stress.governing.reserve, "1")
        m, gauges = self.margins.governing, self.margins.gauges
        found |= {
            "alternating_stress": (m.amplitude, "Pa"),
            "mean_stress": (m.mean, "Pa"),
            "goodman_reserve": (m.reserve, "1"),
            "vibration_may_grow": (m.growth, "1"),
            "place": (f"{m.part}, {m.where}", ""),
        }
        if gauges:
            found["gauge_alternating_stress"] = ([each.amplitude for each in gauges], "Pa")
            found["gauge_mean_stress"] = ([each.mean for each in gauges], "Pa")
            found["gauge_goodman_reserve"] = ([each.reserve for each in gauges], "1")
        return found


def looked_into(run: RunResult) -> list[str]:
    """Names of the cases that get answers of their own, in order.

    All if they are few; of samples those that have pictures, of other sweeps the first, the last
    and those of the extreme peaks.
    """
    peaks = run.peaks
    names = list(peaks)
    if len(names) <= MOST:
        return names
    if sampled(run):
        return [each.case.name for each in named(run)]
    order = lowest_first(peaks)
    chosen = names[0], names[-1], order[0], order[-1]
    return [name for name in names if name in chosen]


def answers(run: RunResult) -> dict[str, CaseAnswers]:
    """Answers of the cases of a run that are looked into."""
    known: dict[str, SurfaceLocations] = {}
    chosen, stages, found = looked_into(run), run.stages, {}
    for each in run.planned:
        if (name := each.case.name) not in chosen:
            continue
        planned = each.solved(stages.get(each.response))
        of = _answers(run, planned, known, run.peak(name), run.cases[name].drawn)
        moved = sensitivities(planned, of.top, of.peak, run.monitor, stages)
        audit = _audited(planned, of.top, of.peak.point, stages)
        result = run.cases[name]
        states = {
            analysis.key: tuple(
                _answers(run, state.planned, known, state.peak, state.curve)
                for state in analysis.states(replace(result, planned=planned))
            )
            for analysis in run.analyses
            if analysis.key in planned.analyses
        }
        wave = result.summary.wave
        found[name] = replace(of, audit=audit, sensitivities=moved, wave=wave, states=states)
    return found


def _answers(
    run: RunResult,
    planned: Planned,
    known: dict[str, SurfaceLocations],
    peak: Peak,
    curve: Drawn,
) -> CaseAnswers:
    """Of a case, `solved`, at a peak of its response; the curve gives its bandwidth."""
    stages, name = run.stages, planned.case.name
    top, system = as_solved(stages.get(planned.response), peak.point), stages.get(planned.system)
    key, stress = planned.response.key, None
    if planned.meshes:
        step = stressed_step(run, planned, peak.point)
        key, stress = step.key, _stress(planned, stages.get(step), stages, known)
    vane = stages.get(planned.meshes["vane"]) if planned.meshes else None
    contacts = places(planned.case.given, system.contacts, vane)
    frequency, amplitude, converged = curve
    return CaseAnswers(
        name=name,
        key=key,
        planned=planned,
        top=top,
        peak=peak,
        margins=stress,
        places=contacts,
        wear=wear(top, 0, contacts.area, contacts.coefficient),
        balance=balance(system, top),
        bandwidth=bandwidth_ratio(frequency, np.where(converged, amplitude, np.nan)),
    )


def _stress(
    planned: Planned, cycles: Stressed, stages: Stages, known: dict[str, SurfaceLocations]
) -> Margins:
    """Margins of a case with meshes; places of nodes that are `known` by their mesh stay."""
    study = planned.case.study
    for step in planned.meshes.values():
        if step.key not in known:
            known[step.key] = locations_of(study, stages.get(step))
    at = {part: known[step.key] for part, step in planned.meshes.items()}
    gauges = () if planned.gauges is None else stages.get(planned.gauges).names
    return margins(study, cycles, at, gauges)


def balances(run: RunResult) -> dict[str, EnergyBalance]:
    """Energies at the peak of every case, unless there are too many of them."""
    if len(run.planned) > FEW:
        return {}
    found = {}
    for each in run.planned:
        name = each.case.name
        if run.cases[name].peak is not None:
            planned = each.solved(run.stages.get(each.response))
            found[name] = balance(run.stages.get(planned.system), run.top(each))
    return found


def _audited(planned: Planned, top: Response, point: int, stages: Stages) -> Audit | None:
    """An independent check of the peak, where one is possible."""
    if (top.coupling, top.samples) != ("coupled", 0):
        return None
    if np.any(top.state == nonlinear.ELEMENT):
        return None

    def compute() -> Audit:
        return nonlinear.audit_response(stages.get(planned.system), top, [0], AUDITED)

    inputs = {"point": point, "samples": AUDITED}
    key = key_of("check", "nonlinear", inputs, (planned.response.key, planned.system.key))
    return stages.get(Step("check", f"check {planned.case.name}", key, Audit, (), compute))
