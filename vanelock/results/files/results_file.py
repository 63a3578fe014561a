"""The file that a run leaves behind: `results.h5`.

    /                    format, version, complete (false while the run goes on)
    /mesh/<part>         mesh.Part
    /rom/<part>          matrices of a rom.Component, also as /rom/<part>/<nodal diameter>; of the
                         casing at the load's diameter, others in /rom/casing_nd<k>
    /component/<name>    of a scene, in place of these: matrices.Piece; others than at the load's
                         diameter in /component/<name>_nd<k>
    /system              nonlinear.System
    /limits/<name>       linear modes with contacts free and stuck; "all" if cases share them;
                         free_curve, stuck_curve, (2, p): frequency and monitored amplitude
    /response/<case>     nonlinear.Response, with the swept keys, the summary and warnings as
                         attributes;
                         its system and preload, and mesh, rom or component where not those above;
                         gauge, (points, H+1, gauges): harmonics of the strain at each gauge;
                         with an accuracy estimates: errors of the monitored amplitude by point
                         and source
                         lower: the Response in the other direction, where both were swept; this
                         one then is that of the higher peak. jumps, (j, 4): where it jumps
                         <analysis>: what each analysis that is asked for found, see analyses/
                         about: JSON of its keys that are set, its numbers, errors, and where its
                         products are and their keys; curves: what is drawn of its responses
                         of cases that are looked into answers: damping ratios, energy and fatigue
                         margin at the peak; fields: stress cycles and displacement of all nodes;
                         audit: its peak marched; sensitivities: what moves it
    /response/free, stuck
                         linear responses, ",<name>" added where cases do not share them; of the
                         first 8 alone where there are more
    /scatter             analyses.scatter.Scattered: percentiles of the peaks of samples, and what
                         they go with
    /failed/<case>       cases that could not be computed: reason, stage and swept keys
    /provenance          study text, its keys, date, versions, names, hashes and times of the stages

Groups lie in files of their own in the folder `results` beside it, one for each case, written once,
to which this file, the index, has links; these have links to files of single products, which cases
may share. What the cache keeps, too, is one file on the disk with a name there and one here.

Each file in the folder has the digest of its bytes in its name, the index in its first block, see
`vanelock.common.files.digests`.

Plain data and dataclasses of them as JSON, and back; NaN stays so.
"""

import json
import os
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np
from pydantic import TypeAdapter

from vanelock.common.errors import InputError
from vanelock.common.files.digests import needs, verify_file
from vanelock.common.files.files import beside
from vanelock.common.files.hdf5 import opened
from vanelock.rom import Component, System

FORMAT = "vanelock-results"
VERSION = 4
NAME = "results.h5"
ADVICE = "move it away or name another folder with --output"
PARTS = "results"
"""The folder beside it."""
WHOLE = "whole"
"""Attribute of a reduced part's matrices: the file in the run's folder that has all of it."""


def check_results(path: Path) -> str:
    """Refuse to go on where `path` is something that this program did not write."""
    if not os.path.lexists(path):
        return ""
    try:
        with open_results(path, complete=False):
            return ""
    except InputError as error:
        with open_results(path, complete=False, follow=False):  # refuses what is not this program's
            pass
        _, _, found = str(error).removesuffix(f"; {ADVICE}").partition("HDF5 file ")
        return f"results are damaged {found}: written again, from what the cache has"


@contextmanager
def open_results(
    path: str | os.PathLike[str], complete: bool = True, follow: bool = True
) -> Generator[h5py.File, None, None]:
    """A results file, open for reading.

    Parameters
    ----------
    path : path
    complete : bool
        Whether to read all of it first, and refuse it where anything is not as it was written.
    follow : bool
        Whether the files that it leads to count.

    Raises
    ------
    InputError
        If it is missing, damaged, altered, foreign, or of another version of the format.
    """
    with ExitStack() as stack:
        try:
            file = stack.enter_context(opened(path, PARTS, follow))
        except InputError as error:
            text = f"{error}; {ADVICE}" if "HDF5" in str(error) else str(error)
            raise InputError(text) from None
        found = file.attrs.get("format")
        if not isinstance(found, str) or found != FORMAT:
            raise InputError(f"{path}: not a vanelock results file; {ADVICE}")
        version = file.attrs.get("version")
        if not isinstance(version, np.integer) or version != VERSION:
            raise InputError(
                f"{path}: results of format version {str(version)[:40]}, this program writes "
                f"{VERSION}; {ADVICE}"
            )
        if complete:
            _verify_all(Path(path), file)
        yield file


def _verify_all(path: Path, file: h5py.File) -> None:
    """Refuse an open results file if it, or a file that it needs, is not what was written."""
    verify_file(path)
    known: set[Path] = set()
    for name in sorted(_linked(file)):
        part = path.parent / name
        verify_file(part)
        with h5py.File(part, "r") as found:
            known.update(part.with_name(each) for each in needs(found) or ())
    for each in sorted(known):
        verify_file(each)


def _linked(group: h5py.Group) -> set[str]:
    """Files to which a group and those in it link."""
    found: set[str] = set()
    for name in group:
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink):
            found.add(link.filename)
        elif isinstance(link, h5py.HardLink) and isinstance(group[name], h5py.Group):
            found |= _linked(group[name])
    return found


MOST_NAMED = 20
"""Cases that a message names."""


def response_group(file: h5py.File, case: str) -> h5py.Group:
    """What an open results file has of a case, or of a linear limit such as "free"."""
    names = list(file.get("response", {}))
    if case in names:
        return file["response"][case]
    failed = file.get("failed", {})
    if case in list(failed):
        raise InputError(
            f"{file.filename}: case {case!r} could not be computed: {failed[case].attrs['reason']}"
        )
    some = ", ".join(names[:MOST_NAMED]) or "none yet"
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    raise InputError(f"{file.filename}: no case {case!r} (it has {some}{more})")


def load_system(path: str | os.PathLike[str], case: str) -> System:
    """The system of a case of a results file.

    Raises
    ------
    InputError
        If the file cannot be used or has no such case.
    """
    with open_results(path) as file:
        group = response_group(file, case)
        if "system" not in group:
            raise InputError(f"{path}: {case!r} is a linear limit: name a case, which has a system")
        return System.load(group["system"])


def load_component(path: str | os.PathLike[str], part: str) -> Component:
    """A reduced part of a run, with what fields and errors are computed from, which its cache has.

    Parameters
    ----------
    path : path
        The results file, in the run's folder.
    part : str
        As below `/rom`: "vane", "casing".

    Raises
    ------
    InputError
        If the file cannot be used or has no such part, or the cache not the whole of it any more.
    """
    with open_results(path) as file:
        group = file.get(f"rom/{part}")
        if not isinstance(group, h5py.Group):
            raise InputError(f"{path}: no part {part!r} (it has {', '.join(file.get('rom', {}))})")
        if WHOLE not in group.attrs:
            return Component.load(group)
        whole = beside(Path(path).parent, str(group.attrs[WHOLE]), f"{path}: /rom/{part}")
    verify_file(whole)
    with opened(whole) as file:
        return Component.load(file["product"])


T = TypeVar("T")


def as_json(value: Any) -> str:
    """A value as JSON text."""
    return json.dumps(value, default=_plain)


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return {each.name: getattr(value, each.name) for each in fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return dict(value)


def from_json(kind: type[T], value: Any) -> T:
    """A value of a kind from what JSON holds of it."""
    return TypeAdapter(kind).validate_python(value)
