"""The step to a response whose harmonics and frequencies are chosen while it is solved.

Which nodal diameters of the casing it takes is known at its end alone. The step may need all of
them, so its key holds all their keys; it pulls those that a point needs.
"""

from collections.abc import Callable
from typing import Any

from vanelock import nonlinear, rom
from vanelock.input.cases.values import diameter_of, diameters_of
from vanelock.nonlinear import PointStore, Response
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.accuracy.budget import Budget
from vanelock.stages.accuracy.mesh_errors import MeshErrors
from vanelock.stages.linear import Linear
from vanelock.stages.response.limits import frequencies
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.responses import Progress, frequency_keys
from vanelock.stages.structure import CaseStructure


def adaptive_step(
    name: str,
    structure: CaseStructure,
    budget: Budget,
    linear: Linear,
    free: Step[Response],
    mesh: Step[MeshErrors],
    progress: Progress,
) -> Step[Response]:
    """Nonlinear response of a case to its budget."""
    study, base = structure.given, structure.system(structure.loaded)
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
            found: System = get(structure.system(diameters_of(study, harmonics)))
            return found

        def neglected(nodal_diameter: int) -> Any:
            k = nodal_diameter
            parts = {name: get(structure.component(name, k)) for name in structure.names}
            return rom.neglected_forms(get(structure.system([k])), parts, k)

        k = diameter_of(study, 1)
        modal = [get(structure.component(name, k)) for name in structure.names]
        # parts by number of modes may have none
        estimable = all(part.at(k).neglected is not None for part in modal)
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

    needs: tuple[Step[Any], ...] = (linear.limits, mesh, free, base)
    needs += structure.reduced(structure.every_diameter)
    return step(
        "response", "nonlinear", inputs, Response, needs, compute, pulls=True, resumes=True, of=name
    )
