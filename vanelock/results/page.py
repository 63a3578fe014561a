"""The page of a run, report.html: its sections in order, written when what it shows changed.

The first section of a run's page: the answers, and what to be careful about.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import vanelock
from vanelock.common.files.digests import file_digest
from vanelock.common.tables import Table
from vanelock.input.cases.names import fixed, words
from vanelock.input.schema.study import Study
from vanelock.pipeline.cache import code_of
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.warnings import by_text, without_effect
from vanelock.report import (
    Answer,
    Answers,
    OfCase,
    Page,
    Picture,
    Section,
    Text,
    withheld,
    write_page,
)
from vanelock.report.blocks import Block, Single
from vanelock.results.figures.pictures import draw
from vanelock.results.files.run_folder import REPORT
from vanelock.results.listing import case_row, case_table
from vanelock.results.page_sections.curves import convergence, loops, response_plot, shapes
from vanelock.results.page_sections.inputs import all_inputs, begun, inputs, models, provenance
from vanelock.rom.joining.mesh_excess import DOUBT
from vanelock.stages.accuracy.mesh_errors import amplitude_error
from vanelock.stages.response.summary import Summary

MOST_FAILED = 5
"""Failed cases that the summary names."""
SAME = 1e-3
"""Relative width of bounds below which they are one."""
APART = ("harmonics", "mu", "x", "converged", "seconds")
"""Columns of the cases that other sections have."""


def _summary(run: RunResult) -> Section:
    """Answers, warnings and a line for each case."""
    blocks: list[Block] = [Answers(tuple(_answers_of(run))), response_plot(run)]
    warned = _warnings(run)
    if warned:
        blocks.append(Text("**Be careful.** " + "\n\n".join(warned)))
    return Section("Summary", [*blocks, _cases(run)], id="summary")


def _answers_of(run: RunResult) -> list[Answer]:
    """The run's answers, most wanted first."""
    most = run.largest
    if most is None or most.peak is None:
        return [Answer("Largest peak", "none", "no point of any case converged", "bad")]
    many = len(run.known) > 1
    case = f"{words(most.case)}, " if many else ""
    between = _between(run, most)
    found = [
        Answer(
            "Largest peak" if many else "Peak",
            f"{1e6 * most.peak.amplitude:.3g} µm",
            f"{between}{case}{run.monitor.name}, half the peak-to-peak"
            + (f"; {_of_linear(most)}" if _of_linear(most) else "")
            + ("" if most.peak.at_edge else _error(run, most)),
            "warn" if most.peak.at_edge or between else "",
        ),
        Answer("Frequency", f"{most.peak.frequency:.2f} Hz", _speed(run, most)),
    ]
    for analysis in run.analyses:
        found += analysis.answers(run.cases[most.case])
    return [*found, *_best_friction(run)]


def _between(run: RunResult, most: Summary) -> str:
    """How far static friction may move the peak."""
    main = run.main
    if most.lowest is None or most.highest is None or main is None:
        return ""
    low, high = 1e6 * most.lowest.amplitude, 1e6 * most.highest.amplitude
    if high <= (1 + SAME) * low:
        return ""
    sticks = main.top.undetermined[0].any(axis=1)
    joints = " and ".join(dict.fromkeys(np.array(main.places.joint)[sticks].tolist()))
    return (
        f"**between {low:.3g} and {high:.3g} µm**, as static friction in {joints} is not "
        "determined. "
    )


def _of_linear(most: Summary) -> str:
    over = (
        f"{value:.2f} of the linear peak with contacts {which}"
        for which, value in (("free", most.of_free), ("stuck", most.of_stuck))
        if np.isfinite(value)
    )
    return "; ".join(over)


