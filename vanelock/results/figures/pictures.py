"""The pictures of a run, in the order in which they are drawn and shown."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from vanelock.pipeline.progress import Notice
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.selection import (
    energies,
    in_words,
    looked_into_names,
    named,
    with_details,
)
from vanelock.report import Picture
from vanelock.results.figures.contacts import contacts, loops, preloads
from vanelock.results.figures.curves import curves
from vanelock.results.figures.shapes import (
    all_modes,
    distinct_modes,
    few,
    mesh,
    mesh_errors,
    response,
    stress,
)
from vanelock.results.files.redrawn import REPORT

FEW = 60
"""Cases that all get their damping ratio: each takes its system anew."""


def look_into(run: RunResult) -> None:
    """Have all that pictures and page show made, be they drawn anew or not."""
    shapes = run.shapes
    if "report" in run.given.outputs.show:
        chosen = looked_into_names(run)
        for name, case in run.cases.items():
            if name in chosen:
                run.cases[name] = with_details(case)
            elif case.peak is not None and len(run.cases) <= FEW:
                run.cases[name] = replace(case, numbers=energies(case))
    wanted = [(case, "mode_shapes") for case, _ in few(distinct_modes(run))] if shapes else []
    wanted += [(case, "fields") for case in named(run)] if shapes else []
    wanted += [(run.first, "mesh_error")] if shapes else []
    if (main := run.main) is not None:
        wanted += [(main, "mode_shapes")] if shapes else []
        wanted += [(main, "neglected"), (main, "mesh_doubt")] if main.errors is None else []
    for case, place in wanted:
        if place in case.products:
            case.products.get(place)


def draw(run: RunResult) -> None:
    """Draw what is not there yet, and remove what earlier runs drew and this one does not."""
    run.pictures = [*_drawn(run), *_of_analyses(run)]
    run.output_files.tidy(keep=[REPORT] if "report" in run.given.outputs.show else [])


def _drawn(run: RunResult) -> list[Picture]:
    """All but those of analyses."""
    shown = run.given.outputs.show
    made = [curves(run), *preloads(run)]
    chosen = detailed(run)
    moving = chosen[:1] + chosen[-1:] if "animations" in shown else []
    if "loops" in shown:
        for each in chosen:
            made += _own(each, loops(run, each))
    if run.shapes:
        modes = all_modes(run)
        made.append(mesh(run, run.first, modes[0].data if modes else ()))
        made += mesh_errors(run, run.first)
        made += modes
        for each in chosen:
            made += _own(each, response(run, each, each in moving))
        for each in chosen:
            made += _own(each, [stress(run, each), contacts(run, each)])
    return made


def _of_analyses(run: RunResult) -> Iterator[Picture]:
    """Those of analyses that are asked for, and of the cases that are looked into."""
    for analysis in run.analyses:
        made = [*analysis.run_pictures(run)]
        cases = run.looked_into.values() if analysis.looked_into else named(run)
        for each in cases:
            if analysis.looked_into or each.products.of_analysis(analysis.key):
                made += _own(each, analysis.pictures(run, each))
                analysis.files(run, each)
        yield from (replace(picture, section=analysis.key) for picture in made)


def detailed(run: RunResult) -> list[CaseResult]:
    """Cases with pictures of their own; says which, if any are drawn."""
    cases, count = named(run), len(run.peaks)
    drawn = [name for name in ("loops", "shapes") if name in run.given.outputs.show]
    if drawn and len(cases) < count:
        text = f"pictures of {' and '.join(drawn)} for {in_words(run)} of {count}"
        run.output_files.listener(Notice(text))
    return cases


def _own(each: CaseResult, made: Iterable[Picture]) -> Iterator[Picture]:
    """Pictures of a case."""
    return (replace(picture, case=each.name) for picture in made)
