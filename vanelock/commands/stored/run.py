"""A run as one object, read from its folder: its cases, their table, responses and curves.

Tables are pandas' and responses xarray's, which are optional.

`vanelock page`: tables, pictures and page of a run again, from its results alone.
"""

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from vanelock import render
from vanelock.commands.stored.contents import StoredRun, load_run
from vanelock.common.cyclic import COMPONENTS
from vanelock.common.errors import InputError
from vanelock.common.files.digests import verify
from vanelock.common.lazy import library
from vanelock.common.process import largest
from vanelock.common.tables import Table
from vanelock.pipeline.progress import Finished, Listener, silent
from vanelock.quantities.run_result import MANY, RunResult, looked_into_names
from vanelock.results.figures.curves import called, limit_curves, one_order
from vanelock.results.files.results_file import NAME, load_system, open_results, response_group
from vanelock.results.files.run_folder import REPORT, OutputFiles, claimed
from vanelock.results.listing import case_row, case_table, tables
from vanelock.results.page import show
from vanelock.rom import System
from vanelock.stages.response.responses import CARTESIAN

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


EXTRA = "frames"


def frame(table: Table, more: Mapping[str, Sequence[Any]]) -> "pandas.DataFrame":
    """A table's columns by their heads, and further ones behind the first of them."""
    made = library("pandas", EXTRA, "Run.table").DataFrame(table.by_head())
    for place, (name, values) in enumerate(more.items(), start=1):
        made.insert(place, name, list(values))
    return made


def dataset(
    response: h5py.Group,
    outputs: Sequence[str],
    directions: Sequence[str],
    about: Mapping[str, Any],
) -> "xarray.Dataset":
    """A stored response of outputs in some directions, frequencies ascending.

    What did not converge is NaN there, since nothing of it is to be trusted.
    """
    xarray_library = library("xarray", EXTRA, "Run.response")
    order = np.argsort(response["frequency"][()], kind="stable")
    converged = response["converged"][()][order]
    by_point = ["frequency", "output", "direction"]
    by_harmonic = ["frequency", "harmonic", "output", "direction"]

    def known(name: str) -> Any:
        values = response[name][()][order]
        values[~converged] = np.nan
        return values

    amplitude, displacement = known("amplitude"), known("output")
    half = {"units": "m", "long_name": "half the peak-to-peak"}
    wave = {"units": "m", "long_name": "coefficients q^(h) of q(t) = Re Σ q^(h) exp(i h ω t)"}
    made: xarray.Dataset = xarray_library.Dataset(
        {
            "amplitude": (by_point, amplitude, half),
            "displacement": (by_harmonic, displacement, wave),
            "converged": (["frequency"], converged),
            "residual": (["frequency"], response["residual"][()][order]),
        },
        {
            "frequency": ("frequency", response["frequency"][()][order], {"units": "Hz"}),
            "harmonic": np.arange(displacement.shape[1]),
            "output": list(outputs),
            "direction": list(directions),
        },
        dict(about),
    )
    return made


