"""Vane and casing of a study and the system that they make at each nodal diameter, each a step.

What linear limits and modes with all contacts stuck do not depend on is left out of their systems,
so that cases share them.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, Literal, Self

from vanelock import rom
from vanelock.input.cases.values import diameter_of
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import MeshExcess, System
from vanelock.stages.parts.components import PARTS, mesh_step, part_step, recovery_step
from vanelock.stages.parts.loads import loads_of, strained
from vanelock.stages.parts.segment import (
    Segment,
    excess_step,
    joined_step,
    segment_of,
    vane_excess_step,
)
from vanelock.stages.structure import CaseStructure


@dataclass(frozen=True)
class StudyStructure(CaseStructure):
    """The vane and the casing of a study."""

    problem: Study
    without: Literal["nothing", "friction", "load"] = "nothing"
    """What its systems leave out: friction, interference and loads at rest; or these, and the
    study's own load for the default one."""
    at_reference: bool = False
    """Whether parts have the moduli at which they are reduced, not those of their temperatures."""
    last: int | None = None
    """The nodal diameter at which the last casing is reduced, if that is known: what all casings
    share is then let go of."""
    _made: dict[Any, Step[Any]] = field(default_factory=dict, repr=False, compare=False)
    names = PARTS

    def component(self, name: str, nodal_diameter: int) -> Step[Any]:
        """A part reduced at a nodal diameter; N - k is k, conjugated."""
        key = name, 0 if name == "vane" else self.folded(nodal_diameter)
        if key not in self._made:
            self._made[key] = part_step(self.problem, *key, self.at_reference, self.last)
        return self._made[key]

    def at(self, nodal_diameter: int) -> Step[System]:
        """The system at a nodal diameter, 0 to N/2."""
        found = self.meshed_at(nodal_diameter)
        if (excess := self.excess(nodal_diameter)) is None:
            return found
        return _corrected(found, excess)

    def meshed_at(self, k: int) -> Step[System]:
        """The same as the meshes are, nothing taken off."""
        segment = self.segment if k == 0 else self.segment.vibrating
        return joined_step(segment, *(self.component(name, k) for name in PARTS))

    def excess(self, nodal_diameter: int) -> Step[MeshExcess] | None:
        """What the meshes add at a nodal diameter; None where it stays."""
        return None if self.problem.mesh.correction == "none" else self.mesh_excess(nodal_diameter)

    def mesh_excess(self, nodal_diameter: int) -> Step[MeshExcess]:
        """What the meshes add at a nodal diameter."""
        k = nodal_diameter
        if ("excess", k) in self._made:
            return self._made["excess", k]
        study, loaded = self.problem, self.loaded
        patches = study.patches
        areas = tuple(name for name in study.joint_names if patches[name] == "area")
        on = Segment(self.segment.bare.joints), areas
        parts = self.component("vane", 0), self.component("casing", k)
        if "excess" not in self._made:
            recovered = recovery_step(study, "vane", 0, self.at_reference)
            casings = tuple(self.component("casing", each) for each in loaded)
            self._made["excess"] = vane_excess_step(parts[0], casings, recovered, loaded, *on)
        recovered = recovery_step(study, "casing", k, self.at_reference, self.last)
        found = excess_step(k, parts, self._made["excess"], recovered, *on)
        self._made["excess", k] = found
        return found

    def reduced(self, diameters: Iterable[int]) -> tuple[Step[Any], ...]:
        """All that a system at some nodal diameters is made from: its parts, what meshes add."""
        chosen = sorted({*map(self.folded, diameters)})
        return (*super().reduced(chosen), *filter(None, map(self.excess, chosen)))

    def rejoined(
        self,
        get: Callable[[Step[Any]], Any],
        diameters: Iterable[int],
        segment: Segment,
        moduli: tuple[float, float] = (1.0, 1.0),
    ) -> System:
        """The system of the reduced parts with other joints, load and damping, and moduli.

        `get` gives the products of `reduced`; `moduli` are those of vane and casing over their own.
        """
        strained_loads, found = strained(loads_of(self.problem)), []
        for k in sorted({*diameters}):
            vane, casing = (
                part if factor == 1 else rom.stiffened(part, factor, strained_loads)
                for part, factor in zip(
                    (get(self.component(name, k)) for name in PARTS), moduli, strict=True
                )
            )
            acting = segment if k == 0 else segment.vibrating
            system = acting.join(acting.loaded(vane), casing)
            excess = self.excess(k)
            found.append(system if excess is None else get(excess).taken_off(system, moduli))
        return rom.united(found)

    @cached_property
    def segment(self) -> Segment:
        """What joins and loads both parts."""
        if self.without == "nothing":
            loads = tuple((each.cause, each.name, each.size) for each in loads_of(self.problem))
            return replace(segment_of(self.problem), at_rest=loads)
        study = self.problem
        if self.without == "load":
            load = study.excitation.model_copy(update={"force": None, "unbalance": None})
            study = study.model_copy(update={"excitation": load})
        return segment_of(study).bare

    @property
    def bare(self) -> Self:
        """The same without friction, interference and loads at rest: that of the linear limits."""
        return replace(self, without="friction")

    @property
    def unloaded(self) -> Self:
        """The bare one with the default load."""
        return replace(self, without="load")

    @property
    def meshes(self) -> Mapping[str, Step[Part]]:
        """Meshes of both parts."""
        return {part: mesh_step(self.problem, part) for part in PARTS}

    @property
    def uncorrected(self) -> Step[System] | None:
        """The bare system at the load's diameter as its meshes are; None where that is `bare`."""
        if self.problem.mesh.correction == "none":
            return None
        return self.bare.meshed_at(diameter_of(self.problem, 1))


@lru_cache(maxsize=SHARED)
def _corrected(joined: Step[System], excess: Step[MeshExcess]) -> Step[System]:
    def compute(system: System, excess: MeshExcess) -> System:
        return excess.taken_off(system)

    inputs, needs = {"corrected": "modal"}, (joined, excess)
    return step("system", "rom", inputs, System, needs, compute, False, True)
