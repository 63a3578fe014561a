"""Steps behind the reduced models: linear limits, preload, linear and nonlinear responses."""

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.nonlinear import Response
from vanelock.rom import Component, System
from vanelock.study.limits import Limits, fine, frequencies, hooks, limits
from vanelock.study.model import Study
from vanelock.study.stages import Step, step, system_step

Limit: TypeAlias = Literal["free", "stuck"]
Progress: TypeAlias = Callable[[int, int, float, float], None]

REFINED = 7
"""Points added in each interval beside the largest point of a nonlinear response."""
_CONSTANT = (
    "stiffness",
    "mu",
    "harmonic_diameters",
)  # what a response does not have point by point


def linear_system_step(
    study: Study, vane: Step[Component], casing: Step[Component]
) -> Step[System]:
    """The system without friction and preload, which the linear limits do not depend on."""
    return system_step(_without_friction(study), vane, casing)


def limits_step(study: Study, system: Step[System]) -> Step[Limits]:
    """Modes with the interlock free and stuck."""
    mode = study.response.mode

    def compute(system: System) -> Limits:
        return limits(system, mode)

    return step("linear limits", "rom", {"mode": mode}, Limits, (system,), compute)


def preload_step(system: Step[System]) -> Step[Response]:
    """The state at rest."""
    return step("preload", "nonlinear", {}, Response, (system,), nonlinear.static_response)


def linear_step(
    study: Study, which: Limit, system: Step[System], limits: Step[Limits]
) -> Step[Response]:
    """Linear response with the interlock free or stuck, finer around the mode of interest."""
    inputs = {**_frequency_keys(study), "closed": which}

    def compute(system: System, found: Limits) -> Response:
        closed = (
            hooks(system.contacts.joint)
            if which == "free"
            else np.ones(system.contacts.count, bool)
        )
        centre = found.free_frequency if which == "free" else found.stuck_frequency
        own = fine(centre, study.damping.ratio)
        return nonlinear.linear_response(
            system, np.unique(np.concatenate([frequencies(study, found), own])), closed
        )

    return step(
        f"linear response, {which}", "nonlinear", inputs, Response, (system, limits), compute
    )


def response_step(
    name: str, study: Study, system: Step[System], limits: Step[Limits], progress: Progress
) -> Step[Response]:
    """Nonlinear response of a case, with more points beside its peak on a grid of our own."""
    harmonics = study.response.harmonics
    inputs = {**_frequency_keys(study), "harmonics": harmonics, "refined": REFINED}

    def compute(system: System, found: Limits) -> Response:
        grid = frequencies(study, found)
        total = len(grid) + (0 if study.response.frequencies else 2 * REFINED)

        def tell(done: int, count: int, frequency: float, amplitude: float) -> None:
            progress(done, total, frequency, amplitude)

        response = nonlinear.frequency_response(system, grid, harmonics, progress=tell)
        if study.response.frequencies is not None:
            return response
        return refined(system, response, harmonics)

    return step(f"response {name}", "nonlinear", inputs, Response, (system, limits), compute)


def refined(system: System, response: Response, harmonics: int) -> Response:
    """The response with more points on both sides of its largest one.

    The new points start from the one before them again. Where that does not lead to the same
    solution there (several exist between folds), the response is left as it was.
    """
    size = np.where(response.converged, response.amplitude.max(axis=(1, 2)), -1.0)
    top = int(size.argmax())
    if size[top] < 0 or not 0 < top < response.points - 1:
        return response
    low, middle, high = response.frequency[top - 1 : top + 2]
    between = [np.linspace(a, b, REFINED + 2)[:-1] for a, b in ((low, middle), (middle, high))]
    added = nonlinear.frequency_response(system, np.concatenate(between), harmonics)
    places = [0, REFINED + 1]
    same = np.allclose(
        added.amplitude[places],
        response.amplitude[[top - 1, top]],
        rtol=1e-6,
        atol=1e-6 * float(size[top]),
    )
    if not (same and added.converged.all()):
        return response
    old = np.setdiff1d(np.arange(response.points), [top - 1, top])
    points = np.concatenate([old, response.points + np.arange(added.points)])
    both = np.concatenate([response.frequency, added.frequency])
    return chosen([response, added], points[both[points].argsort()])


def chosen(responses: Sequence[Response], points: NDArray[np.int64]) -> Response:
    """Some points of the responses of one system put end to end, in the order given."""
    changed: dict[str, Any] = {}
    for field in fields(Response):
        values = [getattr(response, field.name) for response in responses]
        if isinstance(values[0], dict):
            changed[field.name] = {
                key: np.concatenate([value[key] for value in values])[points] for key in values[0]
            }
        elif field.name not in _CONSTANT:
            changed[field.name] = np.concatenate(values)[points]
    return replace(responses[0], **changed)


def _frequency_keys(study: Study) -> dict[str, Any]:
    """What the choice of frequencies depends on, beside the linear limits."""
    return study.response.model_dump(exclude={"harmonics", "mode"})


def _without_friction(study: Study) -> Study:
    joints = study.joints.model_copy(
        update={
            name: getattr(study.joints, name).model_copy(update={"mu": 0.0, "interference": 0.0})
            for name in ("hook", "interlock")
        }
    )
    return study.model_copy(update={"joints": joints})
