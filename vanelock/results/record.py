"""What a run writes into its results file, and when."""

import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py

import vanelock
from vanelock.common.process.signals import raise_dropped
from vanelock.common.process.version import installed
from vanelock.common.product import Product
from vanelock.input.cases.values import Given, diameter_of
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Done
from vanelock.pipeline.step import Stages, Step
from vanelock.pipeline.tasks import Failure
from vanelock.quantities import warnings
from vanelock.quantities.answers import CaseAnswers
from vanelock.quantities.case_result import CaseResult
from vanelock.results.files import writer
from vanelock.results.files.results_file import NAME
from vanelock.results.files.writer import Results
from vanelock.rom import Component, System
from vanelock.stages.campbell.campbell import Campbell
from vanelock.stages.linear import Linear
from vanelock.stages.plan import Planned
from vanelock.stages.response.responses import LIMITS
from vanelock.stages.response.summary import Summary

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis

LIBRARIES = (
    "gmsh",
    "h5py",
    "matplotlib",
    "numba",
    "numpy",
    "pydantic",
    "pyvista",
    "scikit-fem",
    "scikit-sparse",
    "scipy",
    "vtk",
)


class Record:
    """The results file of a run, written part by part as they come."""

    def __init__(self, folder: Path, stages: Stages) -> None:
        self._file = Results(folder / NAME)
        self._stages = stages
        self._places: dict[str, str] = {}

    def provenance(self, given: Given, text: str) -> None:
        """Begin the file: what is computed (as JSON, and as it was given), when and by what."""
        settings = given.model_dump_json()
        self._file.wait_for_the_end(settings)
        with self._file.edit() as file:
            group = file.require_group("provenance")
            group.attrs["date"] = datetime.now(UTC).isoformat(timespec="seconds")
            group.attrs["study"] = text
            group.attrs["settings"] = settings
            versions = group.require_group("versions")
            versions.attrs["vanelock"] = vanelock.__version__
            versions.attrs["python"] = platform.python_version()
            versions.attrs["platform"] = platform.platform()
            for library in LIBRARIES:
                versions.attrs[library] = installed(library)

    def together(self) -> AbstractContextManager[None]:
        """Let all that a block writes appear at once."""
        return self._file.together()

    def product(self, where: str, product: Product) -> None:
        """A product of its own."""
        with self._file.edit(where) as file:
            self._file.put(file, where, product, {})

    def parts(self, planned: Planned) -> None:
        """Meshes, reduced parts and system of the first case."""
        products = self._products(planned)
        groups = {"Part": "mesh", "Component": "rom", "Piece": "component", "System": "system"}
        kinds = {type(product).__name__ for product in products.values()}
        with self._file.edit(*(place for kind, place in groups.items() if kind in kinds)) as file:
            self._write(file, planned, products, "")

    def _products(self, planned: Planned) -> dict[str, Product]:
        """What a case has that is not in the file yet, by key; its system always."""
        wanted = [step for step in _named(planned).values() if step.key not in self._places]
        return {step.key: self._stages.get(step) for step in [*wanted, planned.system]}

    def _write(
        self, file: h5py.File, planned: Planned, products: dict[str, Product], under: str
    ) -> None:
        for name, step in _named(planned).items():
            if (product := products.get(step.key)) is None:
                continue
            self._places[step.key] = place = f"{under}/{name}"
            if isinstance(product, Component):
                self._file.put_component(file, place, product)
            else:
                self._file.put(file, place, product, {})
        system = products[planned.system.key]
        assert isinstance(system, System)
        self._file.put_system(file, f"{under}/system", system)

    def linear(self, linear: Linear, whole: bool = True) -> None:
        """Modes of a set of limits, and their responses, unless there are many sets."""
        limits = self._stages.get(linear.limits)
        responses: dict[str, Response] = {
            which: self._stages.get(linear.responses[which]) for which in (LIMITS if whole else ())
        }
        named = {f"{which},{linear.name}" if linear.name else which: which for which in responses}
        places = [f"limits/{linear.name or 'all'}", *(f"response/{name}" for name in named)]
        with self._file.edit(*places) as file:
            self._file.put(file, places[0], limits, {})
            for name, which in named.items():
                self._file.put(file, f"response/{name}", responses[which], {"linear": which})

    def case(self, result: CaseResult, analyses: "Sequence[Analysis[Any, Any]]") -> None:
        """Everything about a case, at once."""
        summary, monitor = result.summary, result.monitor.name
        planned, (response, *others) = result.planned, result.responses
        where = f"response/{planned.case.name}"
        products = self._products(planned)
        with self._file.edit(where) as file:
            self._write(file, planned, products, f"/{where}")
            self._file.put(file, where, response, _attributes(planned, summary, monitor))
            self._file.put(file, f"{where}/preload", result.static, {})
            for other in others:
                self._file.put(file, f"{where}/lower", other, {})
            for analysis in analyses:
                for i, product in enumerate(result.found(analysis.key)):
                    if place := analysis.places(product):
                        lower = "lower/" if analysis.by_response and i else ""
                        self._file.put(file, f"{where}/{lower}{place}", product, {})
            writer.put_jumps(file, where, summary.sweeps)
            if result.strain is not None:
                writer.put_strain(file, where, result.strain)
            if result.errors is not None:
                writer.put_errors(file, where, *result.errors)

    def answers(
        self, found: Mapping[str, CaseAnswers], analyses: "Sequence[Analysis[Any, Any]]"
    ) -> None:
        """Damping, margin, energy and what moves the peak of the cases that are looked into."""
        for name, each in found.items():
            with self._file.edit(f"response/{name}") as file:
                writer.put_answers(file, f"response/{name}", each.numbers(analyses))
                if each.sensitivities is not None:
                    self._file.put(file, f"response/{name}/sensitivities", each.sensitivities, {})

    def campbell(self, case: str, diagram: Campbell) -> None:
        """The Campbell diagram of a case."""
        self.product(f"campbell/{case}", diagram)

    def complete(self, done: Mapping[str, Done]) -> None:
        """End the file: times and hashes of all stages, nothing is missing."""
        with self._file.edit() as file:
            for key, entry in done.items():
                group = file.require_group(f"provenance/stages/{entry.stage} {key[:8]}")
                group.attrs["key"] = key
                group.attrs["seconds"] = entry.seconds
                group.attrs["cached"] = entry.cached
            file.attrs["complete"] = True
        self._file.end()

    def failed(self, name: str, values: Mapping[str, float | str], failure: Failure) -> None:
        """A case that could not be computed."""
        with self._file.edit() as file:
            group = file.require_group(f"failed/{name}")
            group.attrs["reason"], group.attrs["attempts"] = failure.reason, failure.attempts
            for key, value in values.items():
                group.attrs[f"sweep {key}"] = value

    def flush_if_due(self) -> None:
        """Let additions appear in the file, unless it is too soon after the last ones."""
        raise_dropped()
        self._file.flush_if_due()

    @contextmanager
    def finished(self, unshown: Callable[[], None]) -> Iterator[None]:
        """If this block ends early, let the last additions appear, as far as that can be done.

        `unshown` adds what is solved and was not yet added.
        """
        try:
            yield
        except BaseException:
            try:
                with suppress(Exception):
                    unshown()
                self._file.flush()
            finally:
                self._file.abandon()
            raise


