"""What an analysis of a case is: its keys, its computation, and how its product is shown.

One file has all of it; `vanelock.analyses.ANALYSES` lists them. A new one is a file and a line
there: the tables of the input files, their checks, forecasts, steps, results, tables, pictures,
warnings and the page follow from what it says of itself.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from vanelock.common.product import Product
from vanelock.common.tables import MOST_CASES, Table

if TYPE_CHECKING:  # all that functions of analyses take, for their files as well
    from pydantic import BaseModel

    from vanelock.analyses.solved_case import SolvedCase as SolvedCase
    from vanelock.input.cases.values import Problem as Problem
    from vanelock.input.schema.study import Study as Study
    from vanelock.pipeline.step import Step as Step
    from vanelock.quantities.case_result import CaseResult as CaseResult
    from vanelock.quantities.case_result import State as State
    from vanelock.quantities.run_result import RunResult as RunResult
    from vanelock.report import Answer, Block, Picture
    from vanelock.stages.plan import Planned as Planned
    from vanelock.stages.response.summary import Peak as Peak
    from vanelock.stages.response.summary import Summary as Summary

ALLOWED = {"coupling": "coupled", "samples": None}
"""What all analyses take of `response`."""
K = TypeVar("K", bound="BaseModel")
P = TypeVar("P", bound=Product)
CurveLines: TypeAlias = tuple[Sequence[Any], Sequence[Mapping[float, int]]]
"""What the figure of a case's response has beside its curves."""


@dataclass(frozen=True)
class AnalysisPart:
    """One product of an analysis of a case, which has a step and a place of its own."""

    label: str = ""
    """What distinguishes its step's name from those of the others."""
    inputs: Mapping[str, Any] = field(default_factory=dict)
    """What distinguishes its computation."""
    response: int = 0
    """Which of the case's responses it is of, where each has one."""


def _nothing(*value: Any) -> tuple[Any, ...]:
    return ()


@dataclass(frozen=True)
class Analysis(Generic[K, P]):
    """An analysis, described by functions; those that it does not need say nothing."""

    key: str
    """Its product's name; and, without `table`, that of its table in the input files."""
    title: str
    """What it is of, in words."""
    product: Callable[[], type[P]] | None = None
    """To the type that one part of it gives, which may be the solver's; None where it shows what
    others have made."""
    keys: type[K] | None = None
    """Its table in a study; None where nothing asks for it."""
    compute: Callable[["SolvedCase", K, AnalysisPart], P] | None = None
    """(case, keys, part) to a product."""
    step: "Callable[[Planned], Step[P] | None] | None" = None
    """In place of it, a case's steps to a step that cases may share; None where there is none."""
    table: str = ""
    """Table of another analysis that asks for it, too."""
    scene_keys: "type[BaseModel] | None" = None
    """Its table in a scene; None where scenes have none."""
    parts: "Callable[[Problem, K], Sequence[AnalysisPart]]" = lambda problem, keys: (
        AnalysisPart(),
    )
    """(given, keys) to its parts."""
    combine: Callable[[Sequence[P]], Product] | None = None
    """Products of all parts to the one that is shown."""
    by_response: bool = False
    """Whether each of a case's responses has a part."""
    whole_ring: "Callable[[Problem, K], bool]" = lambda problem, keys: False
    """(given, keys) to whether it takes all nodal diameters."""
    after: tuple[str, ...] = ()
    """Analyses whose products it takes, if they are asked for."""
    needs: "Callable[[Planned, K], Iterable[Step[Any]]]" = _nothing
    """(steps of a case, keys) to steps that it takes besides, which cases may share."""
    any_law: bool = False
    """Whether it takes responses that are not coupled, or sampled, too."""
    elements: bool = False
    """Whether it takes contacts of elements."""
    check: "Callable[[Problem, K], Iterable[str]]" = _nothing
    """(given, keys) to lines on what contradicts one another."""
    cost: "Callable[[Study, K, float], float]" = lambda study, keys, curve: 0.0
    """(study, keys, seconds of a curve) to seconds."""
    places: "Callable[[Any], str] | None" = None
    """A product to where it goes in the results, below the case, if not under the key."""
    summarise: "Callable[[Summary, Sequence[Any]], Summary]" = lambda summary, products: summary
    """(summary, products) to the case's summary with its numbers."""
    warnings: "Callable[[CaseResult, Sequence[Any]], Iterable[str]]" = _nothing
    """(case, products) to lines."""
    lines: "Callable[[Sequence[Any]], CurveLines]" = lambda products: ((), ())
    """Products to curves between which that of the response may lie; and of each response STABLE,
    UNSTABLE or UNDECIDED by frequency, Hz."""
    states: "Callable[[CaseResult], Iterable[State]]" = _nothing
    """A case to states of it whose stresses and wear are looked at, too."""
    state: str = ""
    """What the last of these is called."""
    reserve: str = ""
    """What the results call its safety factor."""
    tables: "Callable[[Mapping[str, CaseResult]], Iterable[Table]]" = _nothing
    """Cases by name to tables."""
    pictures: "Callable[[RunResult, CaseResult], Iterable[Picture]]" = _nothing
    """(run, case) to pictures."""
    run_tables: "Callable[[RunResult], Iterable[Table]]" = _nothing
    """A run to tables of it as a whole."""
    run_pictures: "Callable[[RunResult], Iterable[Picture]]" = _nothing
    """A run to pictures of it as a whole."""
    page: "Callable[[RunResult], Sequence[Block]] | None" = None
    """A run to what its section of the page has, in place of text, tables and pictures."""
    open: bool = True
    """Whether that section is unfolded."""
    looked_into: bool = False
    """Whether it is of all cases that are looked into, without being asked for."""
    answers: "Callable[[CaseResult], Iterable[Answer]]" = _nothing
    """A case to cards of the page."""
    text: str = ""
    """What its section of the page begins with."""
    template: str = ""
    """Its table in the commented file, JOINT for the key of a joint."""
    absent: "Callable[[CaseResult], str]" = lambda case: ""
    """What the page says is not known where it is not asked for."""

    def keys_of(self, problem: "Problem") -> K | None:
        """Its table in a study or scene; None where it is not asked for."""
        keys: K | None = getattr(problem, self.table or self.key, None)
        return keys


def products_of(cases: "Mapping[str, CaseResult]", key: str) -> tuple[dict[str, Any], int]:
    """Products of an analysis by case, of as many as a table has, and how many cases have it."""
    known = [(name, case) for name, case in cases.items() if case.products.of_analysis(key)]
    return {name: case.found(key) for name, case in known[:MOST_CASES]}, len(known)


def asked_for(analyses: Iterable[Analysis[Any, Any]], problem: "Problem") -> Iterator[Any]:
    """Analyses that a study or scene asks for, each with its table."""
    for each in analyses:
        if (keys := each.keys_of(problem)) is not None:
            yield each, keys
