"""The example scenes run with one value of what they sweep, and their raw matrices."""

import importlib.util
from pathlib import Path
from types import ModuleType

import h5py
import numpy as np
from numpy.typing import NDArray

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def frequencies(file: h5py.File, which: str) -> Floats:
    """The only limits of a run, "free" or "stuck", Hz."""
    (limits,) = file["limits"].values()
    found: Floats = limits[which][()]
    return found


def generator(name: str, folder: Path) -> ModuleType:
    """The example's make.py, which writes to a folder of its own here."""
    path = EXAMPLES / name / "make.py"
    spec = importlib.util.spec_from_file_location(f"make_{name}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    vars(module)["HERE"] = folder
    return module


def lists_of(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in sorted(folder.glob("*.csv"))}


def numbers(path: Path) -> Integers:
    """A list of nodes under a heading."""
    return np.array(path.read_text().split()[1:], np.int64)
