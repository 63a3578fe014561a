"""The file that a run leaves behind: `results.h5`.

    /                    format, version, complete (false while the run goes on)
    /mesh/<part>         mesh.Part
    /rom/<part>          rom.Component, its matrices also as /rom/<part>/<nodal diameter>; with an
                         accuracy the casing's at the load's diameter, others in /rom/casing_nd<k>
    /system              nonlinear.System
    /limits/<name>       linear modes with the interlock free and stuck; "all" if cases share them
    /response/<case>     nonlinear.Response, with the swept keys, the summary and warnings as
                         attributes;
                         its system and preload, and mesh and rom where they are not those above;
                         gauge, (points, H+1, gauges): harmonics of the strain at each gauge;
                         with an accuracy error, by source: estimated relative errors of the peak's
                         amplitude and frequency, share, cost, knob; left_out: what, and why;
                         estimates: errors of the monitored amplitude by point and source
                         lower: the Response in the other direction, where both were swept; this
                         one then is that of the higher peak. jumps, (j, 4): where it jumps
                         answers: damping ratios, energy and fatigue margin at the peak
    /response/free, stuck
                         linear responses, ",<name>" added where cases do not share them; of the
                         first 8 alone where there are more
    /scatter             study.scatter.Scatter: percentiles of the peaks of samples, and what they
                         go with
    /failed/<case>       cases that could not be computed: reason, stage and swept keys
    /campbell/<case>     study.campbell.Campbell: lines, crossings and circles of its diagram
    /provenance          study text, date, versions, hashes and times of the stages

Each of these groups has a digest of all that it holds, and the place where it was written, see
`vanelock.common.files.digests`; a complete file has one of all of them.

Everything is written to a copy that takes the file's place from time to time, so that at any moment
the file is a whole one. Of a sweep it may lack the last cases, whose products are in the cache.
"""

import os
import shutil
import time
from collections.abc import Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vanelock.common.errors import FolderError, InputError
from vanelock.common.files.digests import seal, verify
from vanelock.common.files.files import writing
from vanelock.common.files.hdf5 import opened, written
from vanelock.common.process.signals import held
from vanelock.common.product import Product
from vanelock.nonlinear import OPEN, SLIP, SLIP_OPEN, STUCK, Response
from vanelock.quantities.jumps import rows
from vanelock.rom import Component, System
from vanelock.stages.accuracy.errors import Errors
from vanelock.stages.accuracy.left_out import LeftOut
from vanelock.stages.response.gauges import Strain
from vanelock.stages.response.summary import Sweep

FORMAT = "vanelock-results"
VERSION = 2
NAME = "results.h5"
SELDOM = 20.0
"""Additions appear when so many times what that took last has passed since."""
STATES = f"{STUCK} stuck, {SLIP} slips, {OPEN} open, {SLIP_OPEN} slips and opens"
"""What the numbers in a response's `state` stand for."""


def check_results(path: Path) -> None:
    """Refuse to go on where `path` is something that this program did not write.

    Raises
    ------
    InputError
        If the file is there and is not readable, or is not a results file of this version.
    """
    if not os.path.lexists(path):
        return
    with open_results(path, whole=False):
        pass


@contextmanager
def open_results(
    path: str | os.PathLike[str], whole: bool = True
) -> Generator[h5py.File, None, None]:
    """A results file, open for reading.

    Parameters
    ----------
    path : path
    whole : bool
        Whether to read all of it first, and refuse it where anything is not as it was written.

    Raises
    ------
    InputError
        If it is missing, damaged, altered, foreign, or of another version of the format.
    """
    advice = "move it away or name another folder with --output"
    with ExitStack() as stack:
        try:
            file = stack.enter_context(opened(path))
        except InputError as error:
            told = f"{error}; {advice}" if "HDF5" in str(error) else str(error)
            raise InputError(told) from None
        found = file.attrs.get("format")
        if not isinstance(found, str) or found != FORMAT:
            raise InputError(f"{path}: not a vanelock results file; {advice}")
        version = file.attrs.get("version")
        if not isinstance(version, np.integer) or version != VERSION:
            raise InputError(
                f"{path}: results of format version {str(version)[:40]}, this program writes "
                f"{VERSION}; {advice}"
            )
        if whole:
            verify(file, bool(file.attrs.get("complete", True)))
        yield file


