"""What is stored of a case, by its place: made by steps while a run goes on, later read back.

response, lower, preload, system, limits, free, stuck      of the solver; `lower` is the other
                                                           direction of a sweep
mesh/<part>, rom/<part>, component/<name>, gauges          of the structure
<analysis>.<number>                                        of analyses
fields, <analysis>/<state>/fields, mode_shapes, audit, sensitivities, neglected,
mesh_doubt, mesh_error, curves                             of what is shown of the peak

What is drawn of a case's responses, and between which curves these may lie.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np

from vanelock import nonlinear
from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.product import Product
from vanelock.input.cases.values import diameter_of
from vanelock.nonlinear import Audit, Response
from vanelock.pipeline.cache import key_of
from vanelock.pipeline.step import Stages, Step, step
from vanelock.quantities.sensitivities import sensitivities_step
from vanelock.quantities.stress.fields import fields_step, mode_shapes_step
from vanelock.stages.accuracy.evidence import (
    amplitude_errors_of,
    neglected_harmonics_step,
    of_own_meshes,
)
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import LIMITS
from vanelock.stages.response.responses import Monitor, as_solved, drawn
from vanelock.stages.response.summary import Peak

if TYPE_CHECKING:
    from vanelock.quantities.case_result import CaseResult


T = TypeVar("T")
_ALWAYS = ("response", "lower", "preload", "system", "limits", "mesh/", "rom/", "component/")
"""How places begin that are stored of every case."""
_AUDITED = 2**14
"""Samples of the period at which a peak is marched again."""


class Products(ABC):
    """Products of a case by their places."""

    def __init__(self, shared: dict[str, Any]) -> None:
        self.made: dict[str, Any] = {}
        """What follows from them, once made."""
        self.shared = shared
        """What cases of a run share."""

    @abstractmethod
    def __contains__(self, path: str) -> bool: ...

    @abstractmethod
    def get(self, path: str) -> Any:
        """The product of a place."""

    @abstractmethod
    def key(self, path: str) -> str:
        """Hash of all that it depends on."""

    def once(self, path: str, make: Callable[[], T]) -> T:
        """What follows from products, made when it is first asked for."""
        if path not in self.made:
            self.made[path] = make()
        found: T = self.made[path]
        return found

    def of_analysis(self, analysis: str) -> list[str]:
        """Places of an analysis' products."""
        places: list[str] = []
        while (place := f"{analysis}.{len(places)}") in self:
            places.append(place)
        return places

    @abstractmethod
    def expect(self, path: str, response: Response, of: str) -> None:
        """Let fields of a response with one point, which follows from an analysis, be asked for."""

    def stored(self) -> list[str]:
        """Places of all that the results file is to hold, as known so far."""
        return []


class StepProducts(Products):
    """Those that steps make.

    Attributes
    ----------
    planned : Planned
        The steps, as solved.
    stages : Stages
        What runs them.
    """

    def __init__(
        self,
        planned: Planned,
        stages: Stages,
        monitor: Monitor,
        peak: Peak | None,
        shared: dict[str, Any],
    ) -> None:
        super().__init__(shared)
        self.planned, self.stages = planned, stages
        self._monitor, self._peak = monitor, peak
        self._steps: dict[str, Step[Any] | None] = {**_steps(planned)}
        self._asked: dict[str, None] = {}
        self._given: dict[str, Product] = {}

    def __contains__(self, path: str) -> bool:
        return path in self._given or self._step(path) is not None

    def stored(self) -> list[str]:
        """Places of all that is known before the peak, and of what was asked for."""
        solved = [e for e in self._steps if e.startswith(_ALWAYS) or "." in e]
        return [*dict.fromkeys([*solved, *self._asked]), *self._given]

    def get(self, path: str) -> Any:
        """The product of a place."""
        if path in self._given:
            return self._given[path]
        found = self._step(path)
        assert found is not None
        self._asked[path] = None
        return self.stages.get(found)

    def key(self, path: str) -> str:
        """Hash of all that it depends on."""
        found = self._step(path)
        return "" if found is None else found.key

    def expect(self, path: str, response: Response, of: str) -> None:
        """Let the fields of a state be asked for."""
        made, kind = self.planned.analyses[of], Response
        inputs = {"state": path}
        top = step("response", "nonlinear", inputs, kind, made, lambda *of: response, False, True)
        self._steps.setdefault(path, fields_step(self.planned, top, 0))

    def put(self, path: str, product: Product) -> None:
        """Add a product that no step of the case makes."""
        self._given[path] = product

    def _step(self, path: str) -> Step[Any] | None:
        if path not in self._steps and path in _DERIVED:
            self._steps[path] = _DERIVED[path](self)
        return self._steps.get(path)

    def _fields(self) -> Step[Any] | None:
        planned, outputs = self.planned, self.planned.case.problem.outputs
        if self._peak is None or not planned.meshes:
            return None
        moving = "animations" in outputs.show
        shown = self.stages.get(planned.response).harmonics if moving else 1
        return fields_step(planned, planned.response, self._peak.point, shown)

    def _audit(self) -> Step[Audit] | None:
        """An independent check of the peak, where one is possible."""
        if self._peak is None:
            return None
        top = as_solved(self.stages.get(self.planned.response), self._peak.point)
        if (top.coupling, top.samples) != ("coupled", 0) or (top.state == nonlinear.ELEMENT).any():
            return None
        planned, stages = self.planned, self.stages

        def compute() -> Audit:
            return nonlinear.audit_response(stages.get(planned.system), top, [0], _AUDITED)

        inputs = {"point": self._peak.point, "samples": _AUDITED}
        key = key_of("check", "nonlinear", inputs, (planned.response.key, planned.system.key))
        return Step("check", f"check {planned.case.name}", key, Audit, (), compute)

    def _sensitivities(self) -> Step[Any] | None:
        if self._peak is None:
            return None
        return sensitivities_step(self.planned, self._peak, self._monitor)


