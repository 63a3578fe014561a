"""What an analysis of a case begins from, and the steps that make its products."""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias, TypeVar, cast

from vanelock.analyses import ANALYSES
from vanelock.analyses.analysis import ALLOWED, Analysis, AnalysisPart, asked_for
from vanelock.common.arrays import Floats
from vanelock.common.files.digests import content_digest
from vanelock.common.product import Product
from vanelock.input.cases.values import Problem
from vanelock.nonlinear import Options, Response
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.parts.outputs import Places, places
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limits, frequencies
from vanelock.stages.response.responses import Monitor, as_solved, frequency_keys, monitor
from vanelock.stages.response.summary import Peak, by_height, peak_of

P = TypeVar("P", bound=Product)
Count: TypeAlias = Callable[[int, int | None, float], None]
"""Called with how many are done, of how many where that is known, and an amplitude, m, or NaN."""


@dataclass(frozen=True)
class SolvedCase:
    """A case with its responses; each product is read when it is first asked for."""

    planned: Planned
    """Its steps, those of the analyses before this one included."""
    monitoring: Planned
    """The run's first case, whose linear response says which displacement is monitored."""
    get: Callable[[Step[Any]], Any]
    """The product of a step."""
    count: Count
    """Called with the progress."""

    @property
    def problem(self) -> Problem:
        """What its file says."""
        return self.planned.case.problem

    @cached_property
    def monitored(self) -> Monitor:
        """The displacement that stands for the vibration."""
        linear = self.monitoring.linear
        free = self.get(linear.responses["free"])
        return monitor(self.problem.outputs.monitor, self.get(linear.system), free)

    @cached_property
    def responses(self) -> list[Response]:
        """Its responses in the order of its steps."""
        return [self.get(each) for each in self.planned.responses]

    @cached_property
    def response(self) -> Response:
        """The one with the higher peak."""
        return by_height(self.responses, self.monitored)[0]

    @cached_property
    def peak(self) -> Peak | None:
        """Its largest point; None where none converged."""
        return self.peak_of(self.response)

    def peak_of(self, response: Response) -> Peak | None:
        """The largest point of a response; None where none converged."""
        return peak_of(response, self.monitored.amplitude(response))

    @cached_property
    def options(self) -> Options:
        """Those that the peak is solved with, its number of harmonics above all."""
        response = self.response
        at_peak = response if self.peak is None else as_solved(response, self.peak.point)
        return Options(
            harmonics=at_peak.harmonics,
            friction=response.friction,
            direction="down" if response.direction == "down" else "up",
        )

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest frequency of the response, Hz."""
        frequency = self.response.frequency
        return float(frequency.min()), float(frequency.max())

    @cached_property
    def system(self) -> System:
        """Its system, at the nodal diameters that the response takes."""
        return cast(System, self.get(self.planned.solved(self.response).system))

    @cached_property
    def whole(self) -> System:
        """The same at all nodal diameters."""
        return cast(System, self.get(self.planned.structure.whole))

    def system_at(self, diameters: Sequence[int]) -> System:
        """A system that has some nodal diameters beside those of the response."""
        used = self.planned.solved(self.response).diameters
        return cast(System, self.get(self.planned.structure.system({*used, *diameters})))

    @cached_property
    def modes(self) -> Any:
        """Modes with all contacts stuck that the response takes, by nodal diameter."""
        return self.get(self.planned.modes).diameters

    @cached_property
    def frequencies(self) -> Floats | tuple[float, float]:
        """Those that its file asks for, Hz, or the ends of the range."""
        limits: Limits = self.get(self.planned.linear.limits)
        return frequencies(self.problem, limits)

    @cached_property
    def places(self) -> Places:
        """Its contacts."""
        mesh = self.planned.meshes.get("vane")
        vane = None if mesh is None else self.get(mesh)
        return places(self.problem, self.system.contacts, vane)

    def progress(self, done: int, total: int, *values: float) -> None:
        """How far an analysis is; for what the solver calls."""
        self.count(done, total, float("nan"))

    def product(self, key: str, part: int) -> Any:
        """A product of an analysis before this one."""
        return self.get(self.planned.analyses[key][part])


def with_analyses(planned: Planned, monitoring: Planned, count: Count = lambda *_: None) -> Planned:
    """A case with the steps of all analyses that its file asks for."""
    given = planned.case.problem
    for analysis in ANALYSES:
        if analysis.step is not None and (shared := analysis.step(planned)) is not None:
            analysed = {**planned.analyses, analysis.key: (shared,)}
            planned = replace(planned, analyses=analysed)
    analysable = all(getattr(given.response, key) == value for key, value in ALLOWED.items())
    for analysis, keys in asked_for(ANALYSES, given):
        if not (analysis.any_law or analysable):
            continue
        parts = analysis.parts(given, keys)
        if analysis.by_response:
            parts = [AnalysisPart(response=i) for i in range(len(planned.responses))]
        steps = tuple(_step(analysis, keys, each, planned, monitoring, count) for each in parts)
        pieces: tuple[Step[Any], ...] = ()
        if analysis.combine is not None:
            steps, pieces = (_combined(analysis, steps, planned, count),), steps
        planned = replace(
            planned,
            analyses={**planned.analyses, analysis.key: steps},
            pieces=(*planned.pieces, *pieces),
        )
    return planned


def _step(
    analysis: Analysis[Any, P],
    keys: Any,
    part: AnalysisPart,
    planned: Planned,
    monitoring: Planned,
    count: Count,
) -> Step[P]:
    """One part of an analysis of a case."""
    given, linear, solve = planned.case.problem, monitoring.linear, analysis.compute
    assert solve is not None
    assert analysis.product is not None
    own = given.response.model_dump(include={"harmonics", "friction", "direction"})
    inputs = {
        **keys.model_dump(),
        **frequency_keys(given),
        **part.inputs,
        "response": {**own, "number": part.response if analysis.by_response else None},
        "monitor": given.outputs.monitor,
        "code": content_digest(inspect.getfile(solve)),
    }

    def compute(get: Callable[[Step[Any]], Any]) -> P:
        return solve(SolvedCase(planned, monitoring, get, count), keys, part)

    needs: list[Step[Any]] = [planned.system, *planned.responses, planned.linear.limits]
    needs += [linear.system, linear.responses["free"], planned.modes, *planned.meshes.values()]
    if analysis.whole_ring(given, keys):
        needs.append(planned.structure.whole)
    needs += analysis.needs(planned, keys)
    needs += (each for name in analysis.after for each in planned.analyses.get(name, ()))
    of = " ".join(filter(None, (planned.case.name, part.label)))
    return step(
        analysis.key.replace("_", " "),
        "nonlinear",
        inputs,
        analysis.product(),
        tuple(needs),
        compute,
        pulls=True,
        of=of,
        quick=analysis.combine is not None,
    )


def _combined(
    analysis: Analysis[Any, Any], parts: tuple[Step[Any], ...], planned: Planned, count: Count
) -> Step[Any]:
    """What is shown of the parts of an analysis."""
    combine = analysis.combine
    assert combine is not None

    def compute(get: Callable[[Step[Any]], Any]) -> Product:
        found = []
        for each in parts:
            found.append(get(each))
            count(len(found), len(parts), float("nan"))
        return combine(found)

    stage, of, inputs = f"{analysis.key} in all", planned.case.name, {"parts": len(parts)}
    return step(stage, "nonlinear", inputs, Product, parts, compute, False, pulls=True, of=of)
