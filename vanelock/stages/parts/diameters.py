"""The casing reduced at one nodal diameter after the other, so that a run may stop in time.

Each nodal diameter is a step of its own; what all of them share, a factorisation of the casing, is
computed when the first of them is.
"""

from typing import Any

from vanelock.common.cyclic import folded
from vanelock.input.schema.study import Study
from vanelock.pipeline.step import Step
from vanelock.rom import Component
from vanelock.stages.parts.components import prepared_step, rom_step


def shared_step(study: Study) -> Step[Any] | None:
    """What all nodal diameters of the casing share, None by a route that has no such thing."""
    return None if study.rom.route == "paper" else prepared_step(study, "casing")


def casing_step(study: Study, nodal_diameter: int) -> Step[Component]:
    """The casing reduced at a nodal diameter, 0 to N/2."""
    return rom_step(study, "casing", [nodal_diameter], shared_step(study))


def diameter_of(study: Study, harmonic: int) -> int:
    """Nodal diameter of a harmonic, 0 to N/2: k and N - k are one another's conjugates."""
    return folded(harmonic * study.excitation.engine_order, study.ring.sectors)
