"""What moves the peak of the cases that are looked into, key by key, to first order."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vanelock import report
from vanelock.analyses.analysis import Analysis
from vanelock.common.tables import Column, Table

if TYPE_CHECKING:
    from vanelock.analyses.analysis import RunResult
    from vanelock.quantities.sensitivities import Sensitivities
    from vanelock.report.blocks import Single

TEXT = (
    "By how many per cent the peak and its frequency move where one key grows by one per cent, all "
    "others held: the gradient of the solution at the peak, exact for small changes. Far from here "
    "it changes, and where contacts change their state it may jump."
)


def _page(run: "RunResult") -> "list[report.Block]":
    """What moves the peak of each case that is looked into."""
    by_case: dict[str, list[Single]] = {}
    for name, each in run.looked_into.items():
        if (moved := each.sensitivities) is not None:
            reason = report.Text(f"Not known: {moved.reason}.")
            by_case[name] = [reason if moved.reason else _table(moved)]
    return [report.Text(TEXT), *run.of_cases(by_case)] if by_case else []


def _table(moved: "Sensitivities") -> Table:
    """What moves the peak of a case, by key, what moves it most first."""
    order = np.argsort(-np.abs(moved.amplitude), kind="stable")
    columns = (
        Column("1 % more of", key="key"),
        Column("peak (%)", form="+.3f", key="amplitude"),
        Column("its frequency (%)", form="+.4f", key="frequency"),
    )
    rows = [(moved.keys[i], moved.amplitude[i], moved.frequency[i]) for i in order]
    frequency, amplitude = moved.at
    title = f"What moves the peak of {1e6 * amplitude:.4g} µm at {frequency:.6g} Hz"
    return Table(title, columns, rows, key="sensitivities")


SENSITIVITIES: Analysis[Any, Any] = Analysis(
    key="sensitivities", title="what moves the peak", looked_into=True, page=_page
)
