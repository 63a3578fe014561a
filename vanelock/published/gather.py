"""Gather the evidence of a campaign: comparisons at full stick, maps, ridges, loops."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from vanelock.commands.run.cases import Run
from vanelock.input.cases.sweep import Case
from vanelock.input.cases.values import with_values
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import PointDone
from vanelock.pipeline.step import Stages
from vanelock.published.checks import Difference, at_mean_load, between, from_linear, sticking_load
from vanelock.published.conditions import PrescribedLoop, conditions
from vanelock.published.evidence import Evidence
from vanelock.published.maps import maps
from vanelock.published.maps.optimum import Ridge
from vanelock.published.maps.plane import Plane
from vanelock.published.sheets import COUPLINGS, Plan, case_of, load_of, planned_sheets
from vanelock.stages.parts.bare import linear_system_step
from vanelock.stages.parts.components import diameters, rom_step, system_step
from vanelock.stages.parts.temperature_speed import with_temperature_speeds
from vanelock.stages.plan import Planned
from vanelock.stages.response.responses import (
    limits_step,
    linear_step,
    preload_step,
)
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import Peak, Summary, peak_of

RIDGES = (1, 3)
"""Harmonics of the ridges, as far as the campaign has them."""


def plan_of(study: Study, stages: Stages) -> Plan:
    """The campaign's cases; the load at which all contacts stick is found on the way."""
    draft = planned_sheets(study, 1.0)
    (warm,) = with_temperature_speeds([draft.cases[case_of(draft)]], stages)
    study = with_values(study, {"temperature": warm.study.temperature.model_dump()})
    draft = planned_sheets(study, 1.0)
    wanted = diameters(case.study for case in draft.cases.values())
    base = draft.base
    rom = {part: rom_step(base, part, wanted) for part in ("vane", "casing")}
    bare = linear_system_step(base, **rom)
    limits = limits_step(base.response.mode, bare, tuple(rom.values()))
    stuck = stages.get(linear_step(base, "stuck", bare, limits))
    system = system_step(base, **rom)
    static = stages.get(preload_step(base.response.friction, system))
    small = sticking_load(static, stuck, stages.get(system).contacts.opens)
    return planned_sheets(study, small)


def ordered(plan: Plan) -> list[Case]:
    """Its cases, that of the reference first."""
    first = case_of(plan)
    return [plan.cases[first], *(case for name, case in plan.cases.items() if name != first)]


def evidence(run: Run, plan: Plan, summaries: Sequence[Summary], workers: int = 1) -> Evidence:
    """Everything that the statements are judged by; `run` has all cases.

    Points of maps are computed by so many processes.
    """
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
    node = system.output_names[output[0]]
    planes, slants, ridges = _maps(run, plan, reference, output, node, workers)
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
    run: Run,
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
            hertz = maps.ends(each.case.study, run.stages.get(each.linear.limits))
            system = run.stages.get(each.system)
            found[name] = at_mean_load(system, tops[name], hertz, output)
    return found


def _conditions(base: Study) -> tuple[PrescribedLoop, ...]:
    joint = base.joints.interlock
    return conditions(joint.kn, joint.kt, joint.mu, abs(joint.interference) or 1e-6)


def _maps(
    run: Run, plan: Plan, reference: Planned, output: tuple[int, int], node: str, workers: int
) -> tuple[dict[str, Plane], dict[float, Plane], tuple[Ridge, ...]]:
    study, stages = plan.base, run.stages
    assert study.campaign is not None

    def told(name: str) -> maps.Told:
        def say(done: int, total: int, peak: float) -> None:
            run.listener(PointDone(name, done, total, peak, float("nan")))

        return say

    own = reference.system, reference.linear.limits
    planes = {
        "interference": maps.plane_step(
            "friction, interference",
            study,
            *own,
            "interference",
            maps.methods(study),
            output,
            told("map"),
            workers,
        ),
        "load": maps.plane_step(
            "friction, load",
            study,
            *own,
            "load",
            maps.methods(study)[:3],
            output,
            told("map"),
            workers,
        ),
    }
    ridges = [
        maps.ridge_step(study, *own, name, h, (node, output[1]))
        for h in RIDGES
        if h in study.campaign.harmonics
        for name in ("mu", "interference")
    ]
    band = stages.get(reference.rom["vane"]).band
    slants = {}
    for slant in study.campaign.slants:
        if slant == getattr(study.vane, "interlock_slant", None):
            continue
        slants[slant] = maps.plane_step(
            f"slant {slant:g}",
            study,
            *maps.slanted(study, slant, band),
            "interference",
            maps.few_methods(study),
            output,
            told("map"),
            workers,
            every=2,
        )
    return (
        {name: stages.get(step) for name, step in planes.items()},
        {slant: stages.get(step) for slant, step in slants.items()},
        tuple(stages.get(step) for step in ridges),
    )
