"""Convergence and errors on a run's page: what is estimated, what is checked, and what is not."""

import numpy as np

from vanelock.input.cases.names import fixed, of_case, words
from vanelock.input.schema.scene import Scene
from vanelock.report import Section, Table, Text
from vanelock.report.blocks import Block, Cell, Flag
from vanelock.results.page_sections.content import PageContent

CHECKED = (
    "Checked: at the peak every contact is marched in time by other code, its forces put into the "
    "equations of motion in all coordinates of the reduced model, and the largest force left over, "
    "and the power left over, told relative to the others."
)


def convergence(told: PageContent) -> Section:
    """How sure the numbers are."""
    blocks: list[Block] = [_points(told), Text(CHECKED)]
    for name, (errors, without) in told.worth.items():
        rows: list[tuple[Cell, ...]] = [
            (e.name, *map(_percent, (e.amplitude, e.frequency, e.share)), e.knob)
            for e in errors.sources
        ]
        amplitude, frequency = errors.total
        rows.append(
            ("together", *map(_percent, (amplitude, frequency, errors.accuracy)), "asked for")
        )
        late = max(amplitude, frequency) > errors.accuracy
        last: Flag = "warn" if late else "good"
        quiet: list[Flag] = [""]
        flags = [*quiet * len(errors.sources), last]
        blocks.append(
            Table(
                ("source", "amplitude", "frequency", "allowed", "chosen"),
                rows,
                f"Estimated relative errors of the peak{of_case(name)}, by source",
                ("", "%", "%", "%", ""),
                flags,
            )
        )
        blocks += [Text(f"**{line}**") for line in errors.warnings]
        left = [(each.kind, each.what, each.evidence) for each in without]
        blocks.append(
            Table(
                ("left out", "what", "evidence"),
                left,
                f"What the model does without{of_case(name)}",
            )
        )
    blocks.append(Text(_not_estimated(told)))
    return Section("Convergence and errors", blocks, id="errors")


def _percent(value: float) -> float | None:
    return 100 * value if np.isfinite(value) else None


def _points(told: PageContent) -> Table:
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for each in told.summaries:
        found = told.answers.get(each.case)
        audit = found.audit if found else None
        rows.append(
            (
                fixed(words(each.case)),
                each.harmonics,
                each.points,
                each.points - each.converged,
                each.worst or None,
                None if audit is None else float(audit.residual[0]),
                None if audit is None else float(audit.imbalance[0]),
            )
        )
        flags.append("good" if each.converged == each.points else "bad")
    header = ("case", "H", "points", "lost", "their residual", "forces, checked", "power, checked")
    caption = "Points of each curve, and the peak checked by other code"
    return Table(header, rows, caption, flags=flags)


def _not_estimated(told: PageContent) -> str:
    given = told.run_data.given
    told_of = []
    if isinstance(given, Scene):
        told_of.append(
            "**Matrices, harmonics and frequency points**: chosen by the scene, their errors not "
            "estimated."
        )
    elif not told.worth:
        told_of.append(
            "**Mesh, harmonics and frequency points**: chosen by the study, their errors not "
            "estimated; `accuracy = 0.01` asks for estimates, `vanelock converge` measures them."
        )
    if not isinstance(given, Scene):
        told_of.append(
            "**Stresses**: no error is estimated; they converge more slowly than frequencies, and "
            "not at all at sharp corners and point forces."
        )
    told_of += [
        "**Contact**: stiffnesses, friction and interference are inputs; their scatter between "
        "builds is usually larger than every number in this section.",
        "**Stability**: a solved point need not be stable; another solution, or a wave that does "
        "not travel, may exist beside it.",
    ]
    if given.ring.sectors > 1:
        told_of.append("**Mistuning**: all sectors are alike.")
    if given.response.samples is not None:
        told_of.append("**Samples**: contact forces are sampled, their error is not estimated.")
    return "Not estimated:\n\n" + "\n\n".join(told_of)
