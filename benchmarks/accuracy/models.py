"""Reduced models of the scenes, each made once and kept in a folder, with what making them took."""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from benchmarks.accuracy.scenes import Scene
from vanelock import fem, nonlinear, rom
from vanelock.common.product import Product
from vanelock.mesh import Part
from vanelock.stages.parts.components import MASTERS, PARTS, averaged, mesh_step, model_step
from vanelock.stages.parts.segment import segment_of
from vanelock.stages.response.limits import Limits, dense, frequencies, limits
from vanelock.stages.response.responses import Monitor, monitor

P = TypeVar("P", bound=Product)


def kept(folder: Path, name: str, kind: type[P], make: Callable[[], P]) -> tuple[P, float]:
    """A product out of a folder, or made and put there; and the CPU seconds that it took."""
    path, told = folder / f"{name}.h5", folder / f"{name}.json"
    if path.exists() and told.exists():
        return kind.load(path), float(json.loads(told.read_text())["seconds"])
    begin = time.process_time()
    product = make()
    seconds = time.process_time() - begin
    folder.mkdir(parents=True, exist_ok=True)
    product.save(path)
    told.write_text(json.dumps({"seconds": seconds}))
    return product, seconds


@dataclass(frozen=True)
class Reduction:
    """Both parts reduced to an accuracy at all nodal diameters.

    Attributes
    ----------
    vane, casing : Component
    seconds : (float, float)
        CPU time of each; the casing's falls to every nodal diameter in equal shares.
    """

    vane: rom.Component
    casing: rom.Component
    seconds: tuple[float, float]

    def cost(self, diameters: int) -> float:
        """CPU seconds, had the casing been reduced at so many nodal diameters only."""
        return self.seconds[0] + self.seconds[1] * diameters / len(self.casing.diameters)


@dataclass(frozen=True)
class Models:
    """Meshes and models of one scene's design.

    Attributes
    ----------
    scene : Scene
    folder : Path
        Where they are kept.
    """

    scene: Scene
    folder: Path

    def part(self, name: str) -> Part:
        """The mesh of a part."""
        study, own = self.scene.study(), self.folder / f"design_{self.scene.design}"
        return kept(own, f"mesh_{name}", Part, mesh_step(study, name).compute)[0]

    @cached_property
    def models(self) -> dict[str, fem.Model]:
        """Stiffness and mass of both parts."""
        study = self.scene.study()
        return {name: model_step(study, name).compute(self.part(name)) for name in PARTS}

    @property
    def dofs(self) -> int:
        """Of both meshes."""
        return sum(3 * len(self.part(name).points) for name in PARTS)

    def reduced(self, accuracy: float) -> Reduction:
        """Both parts, with all masters, whether this scene needs them or not."""
        study = self.scene.study(joints={"interlock": {}})
        N = study.ring.sectors
        on_patches = {name: averaged(self.scene.study(), name) for name in PARTS}
        own = self.folder / f"design_{self.scene.design}"
        vane, of_vane = kept(
            own,
            f"vane_{accuracy:.0e}",
            rom.Component,
            lambda: rom.reduce(
                self.models["vane"],
                MASTERS["vane"],
                accuracy=accuracy,
                averaged=on_patches["vane"],
            ),
        )
        casing, of_casing = kept(
            own,
            f"casing_{accuracy:.0e}",
            rom.Component,
            lambda: rom.reduce(
                self.models["casing"],
                MASTERS["casing"],
                accuracy=accuracy,
                band=vane.band,
                nodal_diameters=range(N // 2 + 1),
                averaged=on_patches["casing"],
            ),
        )
        return Reduction(vane, casing, (of_vane, of_casing))


@dataclass(frozen=True)
class Prepared:
    """A scene's system, the range of frequencies and the output that a study would take.

    Attributes
    ----------
    system : System
    range : (float, float)
        Hz.
    monitor : Monitor
    limits : Limits
    """

    system: rom.System
    range: tuple[float, float]
    monitor: Monitor
    limits: Limits


def prepared(scene: Scene, reduction: Reduction) -> Prepared:
    """The system of a scene from reduced parts, ready to be solved."""
    study = scene.study()
    system = segment_of(study).join(reduction.vane, reduction.casing)
    return framed(scene, system)


def framed(scene: Scene, system: rom.System) -> Prepared:
    """A system with its range and its monitored output, both by the study's defaults."""
    study = scene.study()
    still = replace(system.contacts, mu=0 * system.contacts.mu, v0=0 * system.contacts.v0)
    base = replace(system, contacts=still)
    found = limits(base, study.response.mode)
    wanted = frequencies(study, found)
    assert isinstance(wanted, tuple)
    closed = ~system.contacts.opens
    grid = dense(wanted, found, False, study.damping.ratio)
    free = nonlinear.linear_response(base, grid, closed)
    return Prepared(system, wanted, monitor(None, system, free), found)
