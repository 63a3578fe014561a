"""Steps behind the reduced models: linear limits, preload, linear and nonlinear responses."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, TypeAlias

import numpy as np

from vanelock import nonlinear
from vanelock.input.schema.study import Study
from vanelock.nonlinear import HarmonicModes, Journal, Response
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import Component, System
from vanelock.stages.parts.components import system_step
from vanelock.stages.response.limits import Limits, dense, frequencies, hooks, limits

Limit: TypeAlias = Literal["free", "stuck"]
FIRST = {"up": "up", "down": "down", "both": "up"}
"""Direction of the first sweep, by `response.direction`."""
Progress: TypeAlias = Callable[[int, int, float, float], None]

READ = ("rom", "excitation", "damping", "response", "campbell")
"""Tables of a study that the frequencies of its responses follow from, with its linear limits."""


def silent_progress(done: int, total: int, frequency: float, amplitude: float) -> None:
    """Tell nobody."""


def linear_system_step(
    study: Study, vane: Step[Component], casing: Step[Component]
) -> Step[System]:
    """The system without friction and preload, which the linear limits do not depend on."""
    return system_step(without_friction(study), vane, casing)


def limits_step(
    study: Study, system: Step[System], vane: Step[Component], casing: Step[Component]
) -> Step[Limits]:
    """Modes with the interlock free and stuck, and their errors."""
    return _limits(study.response.mode, system, vane, casing)


@lru_cache(maxsize=SHARED)
def _limits(
    mode: int, system: Step[System], vane: Step[Component], casing: Step[Component]
) -> Step[Limits]:
    def compute(system: System, vane: Component, casing: Component) -> Limits:
        return limits(system, mode, vane, casing)

    needs = (system, vane, casing)
    return step("linear limits", "rom", {"mode": mode}, Limits, needs, compute)


@lru_cache(maxsize=SHARED)
def preload_step(friction: str, system: Step[System]) -> Step[Response]:
    """The state at rest."""

    def compute(system: System) -> Response:
        return nonlinear.static_response(system, nonlinear.Options(friction=friction))

    return step("preload", "nonlinear", {"friction": friction}, Response, (system,), compute)


@lru_cache(maxsize=SHARED)
def stuck_modes_step(system: Step[System], harmonics: int) -> Step[HarmonicModes]:
    """Modes with all contacts stuck, shared by cases whose system is this one but for friction.

    They are large, and reading them takes about as long as making them: they are not kept.
    """

    def compute(system: System) -> HarmonicModes:
        return nonlinear.harmonic_modes(system, harmonics)

    inputs = {"harmonics": harmonics}
    kind, needs = HarmonicModes, (system,)
    return step("stuck modes", "nonlinear", inputs, kind, needs, compute, kept=False, quick=True)


def linear_step(
    study: Study, which: Limit, system: Step[System], limits: Step[Limits]
) -> Step[Response]:
    """Linear response with the interlock free or stuck, dense enough to be drawn as a curve."""
    return _linear(which, _Alike(study), system, limits)


@dataclass(frozen=True, eq=False)
class _Alike:
    """A study that equals another if both have the same frequencies of the same limits."""

    study: Study

    @property
    def _read(self) -> tuple[Any, ...]:
        return tuple(getattr(self.study, name) for name in READ)

    def __hash__(self) -> int:
        return hash(self._read)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Alike) and self._read == other._read


@lru_cache(maxsize=SHARED)
def _linear(
    which: Limit, alike: _Alike, system: Step[System], limits: Step[Limits]
) -> Step[Response]:
    study = alike.study
    inputs = {**frequency_keys(study), "closed": which}

    def compute(system: System, found: Limits) -> Response:
        closed = (
            hooks(system.contacts.joint)
            if which == "free"
            else np.ones(system.contacts.count, bool)
        )
        wanted = frequencies(study, found)
        grid = dense(wanted, found, which == "stuck", study.damping.ratio)
        return nonlinear.linear_response(system, grid, closed)

    return step(
        f"linear response, {which}", "nonlinear", inputs, Response, (system, limits), compute
    )


def response_step(
    name: str,
    study: Study,
    system: Step[System],
    limits: Step[Limits],
    modes: Step[HarmonicModes],
    progress: Progress,
    direction: str | None = None,
) -> Step[Response]:
    """Nonlinear response of a case; over a range, where its curve needs points.

    In the study's direction, or the given one; upwards where the study wants both.
    """
    options: dict[str, Any] = {
        "harmonics": study.response.harmonics,
        "coupling": study.response.coupling,
        "samples": study.response.samples,
        "friction": study.joints.friction,
        "harmonic_diameters": study.response.harmonic_diameters,
        "direction": direction or FIRST[study.response.direction],
    }
    inputs = {**frequency_keys(study), **options}

    def compute(system: System, found: Limits, stuck: HarmonicModes, journal: Journal) -> Response:
        wanted = frequencies(study, found)
        return nonlinear.frequency_response(
            system, wanted, nonlinear.Options(**options), progress, stuck.diameters, journal
        )

    needs = (system, limits, modes)
    of = name + (", down" if options["direction"] == "down" else "")
    return step("response", "nonlinear", inputs, Response, needs, compute, resumes=True, of=of)


def frequency_keys(study: Study) -> dict[str, Any]:
    """What the choice of frequencies depends on, beside the linear limits."""
    apart = {"harmonics", "mode", "coupling", "samples", "harmonic_diameters", "direction"}
    return study.response.model_dump(exclude=apart)


def without_friction(study: Study) -> Study:
    """The study of the linear limits: no friction, no interference."""
    joints = study.joints.model_copy(
        update={
            name: getattr(study.joints, name).model_copy(update={"mu": 0.0, "interference": 0.0})
            for name in ("hook", "interlock")
        }
    )
    return study.model_copy(update={"joints": joints})


def without_load(study: Study) -> Study:
    """The study of the modes with all contacts stuck: no friction, and the default load."""
    load = study.excitation.model_copy(update={"force": None, "unbalance": None})
    return without_friction(study).model_copy(update={"excitation": load})


def is_loaded(study: Study) -> bool:
    """Whether a study has another load than the default one."""
    return (study.excitation.force, study.excitation.unbalance) != (None, None)
