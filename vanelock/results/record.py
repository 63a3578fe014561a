"""What a run writes into its results file, and when."""

import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import vanelock
from vanelock.common.arrays import Floats
from vanelock.common.process import installed, raise_dropped
from vanelock.common.product import Product
from vanelock.input.cases.values import Problem
from vanelock.pipeline.progress import Done
from vanelock.pipeline.step import Stages
from vanelock.pipeline.tasks import Failure
from vanelock.quantities import warnings
from vanelock.quantities.case_result import CaseResult, Numbers
from vanelock.quantities.products import structure_steps
from vanelock.quantities.run_result import RunResult
from vanelock.results.files.results_file import NAME, as_json
from vanelock.results.files.writer import Results
from vanelock.rom import Component
from vanelock.stages.parts.outputs import Strain
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import LIMITS, Limit
from vanelock.stages.response.summary import Sweep, figures
from vanelock.stages.structure import Linear

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

SHARED = ("mesh/", "rom/", "component/", "limits", "gauges", "mode_shapes", "mesh_error")
"""How places begin whose products cases may share."""
STORED = (
    *("values", "summary", "numbers", "detailed", "errors"),
    *("components", "ring", "linear_name", "preload_name"),
)
"""Fields of a `CaseResult` that are stored beside its products."""


def versions() -> dict[str, str]:
    """Versions of all that computes."""
    return {
        "vanelock": vanelock.__version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        **{library: installed(library) for library in LIBRARIES},
    }


class Record:
    """The results file of a run, written part by part as they come."""

    def __init__(self, folder: Path, stages: Stages) -> None:
        self._file = Results(folder / NAME)
        self._stages = stages
        self.date = datetime.now(UTC).isoformat(timespec="seconds")
        self._places: dict[str, str] = {}
        """Of products that cases may share, by key."""
        self._places_of: dict[str, dict[str, tuple[str, str]]] = {}
        self._written: dict[str, int] = {}

    def provenance(self, problem: Problem, text: str) -> None:
        """Begin the file: what is computed (as JSON, and as it was given), when and by what."""
        settings = problem.model_dump_json()
        self._file.wait_for_the_end(settings)
        with self._file.edit() as file:
            group = file.require_group("provenance")
            group.attrs["date"] = self.date
            group.attrs["study"] = text
            group.attrs["settings"] = settings
            group.attrs["given"] = problem.model_dump_json(exclude_unset=True)
            group.require_group("versions").attrs.update(versions())

    def product(self, where: str, product: Product) -> None:
        """A product of its own."""
        with self._file.edit(where) as file:
            self._file.put(file, where, product)

    def begun(self, run: RunResult, planned: Planned) -> None:
        """What all cases share, and meshes, reduced parts and system of the first one."""
        about = {
            "monitor": [run.monitor.name, run.monitor.node, run.monitor.component],
            "opens": run.opens,
            "measured": run.measured,
        }
        steps = structure_steps(planned)
        products = {place: self._stages.get(each) for place, each in steps.items()}
        system = self._stages.get(planned.system)
        places = dict.fromkeys(place.partition("/")[0] for place in products)
        with self._file.edit(*places, "system") as file:
            for place, product in products.items():
                self._put(file, steps[place].key, f"/{place}", product)
            self._file.put_system(file, "/system", system)
        with self._file.edit() as file:
            file["provenance/run"] = as_json(about)

    def _put(self, file: h5py.File, key: str, path: str, product: Product) -> None:
        """A product that cases may share, unless the file has it."""
        if key in self._places:
            return
        self._places[key] = path
        if isinstance(product, Component):
            self._file.put_component(file, path, product)
        else:
            self._file.put(file, path, product)

    def linear(
        self,
        linear: Linear,
        curves: Mapping[Limit, tuple[Floats, Floats]],
        with_responses: bool = True,
    ) -> None:
        """A set of limits, its curves (2, p) and, unless there are many sets, its responses."""
        limits = self._stages.get(linear.limits)
        kinds: Sequence[Limit] = LIMITS if with_responses else ()
        named = {f"{which},{linear.name}" if linear.name else which: which for which in kinds}
        places = [f"limits/{linear.name or 'all'}", *(f"response/{name}" for name in named)]
        with self._file.edit(*places) as file:
            self._put(file, linear.limits.key, f"/{places[0]}", limits)
            for which, curve in curves.items():
                file[places[0]].create_dataset(f"{which}_curve", data=curve)
            for name, which in named.items():
                response = self._stages.get(linear.responses[which])
                self._file.put(file, f"response/{name}", response)
                file[f"response/{name}"].attrs["linear"] = which

    def case(self, case: CaseResult) -> None:
        """Everything that is known of a case, at once; what was asked of it since, later."""
        where = f"response/{case.name}"
        with self._file.edit(where) as file:
            places = self._write(file, case, f"/{where}")
            if case.name not in self._written:
                self._written[case.name] = len(self._written)
                _put_jumps(file, where, case.summary.sweeps)
                if (strain := case.strain) is not None:
                    _put_strain(file, where, strain)
            group = file[where]
            if case.numbers:
                _put_answers(group, case.numbers)
            group.attrs.update(_attributes(case))
            if "about" in group:
                del group["about"]
            about = {**_about(case, places), "number": self._written[case.name]}
            group["about"] = as_json(about)

    def rest(self, run: RunResult) -> None:
        """What was asked of cases since they were written."""
        for case in run.cases.values():
            if case.numbers or not {*case.products.stored()} <= {*self._places_of[case.name]}:
                self.case(case)

    def _write(self, file: h5py.File, case: CaseResult, where: str) -> dict[str, tuple[str, str]]:
        """Write what is known of a case and not there yet; where each product is, and its key."""
        products, places = case.products, self._places_of.setdefault(case.name, {})
        for place in products.stored():
            if place in places:
                continue
            key, product = products.key(place), products.get(place)
            path = f"{where}/{_below(case, place, product)}".rstrip("/")
            if place.startswith(SHARED):
                self._put(file, key, path, product)
                path = self._places[key]
            elif place == "system":
                self._file.put_system(file, path, product)
            else:
                self._file.put(file, path, product)
            places[place] = path, key
        return places | {which: ("", products.key(which)) for which in LIMITS}

    def complete(self, done: Mapping[str, Done]) -> None:
        """End the file: times and hashes of all stages, nothing is missing."""
        with self._file.edit() as file:
            group = file.require_group("provenance/stages")
            text = h5py.string_dtype()
            for name, values in (
                ("name", [each.stage for each in done.values()]),
                ("key", [*done]),
            ):
                group.create_dataset(name, data=values, dtype=text)
            group["seconds"] = [each.seconds for each in done.values()]
            group["cached"] = [each.cached for each in done.values()]
            file.attrs["complete"] = True
        self._file.end()

    def failed(self, name: str, values: Mapping[str, float | str], failure: Failure) -> None:
        """A case that could not be computed."""
        with self._file.edit() as file:
            group = file.require_group(f"failed/{name}")
            group.attrs["reason"], group.attrs["attempts"] = failure.reason, failure.attempts
            group.attrs["number"] = len(file["failed"])
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


