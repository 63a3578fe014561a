"""What a run will take, each to about a factor of two, before anything is computed.

Laws in degrees of freedom, cases and points, measured from coarse meshes to those of an accuracy of
1 % (docs/benchmarks/memory.md), on one core of a server of 2.5 to 3 GHz.

Cases of a sweep: peak so far and time left, and what is left of a case that fails.
"""

import math
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from vanelock.common import process
from vanelock.common.errors import FolderError
from vanelock.input.cases.sweep import Case
from vanelock.input.cases.values import Problem, diameters_of
from vanelock.input.schema.study import Study
from vanelock.mesh.geometry.dimensions import CasingDimensions, VaneDimensions
from vanelock.pipeline.progress import PointDone
from vanelock.pipeline.step import Stages
from vanelock.pipeline.tasks import ATTEMPTS, Failure, TaskFailed, failure_of
from vanelock.stages.accuracy.budget import budget, pins
from vanelock.stages.accuracy.mesh_sizes import most_dofs, peak_memory, unknowns

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis
    from vanelock.nonlinear import Response
    from vanelock.pipeline.step import Step
    from vanelock.stages.plan import Planned


TYPICAL = 100
"""Points of a response over a range that chooses them itself."""


class Clock:
    """Stopwatch over all cases of a run."""

    def __init__(self, planned: "Collection[Planned]") -> None:
        self._adaptive = any(getattr(each.case.problem, "accuracy", None) for each in planned)
        self._left = {
            step.key: _work(each.case.problem) for each in planned for step in each.responses
        }
        self._done = 0.0
        self._seconds = 0.0
        self._began = time.perf_counter()
        self._name, self._own, self._peak = "", 0.0, 0.0

    def begin(self, planned: "Planned", response: "Step[Response] | None" = None) -> None:
        """A case begins, or another of its responses."""
        self._name, self._peak = planned.case.name, 0.0
        self._own = self._left.pop((response or planned.response).key, 0.0)
        self._after = sum(self._left.values())
        self._began = time.perf_counter()

    def end(self, computed: bool) -> None:
        """It has its response, computed now or not."""
        if computed:
            self._seconds += time.perf_counter() - self._began
            self._done += self._own

    def point(self, done: int, total: int, frequency: float, amplitude: float) -> PointDone:
        """A point of it is solved; `amplitude` counts for the peak, m.

        It is NaN of one that is being looked for by ways that may take long. With an accuracy
        there are as many points as the errors ask for, which nobody knows before.
        """
        if amplitude != amplitude:
            known = None if self._adaptive else total
            return PointDone(self._name, done, known, self._peak, float("nan"), frequency)
        self._peak = max(self._peak, amplitude)
        if self._adaptive:
            return PointDone(self._name, done, None, self._peak, float("nan"))
        part = self._own * done / total
        pace = (self._seconds + time.perf_counter() - self._began) / max(self._done + part, 1e-9)
        left = pace * (self._own - part + self._after)
        return PointDone(self._name, done, total, self._peak, left)

    def count(self, done: int, total: int | None, amplitude: float) -> PointDone:
        """A step of the case's bounds or stability; its time left is not known."""
        peak = max(self._peak, amplitude) if amplitude == amplitude else self._peak
        return PointDone(self._name, done, total, peak, float("nan"))


def points_of(problem: Problem) -> int:
    """Points of a response, about."""
    response = problem.response
    return len(response.frequencies) if response.frequencies else response.points or TYPICAL


def _work(problem: Problem) -> float:
    """Relative cost of a response: the unknowns at a point grow with 2H + 1."""
    return float(points_of(problem) * (2 * problem.response.harmonics + 1) ** 1.5)


A = TypeVar("A")
C = TypeVar("C")


def attempt(compute: Callable[[A], C], planned: A, stages: Stages) -> C:
    """Compute something of a case of a sweep, twice if need be."""
    failure = Failure("")
    for tries in range(1, ATTEMPTS + 1):
        try:
            return compute(planned)
        except (TaskFailed, FolderError):
            raise
        except Exception as error:
            failure = replace(failure_of(error), attempts=tries)
            if failure.refused:
                break
            stages.retain(())  # what is kept is in the cache too, and memory may be short
    raise TaskFailed(failure)


UNITS = ((86400, "days"), (3600, "h"), (60, "min"), (1, "s"))


class CostEstimate(NamedTuple):
    """What a run takes: degrees of freedom, bytes of memory, seconds on one core, bytes on disk.

    And a warning where its accuracy asks for larger meshes than there may be, "" if not.
    """

    dofs: float
    memory: float
    seconds: float
    disk: float
    warning: str = ""

    def words(self) -> dict[str, str]:
        """Each in words."""
        size, unit = next((each for each in UNITS if self.seconds >= 2 * each[0]), UNITS[-1])
        time = f"{float(f'{self.seconds / size:.1g}'):.0f} {unit}"
        return {
            "unknowns": f"{float(f'{self.dofs:.2g}'):,.0f} degrees of freedom",
            "memory": f"{process.gigabytes(self.memory)} of memory",
            "time": f"{time} on one core",
            "disk": f"{process.gigabytes(self.disk)} on disk",
        }


