"""Check a file without computing: what a study would compute, what a run's results hold."""

import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import h5py

from vanelock.commands.fit.parameters import fitted_parameters
from vanelock.common.checked import NotKnown
from vanelock.common.errors import InputError, raised
from vanelock.common.files.hdf5 import opened
from vanelock.common.product import Product
from vanelock.common.tables import Table, counted, heads
from vanelock.input.cases.sweep import Case, cases
from vanelock.input.measured.curve import curve_mistakes, load_measured
from vanelock.input.plausible import unusual
from vanelock.input.read_study import load_study
from vanelock.input.schema.own_mesh import OwnCasing, OwnVane, refuse_without_areas
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.nonlinear import Response, System
from vanelock.pipeline.cache import Cache, Entry
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.results.files import results_file
from vanelock.results.reading.contents import load_file
from vanelock.rom import Component
from vanelock.stages.accuracy.budget import SOURCES, pins
from vanelock.stages.accuracy.cost_estimate import estimated
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.meshes import mesh_step

P = TypeVar("P", bound=Product)
Row = tuple[str, str]
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
KINDS = {"mesh": Part, "reduced model": Component, "system": System, "response": Response}
"""Products of a results file that are read whole, by what they are called."""
LISTED = 5
"""Failed cases that are named."""


def check_file(path: str | os.PathLike[str], outside: bool = False) -> Table:
    """Check a study file, a results file or a run's folder, or a system from elsewhere.

    Parameters
    ----------
    path : path
        The file; a folder stands for the results in it.
    outside : bool
        Whether the files that a study names may lie outside its folder.

    Returns
    -------
    Table
        What would be computed, or what is there.

    Raises
    ------
    InputError
        As running the study, or comparing the results, would.
    """
    place = Path(path)
    if place.is_dir():
        place = place / results_file.NAME
        if not place.exists():
            raise InputError(f"{path}: holds no {results_file.NAME}: not the folder of a run")
    if is_hdf5(place):
        rows, title = _stored(place)
    else:
        rows, title = list(_planned(place, outside)), f"{place}: a study that can be run"
    return Table(title, heads("what", "found"), rows, key="check")


def is_hdf5(path: Path) -> bool:
    """Whether a file is, by its first bytes or its ending, one of HDF5."""
    if path.suffix.lower() in (".h5", ".hdf5"):
        return True
    try:
        with path.open("rb") as file:
            return path.is_file() and file.read(8) == _SIGNATURE
    except (OSError, ValueError):
        return False


@dataclass(frozen=True)
class _Unkept(Cache):
    """Products that are made for the check alone."""

    def load(self, stage: str, key: str, kind: type[Any]) -> Entry[Any] | None:
        """None is known."""
        return None

    def store(self, stage: str, key: str, product: P, seconds: float, cpu: float = 0.0) -> Entry[P]:
        """Hand it back and forget it."""
        return Entry(product, seconds, cpu)


def _planned(path: Path, outside: bool) -> Iterator[Row]:
    study = load_study(path, outside, _of_curves)
    found = cases(study)
    yield "name", study.name
    swept = ", ".join(found[0].values)
    yield "cases", f"{len(found):,} over {swept}" if swept else "1"
    if any(case.study.accuracy is not None for case in found):
        yield "accuracy", "; ".join(dict.fromkeys(_accuracy(case.study) for case in found))
    yield from (("warning", text) for text in unusual(study))
    own: dict[str, int] = {}
    yield from _parts(study, found, own)
    needed = estimated(found, own=own)
    if needed is not None:
        yield from ((what, f"about {value}") for what, value in needed.words().items())
        yield from [("warning", needed.warning)] if needed.warning else []
    curves = load_measured(study)
    for curve in curves:
        yield "measured", f"{curve.label}: {len(curve.frequency):,} points of {curve.quantity}"
    if study.fit is not None:
        names = ", ".join(each.key for each in fitted_parameters(study))
        yield "fit", f"{names} from {study.fit.starts} starts"
    yield "outputs", ", ".join(_outputs(study))


def _of_curves(study: Study, lacks: bool) -> list[str]:
    """What is wrong with the files of measured curves, and with the fit to them."""
    found: list[str] = []
    with suppress(NotKnown):
        found += curve_mistakes(study)
        if study.fit is not None and not lacks and not found:
            found += raised(lambda: fitted_parameters(study))
    return found