def _named(planned: Planned) -> dict[str, Step[Any]]:
    """Places of a case's meshes and components; of those by nodal diameter the load's is plain."""
    named: dict[str, Step[Any]] = {f"mesh/{part}": each for part, each in planned.meshes.items()}
    kind = "rom" if planned.meshes else "component"
    for part in planned.structure.names:
        k = diameter_of(planned.case.given, 1)
        named[f"{kind}/{part}"] = loaded = planned.part(part, k)
        for k in planned.diameters:
            if (each := planned.part(part, k)).key != loaded.key:
                named[f"{kind}/{part}_nd{k}"] = each
    return named


def _attributes(planned: Planned, summary: Summary, monitor: str) -> dict[str, Any]:
    """The summary as attributes of the case."""
    values: dict[str, Any] = {"monitor": monitor, "key": planned.response.key}
    values["warnings"] = warnings.of_case(summary)
    values |= {f"sweep {key}": value for key, value in planned.case.values.items()}
    for name, value in asdict(summary).items():
        if isinstance(value, int | float):
            values[name] = value
    for name in ("peak", "lowest", "highest"):
        peak = getattr(summary, name)
        if peak is not None:
            at = "peak" if name == "peak" else f"{name}_peak"
            values[f"{at}_frequency"], values[f"{at}_amplitude"] = peak.frequency, peak.amplitude
    if summary.wave is not None:
        values["wave"] = summary.wave.verdict
        values["growth_in_a_period"] = summary.wave.growth
    return values
