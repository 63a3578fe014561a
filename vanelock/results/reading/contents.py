"""What a run's folder holds, read back."""

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from vanelock.common.cyclic import COMPONENTS
from vanelock.common.errors import InputError, printable
from vanelock.results.files.results_file import NAME, open_results
from vanelock.stages.response.responses import Limit

Floats = NDArray[np.float64]
CARTESIAN = ("x", "y", "z")


@dataclass(frozen=True)
class CaseFound:
    """A case of a run.

    Attributes
    ----------
    name : str
    values : dict of str to number or str
        The swept keys.
    numbers : dict of str to number
        Its summary and answers, SI.
    frequency, amplitude : (p,) float
        The monitored curve, Hz and m; NaN where a point did not converge.
    wave : str
        What becomes of the ring's wave at the peak, "" where that was not asked for.
    engine_order : int
        Of its excitation; 0 where there is no ring.
    """

    name: str
    values: dict[str, Any]
    numbers: dict[str, float]
    frequency: Floats
    amplitude: Floats
    wave: str = ""
    engine_order: int = 0

    @property
    def at_edge(self) -> bool:
        """Whether its largest point is the first or the last of several."""
        peak, ends = self.numbers.get("peak_frequency"), self.frequency[[0, -1]]
        return len(self.frequency) > 1 and peak in ends


@dataclass(frozen=True)
class Loaded:
    """A run's results.

    Attributes
    ----------
    folder : Path
    label : str
        What tables call it.
    complete : bool
        False where the run was stopped or is under way.
    date : str
    settings : dict
        The study with all defaults.
    versions : dict of str to str
    monitor : str
        The displacement in the curves, "" where there is no case.
    sizes : dict of str to int
        Nodes, elements, coordinates and contacts.
    seconds : dict of str to float
        By stage.
    cases : dict of str to CaseFound
        Finished cases.
    linear : dict of (name, "free" | "stuck") to (frequency, amplitude)
        Linear limits of the monitored displacement, Hz and m, those that the file has; without
        "stuck" where no contacts open in the free limit.
    failed : dict of str to str
        Cases that could not be computed, and why.
    """

    folder: Path
    label: str
    complete: bool
    date: str
    settings: dict[str, Any]
    versions: dict[str, str]
    monitor: str
    sizes: dict[str, int]
    seconds: dict[str, float] = field(default_factory=dict)
    cases: dict[str, CaseFound] = field(default_factory=dict)
    linear: dict[tuple[str, Limit], tuple[Floats, Floats]] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)


def load_run(folder: Path, label: str) -> Loaded:
    """Read a run's folder."""
    if not os.path.isdir(folder):
        raise InputError(f"{folder}: no such folder")
    path = folder / NAME
    if not path.exists():
        raise InputError(
            f"{folder}: holds no {NAME}: not the folder of a run, or of one just begun"
        )
    with open_results(path) as file:
        return load_file(folder, label, file)


def load_file(folder: Path, label: str, file: h5py.File) -> Loaded:
    """Read an open results file."""
    try:
        return _loaded(folder, label, file)
    except KeyError as error:
        reason = _line(str(error).strip("\"'"))
        raise InputError(
            f"{file.filename}: lacks what a run writes ({reason}); run it again"
        ) from None
    except (
        AttributeError, IndexError, MemoryError, OSError, OverflowError, RecursionError,
        RuntimeError, TypeError, ValueError,
    ) as error:  # fmt: skip
        reason = _line(str(error) or type(error).__name__)
        raise InputError(
            f"{file.filename}: holds something else than a run writes ({reason}); run it again"
        ) from None


def _line(text: str) -> str:
    """The first line of a library's message, which may quote the file."""
    first = (text.splitlines() or [""])[0]
    return printable(first)[:160]


def _loaded(folder: Path, label: str, file: h5py.File) -> Loaded:
    """What a results file holds; KeyError where something is missing."""
    about = file["provenance"]
    responses = file.get("response", {})
    cases = {
        name: _case(_text(name), group)
        for name, group in responses.items()
        if "linear" not in group.attrs
    }
    first = next((responses[name] for name in cases), None)
    return Loaded(
        folder=folder,
        label=label,
        complete=bool(file.attrs.get("complete", False)),
        date=_text(about.attrs["date"]),
        settings=json.loads(about.attrs["settings"]),
        versions={_text(k): _text(value) for k, value in about["versions"].attrs.items()},
        monitor="" if first is None else _text(first.attrs["monitor"]),
        sizes=_sizes(file),
        seconds=_seconds(about),
        cases=_in_order(cases, json.loads(about.attrs["settings"])),
        linear={} if first is None else dict(_linear(file, place_of(first))),
        failed={
            _text(name): _text(group.attrs.get("reason", "not given"))
            for name, group in file.get("failed", {}).items()
        },
    )


