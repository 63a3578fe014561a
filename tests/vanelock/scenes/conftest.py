"""Small components as files: nodes on springs; the example scenes and what they hold."""

import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TypeAlias

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock import load_scene
from vanelock.common.errors import InputError
from vanelock.fem import Model
from vanelock.input.cases.values import diameters_of
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages
from vanelock.rom import System
from vanelock.stages.matrices.scene_structure import SceneStructure

Matrix = NDArray[np.float64]
Write: TypeAlias = Callable[[str], Path]


@pytest.fixture(scope="module", autouse=True)
def no_pictures(undrawn: None) -> None:
    """Tests of scenes look at golden runs' pictures alone."""


@dataclass(frozen=True)
class Chain:
    """Nodes in a row, 3 dofs each, neighbours joined by springs; the first may hang on ground."""

    K: Matrix
    M: Matrix
    nodes: NDArray[np.int64]

    def write(self, folder: Path, name: str, stiffness: float = 1.0, mass: float = 1.0) -> str:
        """Its table of a scene file, and files in the folder, in other units."""
        scipy.io.mmwrite(folder / f"{name}_K.mtx", sp.coo_array(self.K * stiffness))
        scipy.io.mmwrite(folder / f"{name}_M.mtx", sp.coo_array(self.M * mass))
        rows = [f"{n},{d}" for n in self.nodes for d in "xyz"]
        (folder / f"{name}_dofs.csv").write_text("\n".join(["node,direction", *rows]) + "\n")
        return (
            f'[components.{name}]\nstiffness = "{name}_K.mtx"\nmass = "{name}_M.mtx"\n'
            f'dofs = "{name}_dofs.csv"\n'
        )


def chain(
    first: int, count: int, stiffness: Sequence[float], ground: float = 0.0, mass: float = 0.1
) -> Chain:
    """Nodes `first`, `first` + 1, ... with springs of x, y and z stiffness between them."""
    K, M = np.zeros((3 * count, 3 * count)), mass * np.eye(3 * count)
    each = np.diag(stiffness)
    for i in range(count - 1):
        at = np.ix_(range(3 * i, 3 * i + 6), range(3 * i, 3 * i + 6))
        K[at] += np.block([[each, -each], [-each, each]])
    K[:3, :3] += ground * each
    return Chain(K, M, np.arange(first, first + count))


def planar(folder: Path, ground: float = 1.0) -> str:
    one = chain(1, 3, (3e5, 2e5, 1e5), ground=ground)
    kept = [i for i in range(9) if i % 3 != 1]
    flat = Chain(one.K[np.ix_(kept, kept)], one.M[np.ix_(kept, kept)], one.nodes)
    text = flat.write(folder, "one")
    rows = [f"{n},{d}" for n in one.nodes for d in "xz"]
    (folder / "one_dofs.csv").write_text("\n".join(["node,direction", *rows]) + "\n")
    return text


def load(component: str, node: int, direction: str, amplitude: float = 1, more: str = "") -> str:
    return (
        f'[[loads]]\ncomponent = "{component}"\nnodes = [{node}]\ndirection = {direction}\n'
        f"amplitude = {amplitude}\n{more}"
    )


def write_model(folder: Path, model: Model, name: str) -> str:
    """A component of a scene file: matrices and places of nodes, numbered from 1."""
    for matrix, A in (("K", model.K), ("M", model.M)):
        sp.save_npz(folder / f"{matrix}.npz", sp.csc_array(A))
    lines = [f"{i},{x},{y},{z}" for i, (x, y, z) in enumerate(model.part.points, 1)]
    (folder / "nodes.csv").write_text("\n".join(["node,x,y,z", *lines]) + "\n")
    return f'[components.{name}]\nstiffness = "K.npz"\nmass = "M.npz"\nnodes = "nodes.csv"\n'


def refused_by(act: Callable[[Path], object], path: Path, message: str) -> None:
    with pytest.raises(InputError, match=message):
        act(path)


def joined(path: Path) -> System:
    stages = Stages(Cache(path.parent / "cache", print), lambda event: None)
    scene = load_scene(path)
    return stages.get(SceneStructure(scene).system(diameters_of(scene)))


@pytest.fixture
def scene_file(tmp_path: Path) -> Write:

    def write(text: str) -> Path:
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return path

    return write


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
