"""Convergence and errors on a run's page: what is estimated, what is checked, and what is not."""

from vanelock.common.tables import Cell, Flag, Table, heads
from vanelock.input.cases.names import fixed, words
from vanelock.input.schema.scene import Scene
from vanelock.quantities.run_result import RunResult
from vanelock.report import Section, Text
from vanelock.report.blocks import Block
from vanelock.stages.accuracy.errors import error_table
from vanelock.stages.accuracy.left_out import left_out_table

CHECKED = (
    "Checked: at the peak every contact is marched in time by independent code and its forces are "
    "put into the equations of motion of the reduced model; the residual of forces, and of power, "
    "is given relative to the largest terms."
)


def convergence(run: RunResult) -> Section:
    """How sure the numbers are."""
    blocks: list[Block] = [_points(run), Text(CHECKED)]
    for name, (errors, without) in run.errors.items():
        case = words(name)
        blocks += [error_table(case, errors, run.monitor.name), left_out_table(case, without)]
    blocks.append(Text(_not_estimated(run)))
    return Section("Convergence and errors", blocks, id="errors")


def _points(run: RunResult) -> Table:
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for each in run.summaries:
        found = run.looked_into.get(each.case)
        audit = found.audit if found else None
        rows.append(
            (
                fixed(words(each.case)),
                each.harmonics,
                each.points,
                each.points - each.converged,
                each.worst or None,
                None if audit is None else audit.residual[0],
                None if audit is None else audit.imbalance[0],
            )
        )
        flags.append("good" if each.converged == each.points else "bad")
    columns = ("case", "H", "points", "lost", "max residual", "force residual", "power residual")
    title = "Points of each curve, and the peak checked by other code"
    return Table(title, heads(*columns), rows, flags=flags)


def _not_estimated(run: RunResult) -> str:
    given = run.given
    missing = []
    if isinstance(given, Scene):
        missing.append(
            "**Matrices and frequency points**: chosen by the scene, their errors not estimated; "
            "that of the harmonics to first order alone."
        )
    elif not run.errors:
        missing.append(
            "**Modes and frequency points**: chosen by the study, their errors not estimated; "
            "those of mesh and harmonics to first order alone, for the largest peak. "
            "`accuracy = 0.01` asks for estimates of all, `vanelock converge` measures them."
        )
        if given.mesh.correction != "none":
            missing.append(
                "**Mesh stiffening** is corrected, by the amount given with the linear limits. A "
                "quarter of it is uncertain, and amplitudes change with it."
            )
    if not isinstance(given, Scene):
        missing.append(
            "**Stresses**: no error is estimated; they converge more slowly than frequencies, and "
            "not at all at sharp corners and point forces."
        )
    missing += [
        "**Contact**: stiffnesses, friction and interference are inputs; their scatter between "
        "builds is usually larger than every number in this section.",
    ]
    missing += [
        text
        for analysis in run.analyses
        if analysis.keys_of(given) is None and (text := analysis.absent(run.first))
    ]
    if given.response.samples is not None:
        missing.append("**Samples**: contact forces are sampled, their error is not estimated.")
    return "Not estimated:\n\n" + "\n\n".join(missing)
