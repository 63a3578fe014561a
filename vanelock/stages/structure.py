"""The components of a case and the system that they make at each nodal diameter, each a step.

A study's two parts (`vanelock.stages.parts.segment`) and a scene's components
(`vanelock.stages.matrices.scene_structure`) are reduced and joined at one nodal diameter after the
other, as these are needed; from the system on a case is a case.

The linear limits of a case, contacts free and stuck, and the steps to them.
"""

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Self

from vanelock import nonlinear, rom
from vanelock.common.cyclic import folded
from vanelock.input.cases.values import Problem, diameter_of, diameters_of
from vanelock.mesh import Part
from vanelock.nonlinear import HarmonicModes, Response
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import System
from vanelock.stages.response.limits import LIMITS, Limit, Limits
from vanelock.stages.response.responses import limits_step, linear_step


class CaseStructure(ABC):
    """The components of a case and their system."""

    problem: Problem
    names: tuple[str, ...] = ()
    """Of its components."""
    apart: tuple[str, ...] = ()
    """A line for each component that nothing joins to another."""

    @abstractmethod
    def component(self, name: str, nodal_diameter: int) -> Step[Any]:
        """A component reduced at a nodal diameter; N - k is k, conjugated."""

    @abstractmethod
    def at(self, nodal_diameter: int) -> Step[System]:
        """The system at a nodal diameter, 0 to N/2."""

    def stuck_modes(
        self, diameters: Collection[int], below: Step[HarmonicModes] | None = None
    ) -> Step[HarmonicModes]:
        """Modes with all contacts stuck at some nodal diameters, of which some are `below`."""
        return _stuck_modes(self.unloaded.system(diameters), self.modes_up_to, below)

    def folded(self, nodal_diameter: int) -> int:
        """A nodal diameter between 0 and N/2."""
        return folded(nodal_diameter, self.problem.ring.sectors)

    @property
    @abstractmethod
    def bare(self) -> Self:
        """The same without friction, interference and loads at rest: that of the linear limits."""

    @property
    def unloaded(self) -> Self:
        """The same with a load that cases share: stuck modes do not depend on their own."""
        return self.bare

    @property
    def loaded(self) -> tuple[int, ...]:
        """Nodal diameters, 0 to N/2, of rest, of all loads and of the harmonics between."""
        return diameters_of(self.problem, 1)

    @property
    def modes_up_to(self) -> int:
        """Highest harmonic of which stuck modes are made; N: of all that a system holds."""
        return self.problem.ring.sectors

    @property
    def meshes(self) -> Mapping[str, Step[Part]]:
        """Meshes of its components, of those that have one."""
        return {}

    @property
    def uncorrected(self) -> Step[System] | None:
        """The bare system at the load's diameter as its meshes are; None where that is `bare`."""
        return None

    @property
    def every_diameter(self) -> tuple[int, ...]:
        """All nodal diameters, 0 to N/2."""
        return tuple(range(self.problem.ring.sectors // 2 + 1))

    @property
    def whole(self) -> Step[System]:
        """The system at all nodal diameters."""
        return self.system(self.every_diameter)

    def reduced(self, diameters: Iterable[int]) -> tuple[Step[Any], ...]:
        """Its components at some nodal diameters, each step once."""
        chosen = sorted({*map(self.folded, diameters)})
        found = [self.component(name, k) for name in self.names for k in chosen]
        return tuple(dict.fromkeys(found))

    def system(self, diameters: Collection[int]) -> Step[System]:
        """The system at some nodal diameters; joining takes no time: it is not kept."""
        return _united(tuple(self.at(k) for k in sorted({*map(self.folded, diameters)})))


@lru_cache(maxsize=SHARED)
def _united(systems: tuple[Step[System], ...]) -> Step[System]:
    if len(systems) == 1:
        return systems[0]

    def compute(*system: System) -> System:
        return rom.united(system)

    return step("system", "rom", {}, System, systems, compute, False, True)


@lru_cache(maxsize=SHARED)
def _stuck_modes(
    system: Step[System], harmonics: int, below: Step[HarmonicModes] | None
) -> Step[HarmonicModes]:
    """They are large, and reading them takes about as long as making them: they are not kept."""
    needs = (system, *(() if below is None else (below,)))

    def compute(system: System, *below: HarmonicModes) -> HarmonicModes:
        known = below[0].diameters if below else None
        return nonlinear.harmonic_modes(system, harmonics, known)

    inputs, kind = {"harmonics": harmonics}, HarmonicModes
    return step("stuck modes", "nonlinear", inputs, kind, needs, compute, False, True)


@dataclass(frozen=True, slots=True)
class Linear:
    """Linear limits that one or more cases share."""

    name: str
    """The swept values that distinguish them from those of other cases, "" if there are no
    others."""
    system: Step[System]
    """The system without friction and preload, at the nodal diameters of rest and load."""
    limits: Step[Limits]
    """Its modes."""
    modes: Step[HarmonicModes]
    """Those with all contacts stuck at all these nodal diameters, by which responses are
    computed."""
    responses: dict[Limit, Step[Response]]
    """Linear responses."""

    @property
    def key(self) -> str:
        """Hash of all that it depends on."""
        return " ".join(step.key for step in self.responses.values())


def linear_of(structure: CaseStructure) -> Linear:
    """The linear limits of a case."""
    given, loaded = structure.problem, structure.loaded
    k = diameter_of(given, 1)
    system = structure.bare.system(loaded)
    parts = tuple(structure.component(name, k) for name in structure.names)
    mode = given.response.mode
    limits = limits_step(mode, system, structure.names, parts, structure.uncorrected)
    modes = structure.stuck_modes(loaded)
    responses = {which: linear_step(given, which, system, limits, modes) for which in LIMITS}
    return Linear("", system, limits, modes, responses)