LINEAR = 52.0
"""Seconds from meshes to reduced models at 168,000 degrees of freedom and four nodal diameters
(docs/benchmarks/reduction_cost.md), growing with their power of 1.15."""
DIAMETERS = 2.1
"""With an accuracy, over that: more nodal diameters one by one, and estimates of the mesh."""
POINTS, REST = 1.5e-3, 2.0
"""Seconds of a response over its `work`, and of a preload with what is written of a case."""
DIAMETER = 0.12
"""Of `LINEAR`, what each further nodal diameter of the casing takes."""
PICTURES = 5.0
"""Seconds of the pictures of a case at 27,000 degrees of freedom, growing with their square root;
no more than four cases have all of them."""
KEPT, OF_DOF, OF_CASE = 0.1e9, 3.5e3, 3.3e6
"""Bytes on disk: of pictures and page, of a degree of freedom, and of a case of three harmonics."""
COARSE_ERROR, ORDER = {"none": 0.07, "modal": 0.027}, 0.65
"""Estimated error of the peak by the example's coarse mesh, by `mesh.correction`, and the power of
its degrees of freedom with which it falls on finer ones (docs/benchmarks/memory.md)."""
LOOKED_AT = 50
"""Cases that the estimate is made of, evenly taken."""


def estimated(
    cases: Sequence[Case],
    memory: float | None = None,
    mesh_dofs: Mapping[str, int] | None = None,
    analyses: "Sequence[Analysis[Any, Any]]" = (),
) -> CostEstimate | None:
    """What a run of some cases takes, where their meshes are known from dimensions."""
    chosen = [case.study for case in cases[:: math.ceil(len(cases) / LOOKED_AT)]]
    dimensions = VaneDimensions, CasingDimensions
    parts = [part for study in chosen for part in (study.vane, study.casing)]
    if mesh_dofs is None and not all(isinstance(part, dimensions) for part in parts):
        return None
    kept = {"mesh", "vane", "casing", "ring", "rom", "material", "accuracy"}  # but for diameters
    meshed = {study.model_dump_json(include=kept): study for study in chosen}
    sizes = [_dofs(study, memory, mesh_dofs or {}) for study in meshed.values()]
    largest, part = max(sizes), len(sizes) / len(chosen)
    meshes = 1.0 if len(sizes) == 1 else part * len(cases)
    linear = DIAMETERS if chosen[0].accuracy is not None else 1.0
    asked = [[(a, keys) for a in analyses if (keys := a.keys_of(s)) is not None] for s in chosen]
    if any(analysis.whole_ring(chosen[0], keys) for analysis, keys in asked[0]):
        linear += DIAMETER * (chosen[0].ring.sectors // 2 + 1 - len(diameters_of(chosen[0])))
    seconds = meshes * linear * LINEAR * (largest / 168e3) ** 1.15
    each = 0.0
    for study, own_analyses in zip(chosen, asked, strict=True):
        curve = POINTS * _work(study)
        each += REST + curve + sum(a.cost(study, keys, curve) for a, keys in own_analyses)
    seconds += len(cases) * each / len(chosen)
    if {"shapes", "loops"} & {*chosen[0].outputs.show}:
        seconds += PICTURES * min(len(cases), 4) * math.sqrt(largest / 27e3)
    harmonics = sum(study.response.harmonics for study in chosen) / len(chosen)
    disk = KEPT + meshes * OF_DOF * largest + len(cases) * OF_CASE * (2 * harmonics + 1) / 7
    warning = next(filter(None, (_out_of_reach(study, memory) for study in chosen)), "")
    return CostEstimate(largest, peak_memory(largest), seconds, disk, warning)


def _dofs(study: Study, memory: float | None, mesh_dofs: Mapping[str, int]) -> float:
    """Degrees of freedom of a case; those that an accuracy chooses by the errors of others."""
    if not _chooses_mesh(study):
        return unknowns(study, study.mesh.size, mesh_dofs)
    return float(min(_wanted(study), most_dofs(memory)))


def _chooses_mesh(study: Study) -> bool:
    return study.accuracy is not None and "mesh" not in pins(study)


def _wanted(study: Study) -> float:
    """Degrees of freedom at which the mesh's error is about its share of a case's accuracy."""
    error = COARSE_ERROR[study.mesh.correction]
    finer = max(error / budget(study).shares["mesh"], 1.0) ** (1 / ORDER)
    return float(unknowns(study, "coarse") * finer)


def _out_of_reach(study: Study, limit: float | None) -> str:
    """A warning where the meshes that an accuracy takes are larger than may be chosen."""
    if not _chooses_mesh(study) or (wanted := _wanted(study)) <= (most := most_dofs(limit)):
        return ""
    left = study.accuracy * (wanted / most) ** ORDER if study.accuracy else 0.0
    return (
        f"accuracy = {study.accuracy:g} asks for meshes of about {float(f'{wanted:.1g}'):,.0f} "
        f"degrees of freedom and {process.gigabytes(peak_memory(wanted))} of memory; the largest "
        f"that are chosen here have {float(f'{most:.2g}'):,.0f} and leave an error of about "
        f"{left:.2g}"
    )
