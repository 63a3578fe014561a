"""The pictures of a run, in the order in which they are drawn and shown."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from vanelock.input.schema.outputs import Outputs
from vanelock.pipeline.progress import Notice
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.selection import in_words, named
from vanelock.report import Picture
from vanelock.results.figures.campbell import campbells
from vanelock.results.figures.contacts.contacts import contacts
from vanelock.results.figures.contacts.loops import loops
from vanelock.results.figures.contacts.preload import preloads
from vanelock.results.figures.curves import curves
from vanelock.results.figures.fatigue import haigh, wear_table
from vanelock.results.figures.mesh_errors import mesh_errors
from vanelock.results.figures.scatter import scatters
from vanelock.results.figures.shapes import all_modes, mesh, response, stress
from vanelock.results.files.redrawn import REPORT
from vanelock.stages.plan import Planned


def draw(run: RunResult) -> None:
    """Draw what is not there yet, and remove what earlier runs drew and this one does not."""
    outputs = run.given.outputs
    shapes = isinstance(outputs, Outputs) and outputs.shapes
    run.pictures = _drawn(run, shapes)
    if outputs.report:
        for found in run.answers.values():
            made = [haigh(run, found)] if found.margins else []
            run.pictures += _own(found.planned, made)
        run.cases = {k: replace(each, answers=run.answers.get(k)) for k, each in run.cases.items()}
        run.wear = {name: wear_table(run, found) for name, found in run.answers.items()}
    run.output_files.tidy(keep=[REPORT] if outputs.report else [])


def _drawn(run: RunResult, shapes: bool) -> list[Picture]:
    """All that need no answers."""
    outputs = run.given.outputs
    made = [curves(run), *campbells(run), *preloads(run)]
    if run.scattered is not None:
        made.insert(1, scatters(run, run.scattered))
    chosen = detailed(run)
    moving = {each.case.name for each in (*chosen[:1], *chosen[-1:])}
    moving = moving if getattr(outputs, "animations", False) else set()
    if outputs.loops:
        for each in chosen:
            made += _own(each, loops(run, each))
    if shapes:
        modes, first = all_modes(run), run.planned[0]
        made.append(mesh(run, first, modes[0].data if modes else ()))
        made += mesh_errors(run, first)
        made += modes
        for each in chosen:
            made += _own(each, response(run, each, each.case.name in moving))
        for each in chosen:
            made += _own(each, [stress(run, each), contacts(run, each)])
    for each in chosen:
        for analysis in run.analyses:
            if analysis.key in each.analyses:
                own = _own(each, analysis.pictures(run, run.cases[each.case.name]))
                made += (replace(picture, section=analysis.key) for picture in own)
    return made


def detailed(run: RunResult) -> list[Planned]:
    """Cases with pictures of their own; says which, if any are drawn."""
    cases, count = named(run), len(run.peaks)
    drawn = [name for name in ("loops", "shapes") if getattr(run.given.outputs, name, False)]
    if drawn and len(cases) < count:
        text = f"pictures of {' and '.join(drawn)} for {in_words(run)} of {count}"
        run.output_files.listener(Notice(text))
    return cases


def _own(each: Planned, made: Iterable[Picture]) -> Iterator[Picture]:
    """Pictures of a case."""
    return (replace(picture, case=each.case.name) for picture in made)
