"""The lines of a Campbell diagram: natural frequencies against rotor speed, and their crossings.

Of each nodal diameter that an engine order excites, ND = EO mod N folded to 0 ... N/2, with the
interlock free and stuck and the hooks stuck. Each part has, at every rotor speed, the modulus of
its temperature there.

Linear response along the line of an engine order: what the circles of a Campbell diagram show.

At speed n the load turns with the frequency |EO| n / 60 and acts with the study's amplitude at each
force node. The parts have the temperatures of the nearest crossing.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from vanelock import nonlinear
from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.input.schema.comparison import CampbellKeys
from vanelock.input.schema.structure.temperature import PARTS
from vanelock.input.schema.study import Study
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.campbell.frequencies import ModesOverSpeed, bends, factors, grid
from vanelock.stages.parts.loads import modulus
from vanelock.stages.parts.segment import Segment, StudyStructure
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limit, Limits, fine
from vanelock.stages.response.responses import Monitor

BEYOND = 1.25
"""Highest speed over that of the crossings of interest, unless the study says otherwise."""


@dataclass(frozen=True)
class Lines(Product):
    """Natural frequencies against rotor speed, and where engine orders meet them.

    Attributes
    ----------
    speeds : (s,) float
        Rotor speeds, rpm.
    engine_orders, diameters : (e,), (d,) int
        Engine orders drawn, and the nodal diameters that they excite, ascending.
    free, stuck : (d, s, m) float
        Natural frequencies with the interlock free and stuck, Hz; the same where it has no
        contacts.
    temperatures : (s, 2) float
        Of vane and casing, degC; NaN where a part has none.
    order, diameter, mode : (c,) int
        Of each crossing: EO, ND, and the mode's place from 1.
    is_stuck : (c,) bool
        Its condition.
    frequency, speed : (c,) float
        Where it is, Hz and rpm.
    interest : (c,) bool
        Whether it is the study's engine order on the mode of interest.
    """

    speeds: Floats = field(metadata={"unit": "rpm"})
    engine_orders: Integers
    diameters: Integers
    free: Floats = field(metadata={"unit": "Hz"})
    stuck: Floats = field(metadata={"unit": "Hz"})
    temperatures: Floats = field(metadata={"unit": "degC"})
    order: Integers
    diameter: Integers
    mode: Integers
    is_stuck: Booleans
    frequency: Floats = field(metadata={"unit": "Hz"})
    speed: Floats = field(metadata={"unit": "rpm"})
    interest: Booleans

    @property
    def interlock(self) -> bool:
        """Whether free and stuck differ."""
        return not np.array_equal(self.free, self.stuck)


@dataclass(frozen=True)
class Campbell(Product):
    """Everything that a Campbell diagram shows.

    Attributes
    ----------
    lines : Lines
        Natural frequencies and crossings.
    order : (b,) int
        Engine order of each circle.
    speed, frequency, amplitude : (b,) float
        Its place, rpm and Hz, and the amplitude of the monitored displacement, m.
    nonlinear : (b,) bool
        Whether it comes from the nonlinear response.
    own_order : int
        The engine order whose nonlinear response was computed.
    monitor : str
        The displacement.
    linear : str
        The interlock in the linear responses, "free" or "stuck".
    loading : str
        The load in words.
    """

    lines: Lines
    order: Integers
    speed: Floats = field(metadata={"unit": "rpm"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    amplitude: Floats = field(metadata={"unit": "m"})
    nonlinear: Booleans
    own_order: int
    monitor: str
    linear: str
    loading: str


def lines_step(planned: Planned) -> Step[Lines]:
    """Lines and crossings of a case."""
    study, structure = planned.case.study, planned.structure
    given, own = study.campbell or CampbellKeys(), abs(study.excitation.engine_order)
    orders = tuple(sorted({*given.engine_orders, own}))
    keys = given.model_copy(update={"engine_orders": orders})
    diameters = sorted({*map(structure.folded, keys.engine_orders)})
    assert isinstance(structure, StudyStructure)
    bare = Segment(structure.bare.segment.joints)
    inputs: dict[str, Any] = {
        **keys.model_dump(),
        "temperature": study.temperature.model_dump(),
        "moduli": {
            p: getattr(study.material, p).model_dump(include={"E", "nu", "rho"}) for p in PARTS
        },
        "joints": [asdict(joint) for joint in bare.joints],
        "engine_order": study.excitation.engine_order,
    }

    def compute(get: Callable[[Step[Any]], Any]) -> Lines:
        limits = get(planned.linear.limits)
        over_speed, ends = {}, _speeds(study, keys, limits)
        scale = factors(study, modulus)
        for k in diameters:
            parts = {part: get(planned.part(part, k)) for part in PARTS}
            excess = structure.excess(k)
            taken = None if excess is None else get(excess)
            system = structure.rejoined(get, (k,), bare)
            over_speed[k] = ModesOverSpeed(system, parts, k, scale, ends, taken)
        return _lines(study, keys, limits, over_speed, grid(*ends, bends(study)))

    needs = (planned.linear.limits, *structure.reduced(diameters))
    return step("Campbell lines", "rom", inputs, Lines, needs, compute, pulls=True)


def _lines(
    study: Study,
    keys: CampbellKeys,
    limits: Limits,
    over_speed: dict[int, ModesOverSpeed],
    speeds: Floats,
) -> Lines:
    count = max(keys.modes, limits.free_mode + 1, limits.stuck_mode + 1)
    conditions = (False, True) if limits.opens else (False,)
    own, N = abs(study.excitation.engine_order), study.ring.sectors
    rows = []
    for order in keys.engine_orders:
        k = folded(order, N)
        for stuck in conditions:
            place = limits.stuck_mode if stuck else limits.free_mode
            for met in over_speed[k].meetings(order, stuck, count, speeds):
                interest = order == own and met.mode == place
                rows.append((order, k, met.mode + 1, stuck, met.frequency, met.speed, interest))
    rows.sort(key=lambda row: (row[0], row[5]))
    table = np.array(rows, float).reshape(-1, 7).T
    lines = [[each.line(speeds, s, count) for each in over_speed.values()] for s in conditions]
    heat = [[study.temperature.of(part, float(n)) for part in PARTS] for n in speeds]
    return Lines(
        speeds=speeds,
        engine_orders=np.array(keys.engine_orders, np.int64),
        diameters=np.array(list(over_speed), np.int64),
        free=np.array(lines[0]),
        stuck=np.array(lines[-1]),
        temperatures=np.array(heat, float),
        order=table[0].astype(np.int64),
        diameter=table[1].astype(np.int64),
        mode=table[2].astype(np.int64),
        is_stuck=table[3].astype(bool),
        frequency=table[4],
        speed=table[5],
        interest=table[6].astype(bool),
    )


def _speeds(study: Study, keys: CampbellKeys, limits: Limits) -> tuple[float, float]:
    """Range of rotor speeds, rpm: from rest to beyond the crossings of interest."""
    if keys.speeds is not None:
        return keys.speeds[0], keys.speeds[1]
    low, last = study.temperature.speeds
    order = abs(study.excitation.engine_order)
    crossing = 60 * max(limits.free_frequency, limits.stuck_frequency) / order
    step = 10.0 ** math.floor(math.log10(max(BEYOND * crossing, 1.0)))
    high = min(math.ceil(2 * BEYOND * crossing / step) * step / 2, last)
    if not low < high:
        raise InputError(
            f"campbell.speeds: temperatures begin at {low:g} rpm, beyond the mode of interest: "
            "give the range"
        )
    return low, high


EVEN = 120
"""Speeds between those that resolve the peaks."""


@dataclass(frozen=True)
class Along(Product):
    """Linear response along the line of an engine order, (p,) ascending speeds.

    Attributes
    ----------
    speed : (p,) float
        rpm.
    amplitude : (p,) float
        Of the monitored displacement, m.
    """

    speed: Floats = field(metadata={"unit": "rpm"})
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
        "segment": asdict(bare),
    }

    def compute(get: Callable[[Step[Any]], Any]) -> Along:
        pieces, lines = [], get(lines_of)
        nodes = len(get(structure.component("casing", 0)).masters.set("force"))
        turning = _of_order(bare, order, nodes, study.ring.sectors)
        for low, high, centre, peaks in _segments(lines, order, closed == "stuck"):
            scale = factors(study, modulus)(centre)
            system = _with_unbalance(structure.rejoined(get, used, turning, scale), bare)
            mask = ~system.contacts.opens if closed == "free" else "all"
            hertz = _frequencies(low, high, peaks, order, study.damping.ratio)
            hertz = hertz[hertz <= (system.band or np.inf)]
            if not len(hertz):  # a warning says so
                break
            found = nonlinear.linear_response(system, hertz, mask)
            pieces.append((60 * hertz / order, monitor.amplitude(found)))
        return Along(*(np.concatenate(each) for each in zip(*pieces, strict=True)))

    needs = (lines_of, *structure.reduced(used))
    name = f"Campbell response, EO {order}"
    return step(name, "nonlinear", inputs, Along, needs, compute, pulls=True)


def _of_order(segment: Segment, order: int, nodes: int, sectors: int) -> Segment:
    """A segment loaded by another engine order, as much at each of the force nodes of a sector.

    An unbalance becomes the force that it has at 1 rad/s, see `with_unbalance`.
    """
    force = segment.force or 2 * segment.unbalance / (sectors * nodes)
    turns = -order if segment.engine_order < 0 else order
    return replace(segment, engine_order=turns, force=force, unbalance=0.0)


def _with_unbalance(system: System, segment: Segment) -> System:
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
