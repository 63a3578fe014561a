"""Linear response along the line of an engine order: what the circles of a Campbell diagram show.

At speed n the load turns with the frequency |EO| n / 60 and acts with the study's amplitude at each
force node. The parts have the temperatures of the nearest crossing.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vanelock import nonlinear
from vanelock.common.arrays import Floats
from vanelock.common.product import Product
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.campbell.speed_lines import Lines, lines_step
from vanelock.stages.campbell.temperature_speed import factors
from vanelock.stages.parts.segment import Segment
from vanelock.stages.parts.study_structure import StudyStructure
from vanelock.stages.parts.temperatures import modulus
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limit, fine
from vanelock.stages.response.monitor import Monitor

EVEN = 120
"""Speeds between those that resolve the peaks."""


@dataclass(frozen=True)
class Along(Product):
    """Linear response along the line of an engine order, (p,) ascending speeds.

    Attributes
    ----------
    speed, frequency : (p,) float
        rpm and Hz.
    amplitude : (p,) float
        Of the monitored displacement, m.
    """

    speed: Floats = field(metadata={"unit": "rpm"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    amplitude: Floats = field(metadata={"unit": "m"})


def along_step(planned: Planned, order: int, closed: Limit, monitor: Monitor) -> Step[Along]:
    """Response to one engine order, the interlock free or stuck."""
    study, structure = planned.case.study, planned.structure
    assert isinstance(structure, StudyStructure)
    used, lines_of = {0, structure.folded(order)}, lines_step(planned)
    bare = structure.bare.segment
    inputs: dict[str, Any] = {
        "order": order,
        "closed": closed,
        "monitor": [monitor.node, monitor.component],
        "segment": bare.keys,
    }

    def compute(get: Callable[[Step[Any]], Any]) -> Along:
        pieces, lines = [], get(lines_of)
        nodes = len(get(structure.component("casing", 0)).masters.set("force"))
        turning = of_order(bare, order, nodes, study.ring.sectors)
        for low, high, centre, peaks in _segments(lines, order, closed == "stuck"):
            scale = factors(study, lambda part: modulus(study, part))(centre)
            system = with_unbalance(structure.rejoined(get, used, turning, scale), bare)
            mask = ~system.contacts.opens if closed == "free" else "all"
            hertz = _frequencies(low, high, peaks, order, study.damping.ratio)
            hertz = hertz[hertz <= (system.band or np.inf)]
            if not len(hertz):  # a warning says so
                break
            found = nonlinear.linear_response(system, hertz, mask)
            pieces.append((60 * hertz / order, hertz, monitor.amplitude(found)))
        return Along(*(np.concatenate(each) for each in zip(*pieces, strict=True)))

    needs = (lines_of, *structure.reduced(used))
    name = f"Campbell response, EO {order}"
    return step(name, "nonlinear", inputs, Along, needs, compute, pulls=True)


def of_order(segment: Segment, order: int, nodes: int, sectors: int) -> Segment:
    """A segment loaded by another engine order, as much at each of the force nodes of a sector.

    An unbalance becomes the force that it has at 1 rad/s, see `with_unbalance`.
    """
    force = segment.force or 2 * segment.unbalance / (sectors * nodes)
    turns = -order if segment.engine_order < 0 else order
    return replace(segment, engine_order=turns, force=force, unbalance=0.0)


def with_unbalance(system: System, segment: Segment) -> System:
    """The system with its force growing with the square of the speed where an unbalance acts."""
    if not segment.unbalance:
        return system
    power = {h: replace(force, omega_power=2) for h, force in system.force.items()}
    return replace(system, force=power)


def _segments(
    lines: Lines, order: int, stuck: bool
) -> list[tuple[float, float, float, list[float]]]:
    """Ranges of speed (low, high), rpm, the speed that gives their temperatures, and the peaks.

    One for each crossing where temperatures vary, else a single one.
    """
    own = (lines.order == order) & (lines.is_stuck == (stuck and lines.interlock))
    met = np.unique(lines.speed[own])
    low, high = float(lines.speeds[0]), float(lines.speeds[-1])
    known = lines.temperatures[:, ~np.isnan(lines.temperatures).any(axis=0)]
    if len(met) < 2 or np.ptp(known, axis=0).max(initial=0.0) == 0:
        return [(low, high, float(met[0]) if len(met) else (low + high) / 2, met.tolist())]
    between = [low, *((met[:-1] + met[1:]) / 2).tolist(), high]
    return [
        (a, b, float(n), [float(n)]) for a, b, n in zip(between, between[1:], met, strict=False)
    ]


def _frequencies(
    low: float, high: float, peaks: Sequence[float], order: int, damping: float
) -> Floats:
    """Frequencies of a range of speeds, Hz, fine at its peaks."""
    ends = max(low, 1e-3 * high) * order / 60, high * order / 60
    parts = [np.linspace(ends[0], ends[1], EVEN)]
    parts += [fine(speed * order / 60, damping) for speed in peaks]
    found = np.unique(np.concatenate(parts))
    return np.asarray(found[(found >= ends[0]) & (found <= ends[1])])