_DERIVED: dict[str, Callable[[StepProducts], Step[Any] | None]] = {
    "fields": StepProducts._fields,
    "audit": StepProducts._audit,
    "sensitivities": StepProducts._sensitivities,
    "mode_shapes": lambda of: mode_shapes_step(of.planned) if of.planned.meshes else None,
    "neglected": lambda of: neglected_harmonics_step(of.planned),
    "mesh_doubt": lambda of: amplitude_errors_of(of.planned),
    "mesh_error": lambda of: of_own_meshes(of.planned),
}
"""Steps that a run asks for of some of its cases."""


def structure_steps(planned: Planned) -> dict[str, Step[Any]]:
    """A case's meshes and components by place; of those by nodal diameter the load's is plain."""
    found: dict[str, Step[Any]] = {f"mesh/{part}": each for part, each in planned.meshes.items()}
    kind, k = "rom" if planned.meshes else "component", diameter_of(planned.case.problem, 1)
    for part in planned.structure.names:
        found[f"{kind}/{part}"] = loaded = planned.part(part, k)
        for other in planned.diameters:
            if (each := planned.part(part, other)).key != loaded.key:
                found[f"{kind}/{part}_nd{other}"] = each
    return found


def _steps(planned: Planned) -> dict[str, Step[Any]]:
    """Steps whose places are known before anything is solved."""
    found: dict[str, Step[Any]] = {
        "response": planned.response,
        "preload": planned.preload,
        "system": planned.system,
        "limits": planned.linear.limits,
        **structure_steps(planned),
    }
    if planned.other is not None:
        found["lower"] = planned.other
    if planned.gauges is not None:
        found["gauges"] = planned.gauges
    found |= {which: planned.linear.responses[which] for which in LIMITS}
    for key, steps in planned.analyses.items():
        found |= {f"{key}.{i}": each for i, each in enumerate(steps)}
    return found


Drawn: TypeAlias = tuple[Floats, Floats, Booleans]
"""Frequencies, Hz, amplitudes, m, and which of them converged."""


@dataclass(frozen=True)
class Curves(Product):
    """What is drawn of a case's responses, that with the higher peak first.

    Attributes
    ----------
    names : tuple of str
        Directions, "" where there is but one.
    curve : dict of int to (3, p) float
        Frequency, Hz, amplitude, m, and whether it converged, in the order of the names.
    verdict : dict of int to (p,) int
        STABLE, UNSTABLE, UNDECIDED, or -1 where nothing is known.
    ends : dict of int to (3, p) float
        Curves between which it may lie.
    """

    names: tuple[str, ...]
    curve: Mapping[int, Floats]
    verdict: Mapping[int, Integers] = field(default_factory=dict)
    ends: Mapping[int, Floats] = field(default_factory=dict)


def with_curves(case: "CaseResult", products: "StepProducts") -> "CaseResult":
    """A case with its curves, and what its analyses have to say of them and of its summary."""
    responses = case.responses
    made = [case.curve(each) for each in responses]
    if case.problem.response.frequencies is None:
        made[0] = drawn(responses[0], made[0][1])
    names = [""]
    if len(responses) > 1:
        names = [f"sweeping {each.direction or 'up'}" for each in responses]
    verdicts: dict[int, Integers] = {}
    ends: list[Drawn] = []
    for analysis in case.analyses:
        if not (found := case.found(analysis.key)):
            continue
        case = replace(case, summary=analysis.summarise(case.summary, found))
        between, by_response = analysis.lines(found)
        ends += map(case.curve, between)
        for i, known in enumerate(by_response):
            verdicts[i] = np.array([known.get(f, -1) for f in made[i][0].tolist()])
    curves = Curves(
        tuple(names),
        {i: np.array(each, float) for i, each in enumerate(made)},
        verdicts,
        {i: np.array(each, float) for i, each in enumerate(ends)},
    )
    products.put("curves", curves)
    return case
