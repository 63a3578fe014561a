"""Campbell diagram of a case: natural frequencies, engine orders, crossings and how it responds.

Circles on the lines of the engine orders show how it responds, as measured diagrams do: the
largest amplitude in each of many narrow ranges of speed. Those of the study's own engine order come
from its nonlinear response as far as that reaches. All others are of the linear response to the
same load at each force node, with the interlock free or stuck, whichever frequency of the mode of
interest the nonlinear peak is nearer to; friction would lower them.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock.common.product import Product
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Stages
from vanelock.stages.campbell.engine_orders import Along, along_step
from vanelock.stages.campbell.speed_lines import Lines, lines_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.responses import Limit
from vanelock.stages.response.summary import peak_of

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

RANGES = 100
"""Ranges of speed of which a circle shows the largest amplitude."""
LEAST = 0.002
"""Of the largest amplitude, below which no circle is kept."""


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
    nonlinear: NDArray[np.bool_]
    own_order: int
    monitor: str
    linear: str
    loading: str


def campbell(planned: Planned, stages: Stages, monitor: Monitor) -> Campbell:
    """The diagram of a case; what it takes beyond the case's own stages is cached as they are."""
    study = planned.case.study
    limits, response = stages.get(planned.linear.limits), stages.get(planned.response)
    lines = stages.get(lines_step(planned))
    linear = _condition(limits, response, monitor)
    own = abs(study.excitation.engine_order)
    found = []
    for order in lines.engine_orders.tolist():
        along = stages.get(along_step(planned, order, linear, monitor))
        curve = (response, monitor) if order == own else None
        found.append(_circles(lines, order, along, curve))
    orders, speed, frequency, amplitude, by_friction = (
        np.concatenate(each) for each in zip(*found, strict=True)
    )
    kept = amplitude > LEAST * amplitude.max(initial=0.0)
    return Campbell(
        lines=lines,
        order=orders[kept].astype(np.int64),
        speed=speed[kept],
        frequency=frequency[kept],
        amplitude=amplitude[kept],
        nonlinear=by_friction[kept].astype(bool),
        own_order=own,
        monitor=monitor.name,
        linear=linear,
        loading=_loading(study),
    )


def _condition(limits: Limits, response: Response, monitor: Monitor) -> Limit:
    """Which linear limit the nonlinear peak is nearer to."""
    peak = peak_of(response, monitor.amplitude(response))
    if peak is None or not limits.opens:
        return "free"
    return "free" if limits.position(peak.frequency) < 0.5 else "stuck"


def _circles(
    lines: Lines, order: int, along: Along, curve: tuple[Response, Monitor] | None
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Order, speed, frequency, amplitude and origin of the circles on a line."""
    speed, amplitude = along.speed, along.amplitude
    nonlinear = np.zeros(len(speed))
    if curve is not None:
        response, monitor = curve
        own = 60 * response.frequency / order
        outside = (speed < own.min()) | (speed > own.max())
        speed = np.concatenate([speed[outside], own])
        amplitude = np.concatenate([amplitude[outside], monitor.amplitude(response)])
        nonlinear = np.concatenate([nonlinear[outside], np.ones(len(own))])
    inside = (speed >= lines.speeds[0]) & (speed <= lines.speeds[-1]) & ~np.isnan(amplitude)
    speed, amplitude, nonlinear = speed[inside], amplitude[inside], nonlinear[inside]
    chosen = largest(lines, speed, amplitude)
    return (
        np.full(len(chosen), float(order)),
        speed[chosen],
        speed[chosen] * order / 60,
        amplitude[chosen],
        nonlinear[chosen],
    )


def largest(lines: Lines, speed: Floats, amplitude: Floats) -> Integers:
    """Places of the largest amplitude in each of many narrow ranges of speed, rpm."""
    edges = np.linspace(lines.speeds[0], lines.speeds[-1], RANGES + 1)
    place = np.digitize(speed, edges[1:-1])
    each = (np.flatnonzero(place == i) for i in range(RANGES))
    return np.array([own[amplitude[own].argmax()] for own in each if len(own)], np.int64)


def _loading(study: Study) -> str:
    excitation = study.excitation
    if excitation.unbalance is not None:
        return f"unbalance of {1e6 * excitation.unbalance:.4g} g mm"
    return f"{excitation.force_per_node:.4g} N at each force node"
