"""The step to a response whose harmonics and frequencies are chosen while it is solved.

Which nodal diameters of the casing it takes is known at its end alone. The step may need all of
them, so its key holds all their keys; it pulls those that a point needs.
"""

from collections.abc import Callable
from typing import Any

from vanelock import nonlinear, rom
from vanelock.common.cyclic import folded
from vanelock.input.schema.study import Study
from vanelock.nonlinear import PointStore, Response
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.accuracy.budget import Budget
from vanelock.stages.accuracy.mesh_errors import MeshErrors
from vanelock.stages.parts.components import casing_step
from vanelock.stages.parts.nodal_diameters import LinearSteps
from vanelock.stages.parts.systems import united_step
from vanelock.stages.response.limits import frequencies
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.responses import Progress, frequency_keys


def adaptive_step(
    name: str,
    study: Study,
    budget: Budget,
    linear: LinearSteps,
    free: Step[Response],
    mesh: Step[MeshErrors],
    progress: Progress,
) -> Step[Response]:
    """Nonlinear response of a case to its budget."""
    N = study.ring.sectors
    casings = {k: casing_step(study, k) for k in range(N // 2 + 1)}
    base = united_step(study, 1)
    given = budget.accuracy
    shares = {key: budget.shares.get(key, given) for key in ("harmonics", "frequencies")}
    fixed: dict[str, Any] = {
        "harmonics": study.response.harmonics if "harmonics" in budget.pinned else None,
        "coupling": study.response.coupling,
        "samples": study.response.samples,
        "friction": study.response.friction,
    }
    inputs = {
        **frequency_keys(study),
        **fixed,
        "shares": shares,
        "monitor": study.outputs.monitor,
    }

    def compute(get: Callable[[Step[Any]], Any], store: PointStore) -> Response:
        limits, errors, system = get(linear.limits), get(mesh), get(base)
        watched = monitor(study.outputs.monitor, system, get(free))

        def systems(harmonics: int) -> System:
            found: System = get(united_step(study, harmonics))
            return found

        def neglected(nodal_diameter: int) -> Any:
            casing = get(casings[folded(nodal_diameter, N)])
            return rom.neglected_forms(get(linear.vane), casing, nodal_diameter)

        modal = linear.vane, linear.casing  # parts by number of modes may have none
        estimable = all(
            next(iter(get(part).diameters.values())).neglected is not None for part in modal
        )
        return nonlinear.adaptive_response(
            systems,
            frequencies(study, limits),
            nonlinear.Shares(**shares),
            nonlinear.Options(**fixed),
            monitor=(watched.node, watched.component),
            neglected=neglected if estimable else None,
            mesh_error=errors.at,
            progress=progress,
            store=store,
        )

    needs: tuple[Step[Any], ...] = (linear.limits, mesh, free, base, *casings.values())
    return step(
        "response", "nonlinear", inputs, Response, needs, compute, pulls=True, resumes=True, of=name
    )
