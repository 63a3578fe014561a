"""Linear response along the line of an engine order: what the circles of a Campbell diagram show.

At speed n the load turns with the frequency |EO| n / 60 and acts with the study's amplitude at each
force node. The parts have the temperatures of the nearest crossing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear, rom
from vanelock.common.cyclic import folded
from vanelock.common.product import Product
from vanelock.input.schema.study import Study
from vanelock.pipeline.step import Stages, Step, step
from vanelock.rom import Component, MeshExcess, System
from vanelock.stages.campbell.speed_lines import Lines, at_diameter, casings, lines_step
from vanelock.stages.campbell.temperature_speed import factors
from vanelock.stages.parts.systems import Joining, excess_steps, joining, without_friction
from vanelock.stages.parts.temperatures import modulus
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import fine
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.responses import Limit

Floats = NDArray[np.float64]

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


def along_step(
    planned: Planned, stages: Stages, order: int, closed: Limit, monitor: Monitor
) -> Step[Along]:
    """Response to one engine order, the interlock free or stuck."""
    study, N = planned.case.study, planned.case.study.ring.sectors
    k, bare = folded(order, N), joining(without_friction(study))
    every = sorted({0, *(folded(each, N) for each in _orders(planned, stages))})
    parts = casings(planned, stages, every)
    used = sorted({0, k})
    inputs: dict[str, Any] = {
        "order": order,
        "backward": study.excitation.engine_order < 0,
        "closed": closed,
        "monitor": [monitor.node, monitor.component],
        "load": [study.excitation.force_per_node, study.excitation.unbalance],
        "damping": study.damping.model_dump(),
        "joints": [asdict(joint) for joint in bare.joints],
    }

    shells, blade = [parts[each] for each in used], planned.rom["vane"]

    def compute(lines: Lines, vane: Component, *others: Any) -> Along:
        found = zip(used, others, strict=False)
        shell = {each: at_diameter(part, each) for each, part in found}
        taken = dict(zip(used, others[len(used) :], strict=False))
        pieces = []
        for low, high, centre, peaks in segments(lines, order, closed == "stuck"):
            scale = factors(study, lambda part: modulus(study, part))(centre)
            system = joined_at(study, order, vane, shell, bare, scale, taken)
            mask = ~system.contacts.opens if closed == "free" else "all"
            hertz = _frequencies(low, high, peaks, order, study.damping.ratio)
            hertz = hertz[hertz <= (system.band or np.inf)]
            if not len(hertz):  # a warning says so
                break
            found = nonlinear.linear_response(system, hertz, mask)
            pieces.append((60 * hertz / order, hertz, monitor.amplitude(found)))
        return Along(*(np.concatenate(each) for each in zip(*pieces, strict=True)))

    excesses = excess_steps(study, blade, shells, planned.base)
    needs = (lines_step(planned, stages), blade, *shells, *excesses)
    name = f"Campbell response, EO {order}"
    return step(name, "nonlinear", inputs, Along, needs, compute)


def _orders(planned: Planned, stages: Stages) -> Sequence[int]:
    return [int(each) for each in stages.get(lines_step(planned, stages)).engine_orders]


def segments(
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


def joined_at(
    study: Study,
    order: int,
    vane: Component,
    shells: dict[int, Component],
    bare: Joining,
    scale: tuple[float, float],
    excess: Mapping[int, MeshExcess],
) -> System:
    """The joined parts at a temperature, loaded by an engine order."""
    sign = -1 if study.excitation.engine_order < 0 else 1
    unbalance = study.excitation.unbalance
    load = rom.Excitation(sign * order, force=study.excitation.force_per_node)
    if unbalance is not None:  # as much at each force node as of engine order 1
        nodes = len(next(iter(shells.values())).masters.set("force"))
        load = rom.Excitation(sign * order, force=2 * unbalance / (study.ring.sectors * nodes))
    given, blade = bare._replace(excitation=load), rom.stiffened(vane, scale[0])
    found = []
    for k, shell in shells.items():
        joined = given.join(blade, rom.stiffened(shell, scale[1]))
        found.append(excess[k].taken_off(joined, scale) if k in excess else joined)
    system = rom.united(found)
    if unbalance is None:
        return system
    power = {h: replace(force, omega_power=2) for h, force in system.force.items()}
    return replace(system, force=power)
