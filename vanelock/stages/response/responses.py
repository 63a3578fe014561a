"""Steps behind the reduced models: linear limits, preload, linear and nonlinear responses."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np

from vanelock import nonlinear
from vanelock.input.cases.values import Given
from vanelock.input.schema.scene import DAMPING
from vanelock.nonlinear import HarmonicModes, PointStore, Response, StaticBounds
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import System
from vanelock.stages.response.limits import Limit, Limits, dense, frequencies, limits

SHARPEST = 1e-6
"""Smallest damping ratio of a mode that a linear response resolves."""
FIRST = {"up": "up", "down": "down", "both": "up"}
"""Direction of the first sweep, by `response.direction`."""
Progress: TypeAlias = Callable[[int, int, float, float], None]

READ = ("rom", "excitation", "damping", "response", "campbell")
"""Tables that the frequencies of responses follow from, with the linear limits; a scene lacks two.
"""


def silent_progress(done: int, total: int, frequency: float, amplitude: float) -> None:
    """Say nothing."""


@lru_cache(maxsize=SHARED)
def limits_step(
    mode: int,
    system: Step[System],
    names: tuple[str, ...] = (),
    parts: tuple[Step[Any], ...] = (),
    meshed: Step[System] | None = None,
) -> Step[Limits]:
    """Modes with contacts free and stuck, and their errors by the reduced `parts` and their names.

    A system that is corrected comes with what it was as `meshed`.
    """

    def compute(system: System, *others: Any) -> Limits:
        own = dict(zip(names, others[: len(parts)], strict=True))
        return limits(system, mode, own, *others[len(parts) :])

    needs = (system, *parts, *(() if meshed is None else (meshed,)))
    return step("linear limits", "rom", {"mode": mode}, Limits, needs, compute)


@lru_cache(maxsize=SHARED)
def preload_step(friction: str, system: Step[System], modes: Step[HarmonicModes]) -> Step[Response]:
    """The state at rest; `modes` of harmonic 0 at least."""

    def compute(system: System, stuck: HarmonicModes) -> Response:
        options = nonlinear.Options(friction=friction)
        return nonlinear.static_response(system, options, stuck.diameters)

    needs = (system, modes)
    return step("preload", "nonlinear", {"friction": friction}, Response, needs, compute)


@lru_cache(maxsize=SHARED)
def static_bounds_step(
    friction: str, system: Step[System], modes: Step[HarmonicModes]
) -> Step[StaticBounds]:
    """Between which loads undetermined static friction may hold, at rest, joints that may open."""

    def compute(system: System, stuck: HarmonicModes) -> StaticBounds:
        contacts = system.contacts
        opens = [name for name in contacts.joints if name not in contacts.always_closed]
        options = nonlinear.Options(friction=friction)
        return nonlinear.static_bounds(system, opens, options=options, modes=stuck.diameters)

    inputs = {"friction": friction}
    return step("static bounds", "nonlinear", inputs, StaticBounds, (system, modes), compute)


def linear_step(
    given: Given,
    which: Limit,
    system: Step[System],
    limits: Step[Limits],
    modes: Step[HarmonicModes],
) -> Step[Response]:
    """Linear response with contacts free or stuck, dense enough to be drawn as a curve."""
    return _linear(which, _Alike(given), system, limits, modes)


@dataclass(frozen=True, eq=False)
class _Alike:
    """A study or scene that equals another with the same frequencies of the same limits."""

    given: Given

    @property
    def _read(self) -> tuple[Any, ...]:
        return tuple(getattr(self.given, name, None) for name in READ)

    def __hash__(self) -> int:
        return hash(self._read)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Alike) and self._read == other._read


@lru_cache(maxsize=SHARED)
def _linear(
    which: Limit,
    alike: _Alike,
    system: Step[System],
    limits: Step[Limits],
    modes: Step[HarmonicModes],
) -> Step[Response]:
    given = alike.given
    inputs = {**frequency_keys(given), "closed": which}

    def compute(system: System, found: Limits, stuck: HarmonicModes) -> Response:
        closed = ~system.contacts.opens if which == "free" else "all"
        ratio = system.damping_ratio or DAMPING
        if which == "stuck" and system.opens_in_damping.any():  # its peak is the sharper one
            ratio = float(np.fmax(found.stuck_damping, SHARPEST))
        grid = dense(frequencies(given, found), found, which == "stuck", ratio)
        highest = max([1, *system.force])
        return nonlinear.linear_response(system, grid, closed, highest, stuck.diameters)

    name = f"linear response, {which}"
    return step(name, "nonlinear", inputs, Response, (system, limits, modes), compute)


def response_step(
    name: str,
    given: Given,
    system: Step[System],
    limits: Step[Limits],
    modes: Step[HarmonicModes],
    progress: Progress,
    direction: str | None = None,
) -> Step[Response]:
    """Nonlinear response of a case; over a range, where its curve needs points.

    In the file's direction, or another one; upwards where the file wants both.
    """
    response = given.response
    options: dict[str, Any] = {
        "harmonics": response.harmonics,
        "coupling": response.coupling,
        "samples": response.samples,
        "friction": response.friction,
        "direction": direction or FIRST[response.direction],
    }
    inputs = {**frequency_keys(given), **options}

    def compute(system: System, found: Limits, stuck: HarmonicModes, store: PointStore) -> Response:
        wanted = frequencies(given, found)
        return nonlinear.frequency_response(
            system, wanted, nonlinear.Options(**options), progress, stuck.diameters, store
        )

    needs = (system, limits, modes)
    of = name + (", down" if options["direction"] == "down" else "")
    return step("response", "nonlinear", inputs, Response, needs, compute, resumes=True, of=of)


def frequency_keys(given: Given) -> dict[str, Any]:
    """What the choice of frequencies depends on, beside the linear limits."""
    return given.response.model_dump(include={"frequencies", "range", "points"})
