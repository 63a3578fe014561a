"""What a fit found, in a table with its doubts, and for machines."""

from typing import Any

import numpy as np

from vanelock.commands.fit.parameters import in_words
from vanelock.commands.fit.solution import RISE, UNDETERMINED, Direction, FitSolution
from vanelock.common.tables import Cell, Column, Table

SMALL = 0.1
"""Of a direction's largest component, below which others are not named."""


def fit_table(solution: FitSolution, name: str) -> Table:
    """One line for each parameter, the doubts below."""
    columns = (
        Column("parameter"),
        Column("study", form=".5g", key="start"),
        Column("fitted", form=".5g", key="value"),
        Column("unit"),
        Column("std. error", "%", ".2g", "error_percent"),
        Column("-2 sigma", form=".5g", key="low"),
        Column("+2 sigma", form=".5g", key="high"),
        Column("bounds"),
    )
    rows: list[tuple[Cell, ...]] = []
    for i, parameter in enumerate(solution.parameters):
        value, error = float(solution.value[i]), float(solution.deviation[i])
        if not parameter.logarithmic:
            error *= max(abs(parameter.low), abs(parameter.high)) / max(abs(value), 1e-300)
        errors = (error, *solution.interval(i)) if solution.carried else (None, None, None)
        begun = parameter.name, parameter.start, value, parameter.unit
        rows.append((*begun, *errors, parameter.span))
    return Table(f"Fit: {name}", columns, rows, notes(solution), "fit")


def notes(solution: FitSolution) -> list[str]:
    """Misfit and correlations, and whatever should keep one from believing the values."""
    keys = [each.name for each in solution.parameters]
    unit = "standard deviations" if solution.sigma_known else "of the largest measured amplitude"
    before, after = (
        f"{each:.3g}" if solution.sigma_known else f"{100 * each:.3g} %"
        for each in (solution.before, solution.after)
    )
    said = [f"root mean square misfit: {before} before, {after} after ({unit})"]
    pairs = [
        f"{keys[i]} and {keys[j]} {solution.correlation[i, j]:+.2f}"
        for i in range(len(keys))
        for j in range(i)
    ]
    if pairs and solution.carried:
        said.append("correlation of errors: " + ", ".join(pairs))
    if solution.sigma_known and solution.scale > 1 and solution.carried:
        said.append(f"errors are {solution.scale:.2f} times those of the given scatter alone")
    said += doubts(solution)
    return said


def doubts(solution: FitSolution) -> list[str]:
    """What the data do not say, or the model does not."""
    keys = [each.name for each in solution.parameters]
    said = [f"NOT DETERMINED: {_moved(keys, each)}" for each in solution.undetermined]
    for i, key in enumerate(keys):
        if solution.held[i]:
            said.append(f"{key} LIES ON A BOUND: its error says nothing beyond it")
    said += [
        f"THE MODEL MISSES THE DATA: {each.text}: in {_share(each.p)} of fits to noise alone"
        for each in solution.missed
    ]
    said += [f"LINEAR THEORY DOES NOT HOLD: {_fall(solution, keys, i)}" for i in solution.flat]
    if not solution.carried:
        said.append(
            "STANDARD ERRORS ARE WITHHELD: they would hold if residuals were noise and the curves "
            "linear in the parameters as far as the errors reach"
        )
    if solution.lost:
        said.append(f"{solution.lost} measured points have no converged response and were left out")
    for start in solution.as_good():
        values = in_words(solution.parameters, start.fitted)
        text = f"ANOTHER FIT IS AS GOOD: {values} (misfit {start.after:.3g})"
        said += [text] * (text not in said)
    return [*said, *solution.remarks]


def _share(p: float) -> str:
    return "less than 0.1 %" if p < 1e-3 else f"{100 * p:.1f} %"


def _fall(solution: FitSolution, keys: list[str], i: int) -> str:
    """Where the misfit does not rise as it should."""
    v, size = solution.directions[i].along, 100 * solution.directions[i].deviation
    key = keys[int(np.argmax(np.abs(v)))]
    rises = " and ".join(f"{each:.2g}" for each in solution.rises[i])
    return (
        f"one standard error of {key} ({size:.2g} %) down and up, the squared misfit rises {rises} "
        f"times as far as it should (at least {RISE:.2g} is asked for): a jump of the curves may "
        "lie next to a point"
    )


def _moved(keys: list[str], direction: Direction) -> str:
    """A direction as what can be traded: ten per cent of its largest parameter."""
    v = direction.along
    most = int(np.argmax(np.abs(v)))
    share = v / v[most]
    words = []
    for i in np.argsort(-np.abs(share)):
        if abs(share[i]) >= SMALL:
            change = 100 * (1.1 ** float(share[i]) - 1)
            words.append(f"{keys[i]} {change:+.2g} %")
    together = " with ".join(words)
    return (
        f"{together} changes the curves by less than their scatter; standard error that way "
        f"{100 * direction.deviation:.2g} % (limit {100 * UNDETERMINED:.0f} %): give one of them"
        if len(words) > 1
        else f"{keys[most]}: standard error {100 * direction.deviation:.2g} %: the curves hardly "
        "depend on it"
    )


def json_of(solution: FitSolution) -> dict[str, Any]:
    """A fit for machines."""
    return {
        "parameters": [
            {
                **each.record(solution.value[i]),
                "relative_error" if each.logarithmic else "error_of_largest_bound": float(
                    solution.deviation[i]
                )
                if solution.carried
                else None,
                "two_sigma": list(solution.interval(i)) if solution.carried else None,
                "on_bound": solution.held[i],
            }
            for i, each in enumerate(solution.parameters)
        ],
        "correlation": solution.correlation.tolist() if solution.carried else None,
        "misfit_before": solution.before,
        "misfit_after": solution.after,
        "misfit_unit": "standard deviations"
        if solution.sigma_known
        else "largest measured amplitude",
        "scale": solution.scale,
        "points_lost": solution.lost,
        "tests": [
            {"name": each.name, "statistic": each.statistic, "p": each.p, "failed": each.failed}
            for each in solution.tests
        ],
        "rises": [list(each) for each in solution.rises],
        "directions": [
            {"along": each.along.tolist(), "error": each.deviation} for each in solution.directions
        ],
        "starts": [
            {"from": each.value.tolist(), "to": each.fitted.tolist(), "misfit": each.after}
            for each in solution.starts
        ],
        "doubts": doubts(solution),
    }