def _parts(study: Study, found: tuple[Case, ...], dofs: dict[str, int]) -> Iterator[Row]:
    """Sizes of the parts; a user's mesh is read and matched, once for each way that is swept.

    The degrees of freedom of these go into `dofs`.
    """
    own = {name for name in PARTS if isinstance(getattr(study, name), OwnVane | OwnCasing)}
    stages = Stages(_Unkept(Path(), lambda text: None), silent)
    steps = {}
    for case in found if own else ():
        for name in PARTS:
            step = mesh_step(case.study, name)
            if step.key not in steps:
                steps[step.key] = step
                part = stages.get(step)
                if name == "vane" and isinstance(study.vane, OwnVane):
                    refuse_without_areas(case.study, part)
    for name in PARTS:
        if name in own:
            part = stages.get(mesh_step(found[0].study, name))
            dofs[name] = 3 * len(part.points)
            sets = ", ".join(f"{key} {len(nodes)}" for key, nodes in part.node_sets.items())
            yield (
                name,
                f"{len(part.points):,} nodes, {len(part.cells):,} {part.cell_type}; {sets}",
            )
        else:
            sizes = dict.fromkeys(_elements(case.study) for case in found)
            yield name, f"from dimensions, elements {', '.join(sizes)}"


def _accuracy(study: Study) -> str:
    """The error that is asked for, and what is chosen for it."""
    if study.accuracy is None:
        return "as given"
    chosen = [source for source in SOURCES if source not in pins(study)]
    if study.response.friction == "orthogonal" and "samples" in chosen:
        chosen.remove("samples")  # its events are located
    text = f"an error of {100 * study.accuracy:g} %"
    return f"{text}: the run chooses {', '.join(chosen)}" if chosen else f"{text} is estimated"


def _elements(study: Study) -> str:
    """The size of the elements, or what it is chosen for."""
    if study.accuracy is not None and "mesh" not in pins(study):
        return f"chosen for an error of {100 * study.accuracy:g} %"
    size = study.mesh.size
    return size if isinstance(size, str) else f"{1e3 * size:g} mm"


def _outputs(study: Study) -> Iterator[str]:
    yield results_file.NAME
    yield "figures"
    wanted = study.outputs
    chosen = {
        "shapes": wanted.shapes,
        "loops": wanted.loops,
        "animations": wanted.animations,
        counted(wanted.steps, "instant"): wanted.steps > 0,
        counted(len(wanted.gauges), "gauge"): bool(wanted.gauges),
        "bounds over static friction": study.bounds is not None,
        "stability": study.stability is not None,
        "Campbell diagram": study.campbell is not None,
        "campaign": study.campaign is not None,
        "report.html": wanted.report,
    }
    yield from (name for name, there in chosen.items() if there)


def _stored(path: Path) -> tuple[list[Row], str]:
    """What an HDF5 file holds."""
    with opened(path, results_file.PARTS) as file:
        kind = str(file.attrs.get("format", ""))
    if kind == "vanelock-system":
        return list(_system(System.load(path))), f"{path}: a system that can be solved"
    with results_file.open_results(path) as file:
        loaded = load_file(path, path.parent.name, file)
        products = list(_products(file))
    rows = [
        ("complete", "yes" if loaded.complete else "NO: the run was stopped or is under way"),
        ("date", loaded.date),
        ("cases", f"{len(loaded.cases):,}"),
        ("failed", _failed(list(loaded.failed))),
        ("monitor", loaded.monitor or "-"),
        *((what, f"{size:,}") for what, size in loaded.sizes.items()),
        ("read", ", ".join(counted(products.count(n), n) for n in KINDS if n in products) or "-"),
    ]
    return rows, f"{path}: results of a run"


def _failed(names: list[str]) -> str:
    """How many cases could not be computed, and the first of them."""
    if not names:
        return "0"
    listed = ", ".join(name[:60] for name in names[:LISTED])
    return f"{len(names):,}: {listed}{', ...' if len(names) > LISTED else ''}"


def _system(system: System) -> Iterator[Row]:
    yield "sectors, engine order", f"{system.sectors}, {system.engine_order}"
    for k, matrices in system.diameters.items():
        yield f"nodal diameter {k}", f"{len(matrices.K):,} coordinates"
    yield "contacts", f"{len(system.contacts.kn):,}"


def _products(file: h5py.File) -> Iterator[str]:
    """Names of the products that could be read."""
    places = ["system"]
    for group, depth in (("mesh", 1), ("rom", 1), ("response", 1)):
        below = file.get(group)
        if isinstance(below, h5py.Group):
            places += [f"{group}/{name}" for name in below][: 100 * depth]
    for place in places:
        item = file.get(place)
        if not isinstance(item, h5py.Group):
            continue
        stored = str(item.attrs.get("product", "System" if place == "system" else ""))
        for name, kind in KINDS.items():
            if kind.__name__ == stored:
                kind.load(item)
                yield name