def _below(case: CaseResult, path: str, product: Product) -> str:
    """Where a product is in the results, below its case."""
    if path == "response":
        return ""
    name, _, number = path.partition(".")
    for analysis in case.analyses:
        if number and analysis.key == name:
            lower = "lower/" if analysis.by_response and number != "0" else ""
            return lower + (analysis.places(product) if analysis.places else name)
    return path


def _about(case: CaseResult, places: Mapping[str, tuple[str, str]]) -> dict[str, Any]:
    """All that is stored of a case but for its products."""
    return {
        "given": case.problem.model_dump(mode="json", exclude_unset=True),
        "places": places,
        **{name: getattr(case, name) for name in STORED},
    }


def _attributes(case: CaseResult) -> dict[str, Any]:
    """The summary as attributes of the case."""
    values: dict[str, Any] = {"monitor": case.monitor.name, "key": case.key_at("response")}
    values["warnings"] = warnings.of_case(case.summary)
    values |= {f"sweep {key}": value for key, value in case.values.items()}
    if case.summary.wave is not None:
        values["wave"] = case.summary.wave.verdict
    return values | figures(case.summary)


def _put_strain(file: h5py.File, where: str, strain: Strain) -> None:
    """Write what strain gauges read in a response beside it, as `gauge`."""
    dataset = file[where].create_dataset("gauge", data=strain.harmonics)
    dataset.attrs["unit"] = "1"
    dataset.attrs["name"] = list(strain.gauges.names)
    dataset.attrs["position"] = strain.gauges.positions
    dataset.attrs["direction"] = strain.gauges.directions


def _put_jumps(file: h5py.File, where: str, sweeps: Sequence[Sweep]) -> None:
    """Write where a response jumps, and the lower one, beside each as `jumps`."""
    for sweep, place in zip(sweeps, (where, f"{where}/lower"), strict=False):
        found = [(*jump.frequency, *jump.amplitude) for jump in sweep.jumps]
        dataset = file[place].create_dataset("jumps", data=np.array(found, float).reshape(-1, 4))
        dataset.attrs["columns"] = [
            "frequency before (Hz)",
            "frequency after (Hz)",
            "amplitude before (m)",
            "amplitude after (m)",
        ]


def _put_answers(group: h5py.Group, numbers: Numbers) -> None:
    """Write what a case answers at its peak into its group: values and their units."""
    answers = group.require_group("answers")
    for name, (value, unit) in numbers.items():
        answers.attrs[name] = value
        if unit:
            answers.attrs[f"{name} unit"] = unit