def _error(run: RunResult, most: Summary) -> str:
    """What the peak's estimated error is, or what mesh and harmonics leave in doubt."""
    if most.case not in run.errors:
        doubt, products = _doubt(run, most), run.cases[most.case].products
        if doubt and "mesh_doubt" in products:
            doubt = amplitude_error(products.get("mesh_doubt"), doubt)
        missed = products.get("neglected").amplitude
        shown = {"the mesh": doubt, "neglected harmonics": np.nan_to_num(missed)}
        texts = [f"{100 * size:.2g} % by {name}" for name, size in shown.items() if size]
        return f"; ±{' and '.join(texts)}" if texts else ""
    errors = run.errors[most.case][0]
    text = f"; estimated error {100 * errors.total[0]:.2g} %, asked for {100 * errors.accuracy:g} %"
    apart = [each for each in errors.sources if each not in errors.counted]
    return text + "".join(
        f", and {100 * each.amplitude:.2g} % of the {each.name}, which is given" for each in apart
    )


def _doubt(run: RunResult, most: Summary) -> float:
    """Of the frequencies of interest, what the meshes leave in doubt; 0 where it is not known."""
    limits = run.cases[most.case].limits
    return DOUBT * float(np.nan_to_num([limits.free_lowered, limits.stuck_lowered]).max())


def _speed(run: RunResult, most: Summary) -> str:
    assert most.peak is not None
    (sectors, order), texts = run.cases[most.case].ring, []
    doubt = 0.0 if most.case in run.errors else _doubt(run, most)
    if doubt and not most.peak.at_edge:
        texts.append(f"±{100 * doubt:.2g} % by the mesh")
    if sectors > 1 and order:
        speed = 60 * most.peak.frequency / abs(order)
        texts.append(f"{speed:,.0f} rpm at engine order {abs(order)}")
    if 0 <= most.position <= 1:
        texts.append(f"{100 * most.position:.0f} % of the shift from free to stuck")
    return "; ".join(texts)


def _best_friction(run: RunResult) -> list[Answer]:
    """The optimum friction, where that of one joint is swept and nothing else."""
    found, swept = run.known, {key for each in run.known for key in each.values}
    if len(found) < 2 or len(swept) != 1 or not (key := swept.pop()).endswith(".mu"):
        return []
    if any(each.peak.at_edge for each in found if each.peak):
        return [withheld("Optimum friction")]
    height = [each.peak.amplitude for each in found if each.peak]
    best = int(np.argmin(height))
    mu = [float(each.values[key]) for each in found]
    at_end = mu[best] in (min(mu), max(mu))
    note = f"lowest peak of the cases, {1e6 * height[best]:.3g} µm"
    if at_end:
        note += "; at the end of the values swept, so the best may lie beyond"
    return [Answer("Optimum friction", f"μ = {mu[best]:g}", note, "warn" if at_end else "")]


def _warnings(run: RunResult) -> list[str]:
    """What keeps the answers from being taken as they are, a line each."""
    cases = {each.case: each for each in run.summaries}
    lines = [*_failed(run), *by_text(cases)]
    lines += [f"{line}." for line in without_effect([(c.values, c) for c in cases.values()])]
    for name, (errors, _) in run.errors.items():
        case = "" if name == "nominal" else f"{words(name)}: "
        lines += [f"{case}{line.removeprefix('WARNING: ')}." for line in errors.warnings]
    main = run.main
    if main and main.margins:
        lines += [
            f"The worst node of the {part}, n = {worst.reserve:.3g} ({worst.where}), lies "
            f"{worst.doubt}: its stress depends on the mesh, not on the part."
            for part, (worst, *_) in main.margins.worst.items()
            if worst.doubt and worst.reserve < main.margins.governing.reserve
        ]
    given = run.problem
    mesh = given.mesh if isinstance(given, Study) and not run.errors else None
    if mesh and (mesh.size, mesh.correction) == ("coarse", "none"):
        lines.append("The mesh is coarse: frequencies are several per cent too high.")
    return lines


