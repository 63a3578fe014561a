"""Run a campaign: all cases, the maps, the statements, the figures and the page."""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from vanelock.commands.run.cases import OngoingRun
from vanelock.common.errors import InputError
from vanelock.common.files.digests import file_digest
from vanelock.input.schema.comparison import CampbellKeys
from vanelock.input.schema.study import Study
from vanelock.pipeline.cache import Cache, code_of
from vanelock.pipeline.executor.choose import chosen_executor
from vanelock.pipeline.executor.tasks import TaskFailed
from vanelock.pipeline.progress import Finished, Listener, Notice, silent
from vanelock.pipeline.step import Stages
from vanelock.published import figures, page
from vanelock.published.evidence import Evidence
from vanelock.published.gather import evidence, maps_of, ordered, plan_of
from vanelock.published.maps import map_figures
from vanelock.published.page_tables import short_table
from vanelock.published.sheets import Plan, main_case
from vanelock.published.statements import Statement, statements
from vanelock.quantities.curves_and_fields import RunData
from vanelock.report import Picture
from vanelock.results import listing
from vanelock.results.figures.pictures import Pictures
from vanelock.results.files import results_file
from vanelock.results.files.redrawn import REPORT, OutputFiles
from vanelock.results.files.run_folder import claimed
from vanelock.results.page import write_report
from vanelock.stages.response.summary import Summary


def run_campaign(
    study: Study,
    folder: str | os.PathLike[str],
    listener: Listener = silent,
    text: str = "",
    workers: int = 1,
    scheduler: str | None = None,
    insecure: bool = False,
) -> tuple[Statement, ...]:
    """Run the campaign of a study in a folder; what earlier runs there computed is used again.

    Parameters
    ----------
    study : Study
        With a campaign.
    folder : path
        Where `results.h5`, `report.html`, `figures/`, `shapes/` and `cache/` go.
    listener : callable
        Called with stages, points, notices and tables.
    text : str
        The study file's text, kept in the results.
    workers : int
        Processes that compute the cases, points of maps among them; 1: this one does.
    scheduler : str, optional
        Address of a Dask scheduler whose workers do.
    insecure : bool
        Whether the scheduler may be on another machine without encryption.

    Returns
    -------
    tuple of Statement
        The published statements beside what was found.

    Raises
    ------
    InputError
        If the study cannot be computed, or the folder not be used.
    """
    path = Path(folder)
    began = time.perf_counter()
    if study.campbell is None:
        study = study.model_copy(update={"campbell": CampbellKeys()})
    with claimed(path):
        cache = Cache(path / "cache", lambda message: listener(Notice(message)))
        stages = Stages(cache, listener)
        executor = chosen_executor(
            workers, scheduler, listener, path / "cache", insecure=insecure
        )  # refused before the long stages
        plan = plan_of(study, stages)
        run = OngoingRun(study, path, listener, stages, ordered(plan), executor)
        run.record.provenance(study, text)
        maps = maps_of(run, plan)
        with run.background(maps.jobs(cache)):
            with run.record.together():
                summaries = run.all_cases()
            if run.failed:  # every case counts for a statement
                name, failure = next(iter(run.failed.items()))
                raise InputError(f"campaign: {name}: {failure.reason}")
            try:
                found = evidence(run, plan, summaries, maps)
            except TaskFailed as error:
                failure = error.failure
                raise InputError(f"campaign: {failure.task}: {failure.reason}") from None
        run.answer(summaries)
        stated = statements(found)
        _record(run, found)
        listener(short_table(stated))
        output_files = OutputFiles(path, listener)
        drawn = _draw(
            run,
            plan,
            found,
            stated,
            output_files,
            summaries,
            text,
            lambda: time.perf_counter() - began,
        )
        listener(listing.stage_times([*stages.done.values(), *output_files.done]))
        run.record.complete(stages.done)
    summary = {
        "cases": [asdict(case) for case in summaries],
        "statements": [asdict(each) for each in stated],
        "results": str(path / results_file.NAME),
        "pictures": [str(file) for shown in drawn for file in (shown.path, *shown.data)],
    }
    opened = str(path / REPORT) if study.outputs.report else ""
    listener(Finished(str(path), time.perf_counter() - began, summary, opened))
    return stated


def _record(run: OngoingRun, found: Evidence) -> None:
    """Maps and ridges into the results file."""
    with run.record.together():
        for name, plane in found.planes.items():
            run.record.product(f"campaign/map_{name}", plane)
        for slant, plane in found.slants.items():
            run.record.product(f"campaign/map_slant{slant:g}", plane)
        for ridge in found.ridges:
            run.record.product(f"campaign/peak_{ridge.name}_h{ridge.harmonics}", ridge)


def _draw(
    run: OngoingRun,
    plan: Plan,
    found: Evidence,
    stated: tuple[Statement, ...],
    output_files: OutputFiles,
    summaries: tuple[Summary, ...],
    text: str,
    spent: Callable[[], float],
) -> list[Picture]:
    """All figures of the campaign, those of an ordinary run of its main case, and the page."""
    study = plan.base
    every = RunData(plan.base, run.planned, run.stages, run.shown, output_files)
    sheets = figures.curve_sheets(every, found)
    loops = figures.loop_pictures(every, found)
    made = [*loops, *(figures.draw_sheet(every, found, sheet) for sheet in sheets)]
    maps = map_figures.map_pictures(every, found)
    best = map_figures.ridge_picture(every, found)
    made += [*maps, best]
    _write_statements(every, stated)
    main = main_case(plan)
    own = [each for each in run.planned if each.case.name == main]
    shown = run.shown.only(main, own[0].linear.name)
    scene = plan.study(main).model_copy(update={"campbell": study.campbell})
    pictures = Pictures(scene, own, run.stages, shown, output_files)
    drawn = pictures.draw()
    if study.outputs.report:
        run.record.answers(pictures.answers)
        chosen = [each for each in summaries if each.case == main]
        shown_first = page.PublishedPictures(sheets, loops, maps, best)

        def write() -> None:
            content = run.page_content(pictures, chosen, drawn, text)
            write_report(
                replace(
                    content,
                    strains=_only(content.strains, main),
                    assessments=_only(content.assessments, main),
                ),
                lambda: page.sections(every, found, stated, shown_first, spent),
                _digest(found, made),
            )

        write()
    return [*made, *drawn]


def _only(by_case: Mapping[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in by_case.items() if key == name}


def _digest(found: Evidence, made: Sequence[Picture]) -> Any:
    """All that the campaign's sections depend on."""
    files = [[each.title, file_digest(each.path)] for each in made]
    peaks = {name: [each.peak and each.peak.amplitude] for name, each in found.summaries.items()}
    return [code_of("published"), files, peaks]


def _write_statements(run_data: RunData, stated: tuple[Statement, ...]) -> Path:
    """The table of agreement as CSV."""
    rows = [{**asdict(each), "cases": "; ".join(each.cases)} for each in stated]
    columns = {key: [row[key] for row in rows] for key in rows[0]}
    return run_data.table("figures/agreement.csv", rows, lambda: columns)
