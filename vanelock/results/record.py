"""What a run writes into its results file, and when."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import h5py

from vanelock.common.product import Product
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Stages, Step
from vanelock.quantities import warnings
from vanelock.quantities.answers import CaseAnswers
from vanelock.results.files import writer
from vanelock.results.files.ledger import Ledger
from vanelock.rom import Component, System
from vanelock.stages.campbell.campbell import Campbell
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.meshes import mesh_step
from vanelock.stages.plan import LIMITS, Linear, Planned
from vanelock.stages.response.summary import Summary
from vanelock.stages.sweep.retries import Solved


class Record(Ledger):
    """The results file of a run, written part by part as they come.

    Parameters
    ----------
    folder : Path
        The run's folder.
    stages : Stages
        Where the products come from.
    """

    def __init__(self, folder: Path, stages: Stages) -> None:
        super().__init__(folder)
        self._stages = stages
        self._places: dict[str, str] = {}

    def provenance(self, study: Study, text: str) -> None:
        """Begin the file: what is computed, when and by which versions."""
        self.begin(study.model_dump_json(), text)

    def product(self, where: str, product: Product) -> None:
        """A product of its own."""
        with self._file.edit(where) as file:
            self._file.put(file, where, product, {})

    def parts(self, planned: Planned) -> None:
        """Meshes, reduced parts and system of the first case."""
        products = self._products(planned)
        with self._file.edit("mesh", "rom", "system") as file:
            self._write(file, planned, products, "")

    def _products(self, planned: Planned) -> dict[str, Product]:
        """What a case has that is not in the file yet, by key; its system always."""
        steps: list[Step[Any]] = [mesh_step(planned.case.study, part) for part in PARTS]
        steps += [*planned.rom.values(), *self._others(planned).values()]
        wanted = [step for step in steps if step.key not in self._places]
        return {step.key: self._stages.get(step) for step in [*wanted, planned.system]}

    def _others(self, planned: Planned) -> dict[int, Step[Any]]:
        """The casing at further nodal diameters, where each is reduced by itself."""
        steps = {k: planned.part("casing", k) for k in planned.diameters}
        return {k: step for k, step in steps.items() if step.key != planned.rom["casing"].key}

    def _write(
        self, file: h5py.File, planned: Planned, products: dict[str, Product], under: str
    ) -> None:
        for part in PARTS:
            mesh, reduced = mesh_step(planned.case.study, part).key, planned.rom[part].key
            if mesh in products:
                self._places[mesh] = f"{under}/mesh/{part}"
                self._file.put(file, self._places[mesh], products[mesh], {})
            if isinstance(component := products.get(reduced), Component):
                self._places[reduced] = f"{under}/rom/{part}"
                self._file.put_component(file, self._places[reduced], component)
        others = self._others(planned)
        for k, step in others.items():
            if isinstance(component := products.get(step.key), Component):
                self._places[step.key] = f"{under}/rom/casing_nd{k}"
                self._file.put_component(file, self._places[step.key], component)
        system = products[planned.system.key]
        assert isinstance(system, System)
        self._file.put_system(file, f"{under}/system", system)

    def linear(self, linear: Linear, whole: bool = True) -> None:
        """Modes of a set of limits, and their responses, unless there are many sets."""
        limits = self._stages.get(linear.limits)
        responses: dict[str, Response] = {
            which: self._stages.get(linear.responses[which]) for which in (LIMITS if whole else ())
        }
        self._limits(linear.name, limits, responses)

    def case(self, solved: Solved, summary: Summary, monitor: str) -> None:
        """Everything about a case, at once."""
        planned, response, static = solved.planned, solved.response, solved.static
        where = f"response/{planned.case.name}"
        products = self._products(planned)
        with self._file.edit(where) as file:
            self._write(file, planned, products, f"/{where}")
            self._file.put(file, where, response, _attributes(planned, summary, monitor))
            self._file.put(file, f"{where}/preload", static, {})
            if solved.other is not None:
                self._file.put(file, f"{where}/lower", solved.other, {})
            writer.put_jumps(file, where, summary.sweeps)
            if solved.strain is not None:
                writer.put_strain(file, where, solved.strain)
            if solved.worth is not None:
                writer.put_errors(file, where, *solved.worth)

    def answers(self, found: Mapping[str, CaseAnswers]) -> None:
        """Damping, margin and energy at the peak of the cases that are looked into."""
        for name, each in found.items():
            with self._file.edit(f"response/{name}") as file:
                writer.put_answers(file, f"response/{name}", each.numbers)

    def campbell(self, case: str, diagram: Campbell) -> None:
        """The Campbell diagram of a case."""
        self.product(f"campbell/{case}", diagram)


def _attributes(planned: Planned, summary: Summary, monitor: str) -> dict[str, Any]:
    """The summary as attributes of the case."""
    values: dict[str, Any] = {"monitor": monitor, "key": planned.response.key}
    values["warnings"] = warnings.of_case(summary)
    values |= {f"sweep {key}": value for key, value in planned.case.values.items()}
    for name, value in asdict(summary).items():
        if isinstance(value, int | float):
            values[name] = value
    if summary.peak is not None:
        values["peak_frequency"] = summary.peak.frequency
        values["peak_amplitude"] = summary.peak.amplitude
    return values