class Results:
    """The results file of a run in progress.

    Additions go to a copy beside it. The copy is copied over the file when that is due: at the
    first addition, at the end, and between them so seldom that it takes little of the time, since a
    sweep's file is large and each of its cases a small part.

    Parameters
    ----------
    path : Path
        Where it is; what was there is replaced when the first part is written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._own = path.with_name(f".{path.name}.{os.getpid()}.tmp")
        self._begun = self._behind = self._waits = False
        self._flushed = self._took = 0.0
        self._file: h5py.File | None = None

    def wait_for_the_end(self, settings: str) -> None:
        """Keep a complete file of the same settings until this one is complete, too."""
        with suppress(InputError), open_results(self.path, whole=False) as file:
            known = file.get("provenance")
            earlier = None if known is None else known.attrs.get("settings")
            self._waits = bool(file.attrs.get("complete")) and earlier == settings

    @contextmanager
    def together(self) -> Generator[None, None, None]:
        """Let all edits of this block appear at once."""
        with self._opened() as file:
            self._file = file
            try:
                yield
            finally:
                self._file = None

    @contextmanager
    def edit(self, *places: str) -> Generator[h5py.File, None, None]:
        """The file, open for additions that appear all at once or not at all, if not at once.

        Parameters
        ----------
        places : str
            Groups that are written here, as a whole: they get their digests.
        """
        with held(), self._opened() if self._file is None else nullcontext(self._file) as file:
            yield file
            for place in places:
                seal(file[place])

    @contextmanager
    def _opened(self) -> Generator[h5py.File, None, None]:
        with writing(self.path):
            try:
                if (self._behind or (self._begun and self._waits)) and not self._own.exists():
                    raise FolderError(f"{self._own}: was removed while the run was writing it")
                if self._begun and not self._own.exists():
                    shutil.copyfile(self.path, self._own)
                with written(self._own, "a" if self._begun else "w") as file:
                    if not self._begun:
                        file.attrs["format"] = FORMAT
                        file.attrs["version"] = VERSION
                        file.attrs["complete"] = False
                    yield file
            except BaseException:
                self.abandon()
                raise
        self._begun = self._behind = True
        self.flush_if_due()

    def flush_if_due(self) -> None:
        """Let additions appear, if showing them last took little of the time since then."""
        if self._waits:
            return
        if self._behind and time.perf_counter() - self._flushed >= SELDOM * self._took:
            self.flush()

    def flush(self) -> None:
        """Let all additions appear."""
        if not self._behind or self._waits or self._file is not None:
            return
        began = time.perf_counter()
        shown = self._own.with_name(f"{self._own.name.removesuffix('.tmp')}.shown.tmp")
        with writing(self.path):
            try:
                shutil.copyfile(self._own, shown)
                os.replace(shown, self.path)
            finally:
                shown.unlink(missing_ok=True)
        self._behind = False
        self._flushed = time.perf_counter()
        self._took = self._flushed - began

    def end(self) -> None:
        """Let all additions appear; there are no more for now."""
        self._waits = False
        if self._behind and not self._own.exists():
            raise FolderError(f"{self._own}: was removed while the run was writing it")
        if self._own.exists():
            with writing(self.path):
                os.replace(self._own, self.path)
        self._behind = False

    def abandon(self) -> None:
        """Drop what has not appeared."""
        self._own.unlink(missing_ok=True)
        self._behind = False


def put(file: h5py.File, where: str, product: Product, attributes: Mapping[str, Any]) -> None:
    """Write a product at a path of the file, with attributes beside its own."""
    group = file.require_group(where)
    product.save(group)
    if isinstance(product, Response):
        group["state"].attrs["codes"] = STATES
        for harmonic in group["x"].values():
            harmonic.attrs["unit"] = "m; modal coordinates kg^0.5 m"
    for name, value in attributes.items():
        group.attrs[name] = value


def put_strain(file: h5py.File, where: str, strain: Strain) -> None:
    """Write what strain gauges read in a response beside it, as `gauge`."""
    dataset = file[where].create_dataset("gauge", data=strain.harmonics)
    dataset.attrs["unit"] = "1"
    dataset.attrs["name"] = list(strain.gauges.names)
    dataset.attrs["position"] = strain.gauges.positions
    dataset.attrs["direction"] = strain.gauges.directions


def put_jumps(file: h5py.File, where: str, sweeps: Sequence[Sweep]) -> None:
    """Write where a response jumps, and the lower one, beside each as `jumps`."""
    for sweep, place in zip(sweeps, (where, f"{where}/lower"), strict=False):
        dataset = file[place].create_dataset("jumps", data=rows(sweep))
        dataset.attrs["columns"] = [
            "frequency before (Hz)",
            "frequency after (Hz)",
            "amplitude before (m)",
            "amplitude after (m)",
        ]


def put_errors(file: h5py.File, where: str, found: Errors, without: Sequence[LeftOut]) -> None:
    """Write what a response to an accuracy is worth beside it, as `error`, and what it left out."""
    group = file[where].create_group("error")
    group.attrs["accuracy"] = found.accuracy
    group.attrs["warnings"] = list(found.warnings)
    for name in ("amplitude", "frequency", "share", "cost"):
        values = [getattr(each, name) for each in found.sources]
        group.create_dataset(name, data=values).attrs["unit"] = "1"
    text = h5py.string_dtype()
    group.create_dataset("source", data=[each.name for each in found.sources], dtype=text)
    group.create_dataset("knob", data=[each.knob for each in found.sources], dtype=text)
    rows = [[each.kind, each.what, each.evidence] for each in without]
    group.create_dataset("left_out", data=rows, dtype=text)


def put_answers(file: h5py.File, where: str, numbers: Mapping[str, tuple[Any, str]]) -> None:
    """Write what a case answers at its peak beside it, as `answers`: values and their units."""
    group = file[where].require_group("answers")
    for name, (value, unit) in numbers.items():
        group.attrs[name] = value
        if unit:
            group.attrs[f"{name} unit"] = unit


def put_component(file: h5py.File, where: str, component: Component) -> None:
    """Write a reduced part; its matrices can be reached as `<where>/<nodal diameter>` too."""
    put(file, where, component, {})
    group = file[where]
    for k in component.diameters:
        group[str(k)] = group[f"diameters/{k}"]


def put_system(file: h5py.File, where: str, system: System, matrices: str | None = None) -> None:
    """Write a system; one with the matrices of the system at `matrices` shares them."""
    if matrices is None:
        put(file, where, system, {})
        return
    put(file, where, replace(system, diameters={}), {})
    file[where]["nd"] = file[f"{matrices}/nd"]


def load_system(path: str | os.PathLike[str], case: str) -> System:
    """The system of a case of a results file.

    Raises
    ------
    InputError
        If the file cannot be used or has no such case.
    """
    with open_results(path) as file:
        group = file.get(f"response/{case}")
        if group is None:
            have = ", ".join(file.get("response", {}))
            raise InputError(f"{path}: no case {case!r} (it has {have})")
        return System.load(group["system"])