def _case(name: str, group: h5py.Group) -> CaseFound:
    values = {
        key.removeprefix("sweep "): _plain(value)
        for key, value in group.attrs.items()
        if key.startswith("sweep ")
    }
    numbers = {
        key: float(value)
        for key, value in group.attrs.items()
        if not key.startswith("sweep ") and isinstance(value, int | float | np.number)
    }
    if "answers" in group:
        kept = group["answers"].attrs
        numbers |= {k: float(v) for k, v in kept.items() if isinstance(v, int | float | np.number)}
    frequency, solved = group["frequency"][()], group["converged"][()]
    if "peak_frequency" in numbers:
        point = int(np.flatnonzero(frequency == numbers["peak_frequency"])[0])
        numbers["work"] = float(group["dissipation"][point].sum())
    order = np.argsort(frequency, kind="stable")
    known = np.where(solved, _at(group, place_of(group)), np.nan)
    ring = group["system"].attrs
    return CaseFound(
        name,
        values,
        numbers,
        frequency[order],
        known[order],
        _text(group.attrs.get("wave", "")),
        int(ring["engine_order"]) if ring["sectors"] > 1 else 0,
    )


def _plain(value: Any) -> Any:
    value = value.item() if isinstance(value, np.generic) else value
    return value if isinstance(value, int | float) else _text(value)


def _text(value: Any) -> str:
    """Text of a file, with "?" for what is no text in UTF-8."""
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return text[:1000].encode("utf-8", "replace").decode("utf-8")


def components(case: h5py.Group) -> tuple[str, ...]:
    """Directions of a case's outputs: about the engine's axis, or x, y, z of a scene without."""
    monitored = str(case.attrs["monitor"]).rpartition(", ")[2]
    return COMPONENTS if monitored in COMPONENTS else CARTESIAN


def place_of(case: h5py.Group) -> tuple[int, int]:
    """Output node and direction of the displacement that a case monitors."""
    node, _, component = str(case.attrs["monitor"]).rpartition(", ")
    names: list[str] = case["system/output/name"].asstr()[()].tolist()
    return names.index(node), components(case).index(component)


def _at(response: h5py.Group, place: tuple[int, int]) -> Floats:
    """(p,) amplitude of an output, m."""
    found: Floats = response["amplitude"][:, *place]
    return found


def _linear(
    file: h5py.File, place: tuple[int, int]
) -> Iterator[tuple[tuple[str, Limit], tuple[Floats, Floats]]]:
    """Linear limits at an output, by name and kind."""
    opens = {name: bool(group["opens"][()]) for name, group in file.get("limits", {}).items()}
    for name, group in file["response"].items():
        which, of = group.attrs.get("linear"), _text(name).partition(",")[2]
        if which == "free" or (which == "stuck" and opens.get(of or "all", True)):
            yield (of, which), (group["frequency"][()], _at(group, place))


def _sizes(file: h5py.File) -> dict[str, int]:
    found: dict[str, int] = {}
    for part in ("vane", "casing"):
        if (mesh := file.get(f"mesh/{part}")) is not None:
            found[f"{part}: nodes"] = len(mesh["points"])
            found[f"{part}: elements"] = len(mesh["cells"])
    if (system := file.get("system")) is not None:
        sizes = [len(group["K"]) for group in system["nd"].values()]
        found["reduced model: coordinates"] = max(sizes, default=0)
        found["contacts"] = len(system["contact/kn"])
    return found


def _seconds(about: h5py.Group) -> dict[str, float]:
    """What computing took, by kind of stage; empty while a run is not complete."""
    found: dict[str, float] = {}
    for name, group in about.get("stages", {}).items():
        _add(found, name, group)
    return found


def _add(found: dict[str, float], name: str, group: h5py.Group) -> None:
    if "seconds" not in group.attrs:  # a "/" in a stage's name makes a group of its own
        for inner, below in group.items() if name.count("/") < 4 else ():
            _add(found, f"{name}/{inner}", below)
        return
    kind = name.rpartition(" ")[0].partition(",")[0]
    for many in ("response ", "preload", "stress ", "check "):
        if kind.startswith(many):
            kind = f"{many.strip()}s" if many != "stress " else "stresses"
    found[kind] = found.get(kind, 0.0) + float(group.attrs["seconds"])


def _in_order(cases: Mapping[str, CaseFound], settings: Mapping[str, Any]) -> dict[str, CaseFound]:
    """Cases in the order of the sweep; the file holds them by name."""
    sweep = settings.get("sweep") or {}

    def place(case: CaseFound) -> list[int]:
        return [
            values.index(case.values[key]) if case.values.get(key) in values else len(values)
            for key, values in sweep.items()
        ]

    return {case.name: case for case in sorted(cases.values(), key=place)}
