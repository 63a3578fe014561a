"""The pictures of a run, in the order in which they are drawn and shown."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import wait
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vanelock import render
from vanelock.input.cases.values import Given
from vanelock.input.schema.outputs import Outputs
from vanelock.pipeline.progress import Notice
from vanelock.pipeline.step import Stages
from vanelock.quantities.answers import CaseAnswers, answers, balances
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.contacts.energy import EnergyBalance
from vanelock.quantities.curves_and_fields import RunData, Shown
from vanelock.quantities.scatter import Scattered
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
from vanelock.results.files.redrawn import REPORT, OutputFiles
from vanelock.stages.plan import Planned

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis

__all__ = ["Pictures", "Shown"]


@dataclass
class Pictures:
    """All pictures of a run."""

    given: Given
    planned: Sequence[Planned]
    stages: Stages
    shown: Shown
    output_files: OutputFiles
    analyses: "Sequence[Analysis[Any, Any]]" = ()
    results: Mapping[str, CaseResult] = field(default_factory=dict)
    scattered: Scattered | None = None
    wear: dict[str, Path] = field(default_factory=dict)

    @cached_property
    def run_data(self) -> RunData:
        """What they are drawn from."""
        return RunData(
            self.given,
            self.planned,
            self.stages,
            self.shown,
            self.output_files,
            self.analyses,
            self.results,
        )

    def draw(self) -> list[Picture]:
        """Draw what is not there yet, and remove what earlier runs drew and this one does not."""
        run_data, outputs = self.run_data, self.given.outputs
        shapes = isinstance(outputs, Outputs) and outputs.shapes
        with self.output_files.put_off():
            made = self._drawn(shapes)
        if shapes:
            wait([render.trial()])  # one for all copies, which could not wait for its thread
        with self.output_files.shared():
            if outputs.report:
                for found in self.answers.values():
                    made += _own(found.planned, [haigh(run_data, found)] if found.margins else [])
        if outputs.report:
            self.wear = {name: wear_table(run_data, found) for name, found in self.answers.items()}
        self.output_files.tidy(keep=[REPORT] if outputs.report else [])
        return made

    def _drawn(self, shapes: bool) -> list[Picture]:
        """All that need no answers."""
        run_data, outputs = self.run_data, self.given.outputs
        made = [curves(run_data), *campbells(run_data), *preloads(run_data)]
        if self.scattered is not None:
            made.insert(1, scatters(run_data, self.scattered))
        detailed = self._detailed()
        moving = {each.case.name for each in (*detailed[:1], *detailed[-1:])}
        moving = moving if getattr(outputs, "animations", False) else set()
        if outputs.loops:
            for each in detailed:
                made += _own(each, loops(run_data, each))
        if shapes:
            modes = all_modes(run_data)
            made.append(mesh(run_data, self.planned[0], modes[0].data if modes else ()))
            made += mesh_errors(run_data, self.planned[0])
            made += modes
            for each in detailed:
                made += _own(each, response(run_data, each, each.case.name in moving))
            for each in detailed:
                made += _own(each, [stress(run_data, each), contacts(run_data, each)])
        for each in detailed:
            for analysis in self.analyses:
                if analysis.key in each.analyses:
                    case = replace(self.results[each.case.name], planned=each)
                    drawn = analysis.pictures(run_data, case)
                    made += (replace(one, section=analysis.key) for one in _own(each, drawn))
        return made

    @cached_property
    def answers(self) -> dict[str, CaseAnswers]:
        """Margins, wear and damping of the cases that are looked into."""
        return answers(self.run_data)

    @cached_property
    def balances(self) -> dict[str, EnergyBalance]:
        """Energies at the peaks of all cases."""
        return balances(self.run_data)

    def _detailed(self) -> list[Planned]:
        """Cases with pictures of their own; says which, if any are drawn."""
        cases, count = named(self.run_data), len(self.shown.peak)
        wanted = self.given.outputs
        drawn = [name for name in ("loops", "shapes") if getattr(wanted, name, False)]
        if drawn and len(cases) < count:
            text = f"pictures of {' and '.join(drawn)} for {in_words(self.run_data)} of {count}"
            self.output_files.listener(Notice(text))
        return cases


def _own(each: Planned, made: Iterable[Picture]) -> Iterator[Picture]:
    """Pictures of a case."""
    return (replace(picture, case=each.case.name) for picture in made)
