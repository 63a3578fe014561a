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

if TYPE_CHECKING:
    from pydantic import BaseModel

    from vanelock.analyses.solved_case import SolvedCase
    from vanelock.input.cases.values import Given
    from vanelock.input.schema.study import Study
    from vanelock.pipeline.step import Step
    from vanelock.quantities.case_result import CaseResult, State
    from vanelock.quantities.run_result import RunResult
    from vanelock.report import Answer, Block, Picture
    from vanelock.stages.plan import Planned
    from vanelock.stages.response.summary import Summary

ALLOWED = {"coupling": "coupled", "samples": None}
"""What all analyses take of `response`."""
K = TypeVar("K", bound="BaseModel")
P = TypeVar("P", bound=Product)
CurveLines: TypeAlias = tuple[Sequence[Any], Sequence[Mapping[float, int]]]
"""What the figure of a case's response has beside its curves."""


@dataclass(frozen=True)
class AnalysisPart:
    """One product of an analysis of a case, which has a step and a place of its own.

    Attributes
    ----------
    label : str
        What distinguishes its step's name from those of the others.
    inputs : dict of str to value
        What distinguishes its computation.
    response : int
        Which of the case's responses it is of, where each has one.
    """

    label: str = ""
    inputs: Mapping[str, Any] = field(default_factory=dict)
    response: int = 0


def _one_part(given: "Given", keys: Any) -> Sequence[AnalysisPart]:
    """An analysis with one product."""
    return (AnalysisPart(),)


def _nothing(*given: Any) -> tuple[Any, ...]:
    return ()


@dataclass(frozen=True)
class Analysis(Generic[K, P]):
    """An analysis, described by functions; those that it does not need say nothing.

    Attributes
    ----------
    key : str
        Its product's name; and, without `table`, that of its table in the input files.
    title : str
        What it is of, in words.
    product : callable or None
        To the type that one part of it gives, which may be the solver's; None where it shows what
        others have made.
    keys : type or None
        Its table in a study; None where nothing asks for it.
    compute : callable
        (case, keys, part) to a product.
    step : callable
        In place of it, a case's steps to a step that cases may share; None where there is none.
    table : str
        Table of another analysis that asks for it, too.
    scene_keys : type or None
        Its table in a scene; None where scenes have none.
    parts : callable
        (given, keys) to its parts.
    combine : callable or None
        Products of all parts to the one that is shown.
    by_response : bool
        Whether each of a case's responses has a part.
    whole_ring : callable
        (given, keys) to whether it takes all nodal diameters.
    after : tuple of str
        Analyses whose products it takes, if they are asked for.
    needs : callable
        (steps of a case, keys) to steps that it takes besides, which cases may share.
    any_law : bool
        Whether it takes responses that are not coupled, or sampled, too.
    elements : bool
        Whether it takes contacts of elements.
    check : callable
        (given, keys) to lines on what contradicts one another.
    cost : callable
        (study, keys, seconds of a curve) to seconds.
    places : callable
        A product to where it goes in the results, below the case.
    summarise : callable
        (summary, products) to the case's summary with its numbers.
    warnings : callable
        (case, products) to lines.
    lines : callable
        Products to curves between which that of the response may lie; and of each response STABLE,
        UNSTABLE or UNDECIDED by frequency, Hz.
    states : callable
        A case to states of it whose stresses and wear are looked at, too.
    state : str
        What the last of these is called.
    reserve : str
        What the results call its safety factor.
    tables : callable
        Cases by name to tables.
    pictures : callable
        (run, case) to pictures.
    files : callable
        Of (run, case), which writes CSV files that are of no picture.
    run_tables, run_pictures : callable
        The same of a run as a whole.
    page : callable or None
        A run to what its section of the page has, in place of text, tables and pictures.
    open : bool
        Whether that section is unfolded.
    looked_into : bool
        Whether it is of all cases that are looked into, without being asked for.
    answers : callable
        A case to cards of the page.
    text : str
        What its section of the page begins with.
    template : str
        Its table in the commented file, JOINT for the key of a joint.
    absent : callable
        What the page says is not known where it is not asked for.
    """

    key: str
    title: str
    product: Callable[[], type[P]] | None = None
    keys: type[K] | None = None
    compute: Callable[["SolvedCase", K, AnalysisPart], P] | None = None
    step: "Callable[[Planned], Step[P] | None] | None" = None
    table: str = ""
    scene_keys: "type[BaseModel] | None" = None
    parts: "Callable[[Given, K], Sequence[AnalysisPart]]" = _one_part
    combine: Callable[[Sequence[P]], Product] | None = None
    by_response: bool = False
    whole_ring: "Callable[[Given, K], bool]" = lambda given, keys: False
    after: tuple[str, ...] = ()
    needs: "Callable[[Planned, K], Iterable[Step[Any]]]" = _nothing
    any_law: bool = False
    elements: bool = False
    check: "Callable[[Given, K], Iterable[str]]" = _nothing
    cost: "Callable[[Study, K, float], float]" = lambda study, keys, curve: 0.0
    places: "Callable[[Any], str]" = lambda product: ""
    summarise: "Callable[[Summary, Sequence[Any]], Summary]" = lambda summary, products: summary
    warnings: "Callable[[CaseResult, Sequence[Any]], Iterable[str]]" = _nothing
    lines: "Callable[[Sequence[Any]], CurveLines]" = lambda products: ((), ())
    states: "Callable[[CaseResult], Iterable[State]]" = _nothing
    state: str = ""
    reserve: str = ""
    tables: "Callable[[Mapping[str, CaseResult]], Iterable[Table]]" = _nothing
    pictures: "Callable[[RunResult, CaseResult], Iterable[Picture]]" = _nothing
    files: "Callable[[RunResult, CaseResult], object]" = _nothing
    run_tables: "Callable[[RunResult], Iterable[Table]]" = _nothing
    run_pictures: "Callable[[RunResult], Iterable[Picture]]" = _nothing
    page: "Callable[[RunResult], Sequence[Block]] | None" = None
    open: bool = True
    looked_into: bool = False
    answers: "Callable[[CaseResult], Iterable[Answer]]" = _nothing
    text: str = ""
    template: str = ""
    absent: "Callable[[CaseResult], str]" = lambda case: ""

    def keys_of(self, given: "Given") -> K | None:
        """Its table in a study or scene; None where it is not asked for."""
        keys: K | None = getattr(given, self.table or self.key, None)
        return keys


def analysable(given: "Given") -> bool:
    """Whether responses of this kind can be analysed."""
    return all(getattr(given.response, key) == allowed for key, allowed in ALLOWED.items())


def products_of(cases: "Mapping[str, CaseResult]", key: str) -> tuple[dict[str, Any], int]:
    """Products of an analysis by case, of as many as a table has, and how many cases have it."""
    known = [(name, case) for name, case in cases.items() if case.products.of_analysis(key)]
    return {name: case.found(key) for name, case in known[:MOST_CASES]}, len(known)


def asked_for(analyses: Iterable[Analysis[Any, Any]], given: "Given") -> Iterator[Any]:
    """Analyses that a study or scene asks for, each with its table."""
    for each in analyses:
        if (keys := each.keys_of(given)) is not None:
            yield each, keys
