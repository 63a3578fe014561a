"""At which rotor speed the response of a case has its temperatures, where they depend on it.

Unless `temperature.speed` says so: where the engine order of the study meets the mode of interest
with the interlock free, found on the modes with each part at its temperature there. It is
determined before the response is planned, from the same reduced parts that serve the response.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import Case
from vanelock.input.cases.values import diameter_of, with_values
from vanelock.input.schema.scene import Scene
from vanelock.input.schema.structure.piecewise import ends
from vanelock.input.schema.structure.temperature import PARTS
from vanelock.input.schema.study import Study
from vanelock.pipeline.step import Stages
from vanelock.stages.campbell.frequencies import Meeting, ModesOverSpeed, grid
from vanelock.stages.parts.study_structure import StudyStructure
from vanelock.stages.parts.temperatures import modulus, reference
from vanelock.stages.response.limits import limits

HIGHEST = 1e6
"""Speed beyond which no crossing is looked for, rpm."""


def with_temperature_speeds(cases: Sequence[Case], stages: Stages) -> list[Case]:
    """The cases, each with the speed of its temperatures determined."""
    if isinstance(cases[0].given, Scene) or not any(_needs_speed(case.study) for case in cases):
        return list(cases)
    found = []
    for case in cases:
        if not _needs_speed(case.study):
            found.append(case)
            continue
        speed = _crossing(case.study, stages)
        study = with_values(case.study, {"temperature.speed": speed})
        found.append(replace(case, given=study))
    return found


def _needs_speed(study: Study) -> bool:
    """Whether a study's temperatures depend on a speed that is not known yet."""
    return study.temperature.varies and study.temperature.speed is None


def factors(study: Study, base: Callable[[str], float]) -> Callable[[float], tuple[float, float]]:
    """Moduli of vane and casing against speed, rpm, over those that `base` says."""

    def at(speed: float) -> tuple[float, float]:
        vane, casing = (modulus(study, part, speed) / base(part) for part in PARTS)
        return vane, casing

    return at


def bends(study: Study) -> list[float]:
    """Speeds at which a modulus has a bend, rpm."""
    heat = study.temperature
    found: list[float] = []
    for part in PARTS:
        if not isinstance(known := getattr(heat, part), tuple):
            continue
        speeds, degrees = np.array(known).T
        found += speeds.tolist()
        for hot, _ in getattr(study.material, part).moduli:
            for i in np.flatnonzero((degrees[:-1] < hot) != (degrees[1:] < hot)):
                share = (hot - degrees[i]) / (degrees[i + 1] - degrees[i])
                found.append(float(speeds[i] + share * (speeds[i + 1] - speeds[i])))
    return found


def _crossing(study: Study, stages: Stages) -> float:
    """Rotor speed at which the study's engine order meets its mode of interest, rpm."""
    structure, k = StudyStructure(study, at_reference=True), diameter_of(study, 1)
    order = study.excitation.engine_order
    parts = {part: stages.get(structure.component(part, k)) for part in PARTS}
    excess = structure.excess(k)
    taken = None if excess is None else stages.get(excess)
    system = stages.get(structure.uncorrected or structure.bare.at(k))
    low, high = study.temperature.speeds
    low, high = max(low, 1.0), min(high, HIGHEST)
    scale = factors(study, lambda part: reference(study, part))
    over_speed = ModesOverSpeed(system, parts, k, scale, (low, high), taken)
    mode = limits(system, study.response.mode).free_mode + 1
    found = over_speed.meetings(order, False, mode, grid(low, high, bends(study)))
    met = [each for each in found if each.mode == mode - 1]
    if not met:
        raise InputError(_missed(study, over_speed, (low, high), mode))
    return _rounded(met[0])


def _missed(
    study: Study, over_speed: ModesOverSpeed, speeds: tuple[float, float], mode: int
) -> str:
    order = abs(study.excitation.engine_order)
    at_end = over_speed.frequencies(speeds[1], False, mode)[-1]
    part = next(
        part
        for part in PARTS
        if isinstance(known := getattr(study.temperature, part), tuple)
        and (speeds[1] in ends(known) or speeds[0] in ends(known))
    )
    return (
        f"temperature.{part}: engine order {order} meets free mode {mode} nowhere from "
        f"{speeds[0]:g} to {speeds[1]:g} rpm (it has {at_end:.5g} Hz there, "
        f"{60 * at_end / order:.5g} rpm): give temperatures up to that, or temperature.speed"
    )


def _rounded(met: Meeting) -> float:
    """The speed to 9 digits, so that rounding of the last bits changes no hash."""
    return float(f"{met.speed:.9g}")