def _failed(run: RunResult) -> list[str]:
    """Cases that could not be computed."""
    names = list(run.failed)
    if not names:
        return []
    shown = "; ".join(f"{words(name)} ({run.failed[name].reason})" for name in names[:MOST_FAILED])
    more = f"; and {len(names) - MOST_FAILED} more" if len(names) > MOST_FAILED else ""
    every = len(names) + len(run.summaries)
    return [f"{len(names)} of {every} cases FAILED and are left out: {shown}{more}."]


def _cases(run: RunResult) -> Table:
    """A line for each case, its stress as well where it is known."""
    lines = [case_row(each.summary, each.numbers) for each in run.cases.values()]
    found = case_table(lines, run.monitor.name).without(*APART)
    rows = [(fixed(words(str(name))), *rest) for name, *rest in found.rows]
    return replace(found, title=f"All cases at their largest {run.monitor.name}", rows=rows)


OPEN = ("summary", "shapes")
"""Sections that are not folded, beside those of analyses: what most readers came for."""


def show(run: RunResult) -> None:
    """Draw the pictures of a run and write its page, unless they show the same already."""
    draw(run)
    if "report" in run.problem.outputs.show:
        run.output_files.draw(REPORT, _shown(run), lambda path: write_page(path, _page(run)))


def _page(run: RunResult) -> Page:
    """The page."""
    about = f"Friction-damped vibration; vanelock {vanelock.__version__}, {begun(run)}"
    return Page(run.problem.name, about, tuple(_sections(run)))


def _sections(run: RunResult) -> list[Section]:
    """All of its sections."""
    analysed = _analyses(run)
    made = [
        _summary(run),
        inputs(run.problem, [each.problem for each in run.cases.values()]),
        *(section for section in analysed if not section.folded),
        shapes(run),
        loops(run),
        *(section for section in analysed if section.folded),
        _pictures(run),
        convergence(run),
        models(run),
        provenance(run),
        all_inputs(run.problem),
    ]
    shown = [section for section in made if section.blocks]
    return [s if s in analysed else replace(s, folded=s.id not in OPEN) for s in shown]


def _analyses(run: RunResult) -> list[Section]:
    """A section for each table that asks for analyses, and for each that needs none."""
    cases = {words(name): case for name, case in run.cases.items()}
    blocks: dict[str, list[Block]] = {}
    heads: dict[str, tuple[str, bool]] = {}
    for analysis in run.analyses:
        own = blocks.setdefault(table := analysis.table or analysis.key, [])
        heads.setdefault(table, (analysis.title.capitalize(), not analysis.open))
        if analysis.page is not None:
            own += analysis.page(run)
            continue
        made: list[Block] = [*analysis.tables(cases)]
        made += _by_case(run, [e for e in run.pictures if e.section == analysis.key])
        own += [Text(analysis.text), *made] if made and analysis.text else made
    return [
        Section(title, blocks[id], id=id, folded=folded) for id, (title, folded) in heads.items()
    ]


def _by_case(run: RunResult, pictures: Sequence[Picture]) -> list[OfCase]:
    return run.of_cases({each.case: [each] for each in pictures})


def _pictures(run: RunResult) -> Section:
    """The run's figures that no other section shows, those of the chosen case last."""
    shown = [each for each in run.pictures if not each.section]
    own: dict[str, list[Single]] = {}
    for each in shown:
        if each.case:
            own.setdefault(each.case, []).append(each)
    shared = [each for each in shown if not each.case]
    return Section("Figures", [*shared, *run.of_cases(own)], id="figures")


def _shown(run: RunResult) -> Any:
    """All that the page depends on, but for the date; as JSON can hold it."""
    return {
        "study": run.problem.model_dump(mode="json"),
        "text": run.text,
        "cases": [
            [name, *each.solved_keys, each.linear_key, each.key_at("system")]
            for name, each in run.cases.items()
        ],
        "failed": {name: each.reason for name, each in run.failed.items()},
        "answers": [each.key for each in run.looked_into.values()],
        "pictures": [
            [str(e.path.name), e.title, e.caption, file_digest(e.path)] for e in run.pictures
        ],
        "code": code_of("analyses", "results", "quantities", "report"),
    }
