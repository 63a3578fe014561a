"""A scene run to an accuracy, stage by stage as `vanelock run` does, pictures left out."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.accuracy.models import Prepared
from benchmarks.accuracy.runs import Outcome, outcome
from benchmarks.accuracy.scenes import Scene
from vanelock import Study
from vanelock.input.cases.sweep import cases
from vanelock.nonlinear import Response, peak_errors
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.stages.accuracy.choose_mesh import choose_mesh
from vanelock.stages.accuracy.mesh_sizes import most_dofs
from vanelock.stages.plan import Planned, plan
from vanelock.stages.response.limits import frequencies
from vanelock.stages.response.responses import monitor


@dataclass(frozen=True)
class Solved:
    """A study solved: its system and range, its response, and its steps."""

    given: Prepared
    response: Response
    planned: Planned


def solved(study: Study, stages: Stages, memory: float | None = None) -> Solved:
    """Run a study's one case up to its response, with meshes that so many bytes hold."""
    (case,) = cases(study)
    most = most_dofs(memory)
    choice = None if study.accuracy is None else choose_mesh(case.study, stages, most)
    (planned,) = plan([case], choices=[choice])
    response = stages.get(planned.response)
    planned = planned.solved(response)
    return Solved(framed(planned, stages), response, planned)


def framed(planned: Planned, stages: Stages) -> Prepared:
    """The system of a case with its range and its monitored output."""
    limits, system = stages.get(planned.linear.limits), stages.get(planned.system)
    wanted = frequencies(planned.case.study, limits)
    assert isinstance(wanted, tuple)
    watched = monitor(None, system, stages.get(planned.linear.responses["free"]))
    return Prepared(system, wanted, watched, limits)


def asked(scene: Scene, accuracy: float, folder: Path) -> Outcome:
    """Run a scene to an accuracy; scenes of a design share the parts that are reduced alike."""
    own = folder / f"design_{scene.design}"
    stages = Stages(Cache(own / "cache", print), silent)
    done = solved(scene.study(accuracy=accuracy), stages)
    sources, amplitude, frequency = stated(done.response)
    assert done.response.estimates is not None
    return outcome(
        scene,
        f"asked_{accuracy:g}",
        done.given,
        done.response,
        done.response.estimates.harmonics,
        rom=spent(stages, "rom"),
        response=spent(stages, "response", "mesh errors"),
        diameters=len(done.planned.diameters),
        amplitude_estimate=amplitude,
        frequency_estimate=frequency,
        sources=sources,
    )


def stated(response: Response) -> tuple[dict[str, float], float, float]:
    """Estimated relative errors of the peak: of its amplitude by source, and in all of both."""
    found = peak_errors(response)
    sources = {
        name: float(error)
        for name, error in found.amplitude_error.items()
        if np.isfinite(error) and name != "mesh"  # it is pinned: no part of the accuracy
    }
    told = [
        float(error)
        for name, error in found.frequency_error.items()
        if np.isfinite(error) and name != "mesh"
    ]
    return sources, sum(sources.values()), sum(told)


def spent(stages: Stages, *names: str) -> float:
    """CPU seconds of the stages of these names, of a cached one when it was computed."""
    return sum(
        stages.cpu.get(key, 0.0)
        for key, done in stages.done.items()
        if done.stage.startswith(names)
    )
