"""Gather the evidence of a campaign: comparisons at full stick, maps, ridges, loops."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from vanelock.campaign import maps
from vanelock.campaign.chart import Chart
from vanelock.campaign.checks import Difference, at_mean_load, between, from_linear, sticking_load
from vanelock.campaign.conditions import Loop, conditions
from vanelock.campaign.evidence import Evidence
from vanelock.campaign.optimum import Ridge
from vanelock.campaign.plane import Plane
from vanelock.campaign.sheets import COUPLINGS, Plan, case_of, load_of, planned_sheets
from vanelock.errors import InputError
from vanelock.study.bundles import Wanted, divided, works
from vanelock.study.forced import limits_step, linear_step, linear_system_step, preload_step
from vanelock.study.limits import hooks
from vanelock.study.model import Study
from vanelock.study.plan import Planned
from vanelock.study.progress import Point
from vanelock.study.running import Run
from vanelock.study.stages import diameters, rom_step, system_step
from vanelock.study.steps import Stages
from vanelock.study.summary import Peak, Summary, peak_of
from vanelock.study.sweep import Case, with_values
from vanelock.study.tasks import TaskFailed
from vanelock.study.warm import warmed


def plan_of(study: Study, stages: Stages) -> Plan:
    """The campaign's cases; the load at which all contacts stick is found on the way."""
    draft = planned_sheets(study, 1.0)
    (warm,) = warmed([draft.cases[case_of(draft)]], stages)
    study = with_values(study, {"temperature": warm.study.temperature.model_dump()})
    draft = planned_sheets(study, 1.0)
    wanted = diameters(case.study for case in draft.cases.values())
    base = draft.base
    rom = {part: rom_step(base, part, wanted) for part in ("vane", "casing")}
    bare = linear_system_step(base, **rom)
    limits = limits_step(base, bare, **rom)
    stuck = stages.get(linear_step(base, "stuck", bare, limits))
    system = system_step(base, **rom)
    static = stages.get(preload_step(base, system))
    small = sticking_load(static, stuck, stages.get(system).contacts.joint)
    return planned_sheets(study, small)


def ordered(plan: Plan) -> list[Case]:
    """Its cases, that of the reference first."""
    first = case_of(plan)
    return [plan.cases[first], *(case for name, case in plan.cases.items() if name != first)]


def evidence(run: Run, plan: Plan, summaries: Sequence[Summary]) -> Evidence:
    """Everything that the statements are judged by; `run` has all cases."""
    by_name = {each.case.name: each for each in run.planned}
    reference = by_name[case_of(plan)]
    stages, shown = run.stages, run.shown
    system = stages.get(reference.system)
    interlock = ~hooks(system.contacts.joint)
    output = shown.monitor.node, shown.monitor.component
    linear: dict[str, Peak] = {}
    for which in ("free", "stuck"):
        response = stages.get(reference.linear.responses[which])
        peak = peak_of(response, shown.monitor.amplitude(response))
        assert peak is not None
        linear[which] = peak
    small = plan.sheets["stuck"].cases[0]
    planes, slants, ridges = _maps(run, plan, reference, output, system.output_names[output[0]])
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
        at_mean=_at_mean(run, plan, by_name, output),
        conditions=_conditions(plan.base),
        planes=planes,
        slants=slants,
        ridges=ridges,
        tops=shown.top,
        statics=shown.static,
        interlock=interlock,
    )


def _hooks(stages: Stages, each: Planned, output: tuple[int, int]) -> Difference:
    system = stages.get(each.system)
    closed: NDArray[np.bool_] = hooks(system.contacts.joint)
    return from_linear(stages.get(each.response), system, closed, output)


def _stuck(stages: Stages, each: Planned, output: tuple[int, int]) -> Mapping[str, Difference]:
    response, system = stages.get(each.response), stages.get(each.system)
    return {other: between(response, other, system, output) for other in COUPLINGS[1:]}


def _at_mean(
    run: Run, plan: Plan, by_name: Mapping[str, Planned], output: tuple[int, int]
) -> Mapping[str, float]:
    """Of each coupled case that is compared with others."""
    found = {}
    listed = [name for sheet in ("friction", "interference") for name in plan.sheets[sheet].cases]
    for name in dict.fromkeys(listed):
        if name in run.shown.top and plan.study(name).response.coupling == COUPLINGS[0]:
            each = by_name[name]
            hertz = maps.ends(each.case.study, run.stages.get(each.linear.limits))
            system = run.stages.get(each.system)
            found[name] = at_mean_load(system, run.shown.top[name], hertz, output)
    return found


def _conditions(base: Study) -> tuple[Loop, ...]:
    joint = base.joints.interlock
    return conditions(joint.kn, joint.kt, joint.mu, abs(joint.interference) or 1e-6)


def _maps(
    run: Run, plan: Plan, reference: Planned, output: tuple[int, int], node: str
) -> tuple[dict[str, Plane], dict[float, Plane], tuple[Ridge, ...]]:
    """Planes and ridges; computed by other processes, if there are any."""
    work = works(run.planned)[run.planned.index(reference)]
    band = run.stages.get(reference.rom["vane"]).band
    chart = Chart(plan.base, work, output, node, band)

    def told(done: int, total: int, peak: float) -> None:
        run.listener(Point("map", done, total, peak, 0.0))

    charted = chart.charted(told)
    wanted = [Wanted(step.name, [step], step, chart) for step in charted.steps()]
    with run.helped(lambda: divided(wanted, run.cache)):
        try:
            return (
                {name: run.stages.get(step) for name, step in charted.planes.items()},
                {slant: run.stages.get(step) for slant, step in charted.slants.items()},
                tuple(run.stages.get(step) for step in charted.ridges),
            )
        except TaskFailed as error:
            raise InputError(f"campaign: {error.failure.task}: {error.failure.reason}") from None
