"""What a run's folder holds, read back: the same `RunResult` of which a run made its page."""

import json
import os
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vanelock.analyses import ANALYSES
from vanelock.analyses.scatter import Scattered
from vanelock.common.errors import InputError, printable
from vanelock.common.files.hdf5 import texts
from vanelock.common.process import latest
from vanelock.common.product import Product
from vanelock.files import problem_of
from vanelock.input.measured.curve import Measured
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Done, silent
from vanelock.pipeline.tasks import Failure
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.products import Products
from vanelock.quantities.run_result import RunResult
from vanelock.results.files.results_file import NAME, from_json, open_results
from vanelock.results.files.run_folder import OutputFiles
from vanelock.results.record import STORED
from vanelock.stages.response.limits import LIMITS
from vanelock.stages.response.responses import Monitor

REMEMBERED = 32
"""Products of a file that are remembered."""


class _StoredProducts(Products):
    """Those of a results file, by where it says that they are."""

    def __init__(
        self, path: Path, places: dict[str, tuple[str, str]], shared: dict[str, Any]
    ) -> None:
        super().__init__(shared)
        self._path, self._places = path, places

    def __contains__(self, path: str) -> bool:
        return bool(self._places.get(path, ("", ""))[0])

    def get(self, path: str) -> Any:
        """The product of a place."""
        if path not in self:
            raise InputError(f"{self._path}: lacks what a run writes ({path}); run it again")
        where = self._places[path][0]
        known = self.shared.setdefault("products", {})
        return latest(known, where, partial(_product, self._path, where), REMEMBERED)

    def key(self, path: str) -> str:
        """Hash of all that it depends on."""
        return self._places.get(path, ("", ""))[1]

    def expect(self, path: str, response: Response, of: str) -> None:
        """Nothing is made here."""


def _product(path: Path, where: str) -> Product:
    """A product of a results file, of the kind that it says."""
    with h5py.File(path, "r") as file, as_written(file):
        kind = str(file[where].attrs.get("product", "System"))
        return _kinds()[kind].load(file[where])


@lru_cache
def _kinds() -> dict[str, type[Product]]:
    """All products by their names."""
    for analysis in ANALYSES:
        if analysis.product is not None:
            analysis.product()
    found: dict[str, type[Product]] = {}
    waiting = [Product]
    while waiting:
        below = waiting.pop().__subclasses__()
        found |= {kind.__name__: kind for kind in below}
        waiting += below
    return found


@dataclass
class StoredRun(RunResult):
    """A run that was read.

    Attributes
    ----------
    label : str
        What tables call it.
    complete : bool
        False where the run was stopped or is under way.
    settings : dict
        The study with all defaults.
    """

    label: str = ""
    complete: bool = False
    settings: dict[str, Any] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Where it is."""
        return self.output_files.folder


def load_run(folder: Path) -> StoredRun:
    """Read a run's folder."""
    if not os.path.isdir(folder):
        raise InputError(f"{folder}: no such folder")
    path = folder / NAME
    if not path.exists():
        raise InputError(
            f"{folder}: holds no {NAME}: not the folder of a run, or of one just begun"
        )
    with open_results(path) as file, as_written(file):
        return contents_of(folder, file)


@contextmanager
def as_written(file: h5py.File) -> Generator[None]:
    """Refuse, in one line, what no run has written into a results file."""
    try:
        yield
    except KeyError as error:
        wrong, reason = "lacks what", str(error).strip("\"'")
    except (
        AttributeError, IndexError, MemoryError, OSError, OverflowError, RecursionError,
        RuntimeError, TypeError, ValueError,
    ) as error:  # fmt: skip
        wrong, reason = "holds something else than", str(error) or type(error).__name__
    else:
        return
    line = printable((reason.splitlines() or [""])[0])[:160]  # of a library, may quote the file
    raise InputError(f"{file.filename}: {wrong} a run writes ({line}); run it again")


def contents_of(folder: Path, file: h5py.File) -> StoredRun:
    """What an open results file holds; KeyError where something is missing."""
    about = file["provenance"]
    shared: dict[str, Any] = {}
    known = json.loads(_text(about["run"])) if "run" in about else {}
    run = StoredRun(
        problem=problem_of(json.loads(_text(about.attrs["given"]))),
        monitor=Monitor(*known.get("monitor", ("", 0, 0))),
        output_files=OutputFiles(folder, silent),
        analyses=ANALYSES,
        opens=known.get("opens", ""),
        measured=tuple(Measured(**_as_arrays(curve)) for curve in known.get("measured", ())),
        text=_text(about.attrs["study"]),
        failed={
            name: Failure(_text(of.attrs["reason"]), int(of.attrs["attempts"]))
            for name, of in sorted(
                file.get("failed", {}).items(), key=lambda item: int(item[1].attrs.get("number", 0))
            )
        },
        times=_times(about),
        shared=shared,
        label=folder.resolve().name,
        complete=bool(file.attrs.get("complete", False)),
        date=_text(about.attrs["date"]),
        settings=json.loads(about.attrs["settings"]),
        versions={_text(k): _text(value) for k, value in about["versions"].attrs.items()},
    )
    if "scatter" in file:
        run.scattered = Scattered.load(file["scatter"])
    responses = file.get("response", {}).items()
    found = {_text(n): json.loads(_text(g["about"])) for n, g in responses if "about" in g}
    for name in sorted(found, key=lambda name: found[name]["number"]):
        run.cases[name] = _case(name, found[name], run, file)
    limits = file.get("limits", {})
    for of in dict.fromkeys(each.linear_name for each in run.cases.values()):
        curves = {which: limits.get(f"{of or 'all'}/{which}_curve") for which in LIMITS}
        run.limits |= {(of, w): (c[0], c[1]) for w, c in curves.items() if c is not None}
    return run


def _case(name: str, about: dict[str, Any], run: StoredRun, file: h5py.File) -> CaseResult:
    """A case from what is stored of it."""
    hints = CaseResult.__annotations__
    places = from_json(dict[str, tuple[str, str]], about["places"])
    products = _StoredProducts(Path(file.filename), places, run.shared)
    return CaseResult(
        name=name,
        problem=problem_of(about["given"]),
        monitor=run.monitor,
        products=products,
        analyses=ANALYSES,
        values=about["values"],
        **{key: from_json(hints[key], about[key]) for key in STORED if key != "values"},
    )


def _as_arrays(stored: dict[str, Any]) -> dict[str, Any]:
    return {key: np.array(v) if isinstance(v, list) else v for key, v in stored.items()}


def _times(about: h5py.Group) -> dict[str, Done]:
    """What each stage took, by key; empty while a run is not complete."""
    if "stages" not in about:
        return {}
    of = about["stages"]
    names, keys = (texts(of[each]) for each in ("name", "key"))
    numbers = of["seconds"][()].tolist(), of["cached"][()].tolist()
    return {key: Done(*rest) for key, *rest in zip(keys, names, *numbers, strict=True)}


def _text(value: Any) -> str:
    """Text of a file, with "?" for what is no text in UTF-8."""
    value = value[()] if isinstance(value, h5py.Dataset) else value
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return text.encode("utf-8", "replace").decode("utf-8")