@dataclass(frozen=True, repr=False)
class Run:
    """What a run found, read from its folder.

    Attributes
    ----------
    folder : Path
        The run's folder.
    contents : StoredRun
        What is in its results file but for responses and matrices, SI.
    """

    folder: Path
    contents: StoredRun

    def __repr__(self) -> str:
        """One line: where, how many cases, and whether that is all."""
        failed = f", {len(self.failed)} FAILED" if self.failed else ""
        end = "" if self.complete else ", not complete"
        cases = f"{len(self.cases)} case{'' if len(self.cases) == 1 else 's'}"
        return f"Run('{self.folder}': {cases}{failed}{end})"

    def _repr_html_(self) -> str | None:
        """The same with the table, for a notebook; None where pandas is not there."""
        try:
            return f"<p>{escape(repr(self))}, {escape(self.monitor)}</p>{self.table.to_html()}"
        except InputError:
            return None

    @property
    def cases(self) -> tuple[str, ...]:
        """Names of the cases that were computed, in the order of the sweep."""
        return tuple(self.contents.cases)

    @property
    def failed(self) -> Mapping[str, str]:
        """Cases that could not be computed, and why."""
        return {name: each.reason for name, each in self.contents.failed.items()}

    @property
    def complete(self) -> bool:
        """False where the run was stopped, or is under way."""
        return self.contents.complete

    @property
    def monitor(self) -> str:
        """The displacement that peaks and curves are of, such as "vane output 1, radial"."""
        return self.contents.monitor.name

    @property
    def page(self) -> Path:
        """The page for a colleague, report.html.

        Raises
        ------
        InputError
            If there is none.
        """
        path = self.folder / REPORT
        if path.is_file():
            return path
        reason = "outputs.show has none" if self.complete else "not complete"
        raise InputError(f"{self.folder}: no {REPORT}: {reason}")

    @property
    def table(self) -> "pandas.DataFrame":
        """A row for each case: its swept keys, SI, and the table of the terminal and the page.

        Columns have the heads and units of these, such as "peak (µm)" and "at (Hz)". Damping and
        stress are those of the cases that the page looks into.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        found = self.contents.cases.values()
        keys = dict.fromkeys(key for each in found for key in each.values)
        swept = {key: [each.values.get(key) for each in found] for key in keys}
        rows = [case_row(each.summary, each.numbers) for each in found]
        return frame(case_table(rows, self.monitor), swept)

    def response(self, case: str | None = None) -> "xarray.Dataset":
        """The response of a case at every output, whose points that did not converge are NaN.

        Parameters
        ----------
        case : str, optional
            Its name, as `cases` has it, or a linear limit, "free" or "stuck"; by default the first
            case.

        Returns
        -------
        xarray.Dataset
            Over `frequency` (p,), Hz: `amplitude` (p, o, 3), half the peak-to-peak of each output
            and direction, m; `displacement` (p, H + 1, o, 3) complex, its harmonics, m;
            `converged` and `residual` (p,). Swept values are attributes.

        Raises
        ------
        InputError
            If there is no such case, which lists what there is, or xarray is not installed.
        """
        first = self._first()
        with open_results(self.folder / NAME, complete=False) as file:
            name = first if case is None else case
            group, own = response_group(file, name), response_group(file, first)
            verify(group)
            about: dict[str, Any] = {"case": name, "monitor": self.monitor}
            if name in self.contents.cases:
                about |= self.contents.cases[name].values
                own = group
            names = own["system/output/name"].asstr()[()].tolist()
            turned = self.monitor.rpartition(", ")[2] in COMPONENTS  # about the engine's axis
            return dataset(group, names, COMPONENTS if turned else CARTESIAN, about)

    def system(self, case: str | None = None) -> System:
        """The system that a case, by default the first one, was solved with.

        Raises
        ------
        InputError
            If there is no such case.
        """
        return load_system(self.folder / NAME, self._first() if case is None else case)

    def plot(self, *cases: str, logarithmic: bool = False) -> "Figure":
        """Response curves of the monitored displacement, with the linear limits.

        Parameters
        ----------
        cases : str
            Names of cases; by default all, of more than 24 the first, the last, and those of the
            lowest and the largest peak.
        logarithmic : bool
            Logarithmic amplitudes.

        Returns
        -------
        matplotlib.figure.Figure
            In the style of the program's own; a notebook shows it, `savefig` writes it.

        Raises
        ------
        InputError
            If there is no such case.
        """
        run, found = self.contents, self.contents.cases
        few = list(found) if len(found) <= MANY else looked_into_names(run)
        for name in cases or (self._first(),):
            if name not in found:
                self._refuse(name)
        shown = [found[name] for name in cases or few]
        curves = [
            render.Curve(
                *each.line,
                group=called(each.name),
                harmonics=each.summary.harmonics,
                joined=each.problem.response.frequencies is None,
            )
            for each in shown
        ]
        made: Figure = render.response_figure(
            [*limit_curves(run.limits), *curves],
            f"{run.problem.name}: forced response",
            self.monitor,
            logarithmic,
            one_order(shown),
        )
        return made

    def _first(self) -> str:
        """The first case."""
        if not self.cases:
            raise InputError(f"{self.folder}: no case is finished yet")
        return self.cases[0]

    def _refuse(self, name: str) -> None:
        """Say that there is no such case, and which there are."""
        with open_results(self.folder / NAME, complete=False) as file:
            response_group(file, name)
        raise InputError(f"{self.folder}: {name!r} is a linear limit, which every figure shows")


def load(folder: str | os.PathLike[str]) -> Run:
    """Read what a run left in its folder, be it complete or not.

    Parameters
    ----------
    folder : path
        The run's folder, such as "runs/my", or the results file in it.

    Raises
    ------
    InputError
        If it holds no results, or they are damaged, altered, or of another version.
    """
    path = _folder(folder)
    return Run(path, load_run(path))


def _folder(folder: str | os.PathLike[str]) -> Path:
    """A run's folder, which the results file in it stands for as well."""
    path = Path(folder)
    return path.parent if path.name == NAME else path


def show_again(folder: str | os.PathLike[str], listener: Listener = silent) -> RunResult:
    """Make all that a run shows from what its results file holds; nothing is computed.

    Parameters
    ----------
    folder : path
        The run's folder, or the results file in it; its cache need not be there, nor the files
        that its study names.
    listener : callable
        Called with the tables, with each picture drawn, and with where all of it is.

    Raises
    ------
    InputError
        If it holds no results, they are damaged, or no case is finished; after the tables, if the
        run is not complete.
    """
    place, began = _folder(folder), time.perf_counter()
    run = load_run(place)
    if not run.cases:
        raise InputError(f"{place}: no case is finished yet")
    with claimed(place):
        run.output_files = OutputFiles(place, listener)
        for table in tables(run):
            listener(table)
        if not run.complete:
            raise InputError(
                f"{place}: not complete, so without pictures and page: the same `vanelock run` "
                "goes on from there"
            )
        show(run)
    listener(finished(run, began))
    return run


def finished(run: RunResult, began: float, **summary: Any) -> Finished:
    """What is said of a run, or of one that is shown again, in the end: all that there is now."""
    folder = run.output_files.folder
    pictures = [str(file) for shown in run.pictures for file in (shown.path, *shown.data)]
    summary |= {"results": str(folder / NAME), "pictures": pictures}
    page = str(folder / REPORT) if "report" in run.problem.outputs.show else ""
    return Finished(str(folder), time.perf_counter() - began, summary, page, largest())
