"""Gather the evidence of a campaign: comparisons at full stick, maps, ridges, loops."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.commands.run.cases import OngoingRun
from vanelock.input.cases.sweep import Case
from vanelock.input.cases.values import with_values
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import PointDone
from vanelock.pipeline.step import Stages, Step
from vanelock.published.checks import Difference, at_mean_load, between, from_linear, sticking_load
from vanelock.published.conditions import PrescribedLoop, conditions
from vanelock.published.evidence import Evidence
from vanelock.published.maps.maps import Maps, PeakMap, ends, planned_maps
from vanelock.published.maps.plane import Plane
from vanelock.published.sheets import COUPLINGS, Plan, case_of, load_of, planned_sheets
from vanelock.stages.campbell.temperature_speed import with_temperature_speeds
from vanelock.stages.plan import Planned, plan
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.responses import silent_progress
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import Peak, Summary, peak_of
from vanelock.stages.sweep.graph import steps_of, works


def plan_of(study: Study, stages: Stages) -> Plan:
    """The campaign's cases; the load at which all contacts stick is found on the way."""
    draft = planned_sheets(study, 1.0)
    (heated,) = with_temperature_speeds([draft.cases[case_of(draft)]], stages)
    study = with_values(study, {"temperature": heated.study.temperature.model_dump()})
    draft = planned_sheets(study, 1.0)
    reference = plan(ordered(draft), silent_progress)[0]
    stuck = stages.get(reference.linear.responses["stuck"])
    static, system = stages.get(reference.preload), stages.get(reference.system)
    small = sticking_load(static, stuck, system.contacts.opens)
    return planned_sheets(study, small)


def ordered(plan: Plan) -> list[Case]:
    """Its cases, that of the reference first."""
    first = case_of(plan)
    return [plan.cases[first], *(case for name, case in plan.cases.items() if name != first)]


def maps_of(run: OngoingRun, plan: Plan) -> Maps:
    """The campaign's maps, around its reference."""
    ((reference, scene),) = [
        (each, work)
        for each, work in zip(run.planned, works(run.planned), strict=True)
        if each.case.name == case_of(plan)
    ]
    system, vane = (run.stages.get(each) for each in (reference.system, reference.rom["vane"]))
    free = run.stages.get(reference.linear.responses["free"])
    shown = monitor(plan.base.outputs.monitor, system, free)
    return planned_maps(scene, shown, system.output_names[shown.node], vane.band)


def evidence(run: OngoingRun, plan: Plan, summaries: Sequence[Summary], maps: Maps) -> Evidence:
    """Everything that the statements are judged by; `run` has all cases."""
    by_name = {each.case.name: each for each in run.planned}
    reference = by_name[case_of(plan)]
    stages, shown = run.stages, run.shown
    system = stages.get(reference.system)
    interlock = system.contacts.opens
    output = shown.monitor.node, shown.monitor.component
    linear: dict[str, Peak] = {}
    for which in ("free", "stuck"):
        response = stages.get(reference.linear.responses[which])
        peak = peak_of(response, shown.monitor.amplitude(response))
        assert peak is not None
        linear[which] = peak
    small = plan.sheets["stuck"].cases[0]
    keep = steps_of(reference)
    planes = {name: _plane(run, each, keep) for name, each in maps.planes.items()}
    slants = {slant: _plane(run, each, keep) for slant, each in maps.slants.items()}
    ridges = tuple(stages.get(each) for ridge in maps.ridges for each in ridge.steps())
    tops = {
        name: as_solved(stages.get(by_name[name].response), peak.point)
        for name, peak in shown.peak.items()
    }
    return Evidence(
        plan=plan,
        summaries={each.case: each for each in summaries},
        limits=stages.get(reference.linear.limits),
        linear=linear,
        monitor=shown.monitor.name,
        engine_order=reference.case.study.excitation.engine_order,
        small=load_of(plan.study(small)) / load_of(plan.base),
        hooks=_hooks(stages, by_name[plan.sheets["hooks"].cases[0]], output),
        stuck=_stuck(stages, by_name[small], output),
        at_mean=_at_mean(run, plan, by_name, tops, output),
        conditions=_conditions(plan.base),
        planes=planes,
        slants=slants,
        ridges=ridges,
        tops=tops,
        statics={name: stages.get(each.preload) for name, each in by_name.items()},
        interlock=interlock,
    )


def _hooks(stages: Stages, each: Planned, output: tuple[int, int]) -> Difference:
    system = stages.get(each.system)
    closed: NDArray[np.bool_] = ~system.contacts.opens
    return from_linear(stages.get(each.response), system, closed, output)


def _stuck(stages: Stages, each: Planned, output: tuple[int, int]) -> Mapping[str, Difference]:
    response, system = stages.get(each.response), stages.get(each.system)
    return {other: between(response, other, system, output) for other in COUPLINGS[1:]}


def _at_mean(
    run: OngoingRun,
    plan: Plan,
    by_name: Mapping[str, Planned],
    tops: Mapping[str, Response],
    output: tuple[int, int],
) -> Mapping[str, float]:
    """Of each coupled case that is compared with others."""
    found = {}
    listed = [name for sheet in ("friction", "interference") for name in plan.sheets[sheet].cases]
    for name in dict.fromkeys(listed):
        if name in tops and plan.study(name).response.coupling == COUPLINGS[0]:
            each = by_name[name]
            hertz = ends(each.case, run.stages.get(each.linear.limits))
            system = run.stages.get(each.system)
            found[name] = at_mean_load(system, tops[name], hertz, output)
    return found


def _conditions(base: Study) -> tuple[PrescribedLoop, ...]:
    joint = base.joints.interlock
    return conditions(joint.kn, joint.kt, joint.mu, abs(joint.interference) or 1e-6)


def _plane(run: OngoingRun, wanted: PeakMap, keep: Sequence[Step[Any]]) -> Plane:
    """A plane; its stuck modes are large, and dropped from memory."""

    def progress(done: int, total: int, peak: float) -> None:
        run.listener(PointDone("map", done, total, peak, float("nan")))

    found = run.stages.get(wanted.plane(progress))
    run.stages.retain(keep)
    return found
