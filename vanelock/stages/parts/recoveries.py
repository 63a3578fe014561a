"""What takes reduced coordinates of a part to all its nodes, its factors made once for all uses."""

from functools import lru_cache
from typing import Any

from vanelock import rom
from vanelock.fem import Model
from vanelock.input.schema.study import Study
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import Component
from vanelock.stages.parts.components import model_step, prepared_step, shared_step


def recovery_step(
    study: Study, part: str, component: Step[Component], model: Step[Model] | None = None
) -> Step[rom.Recovery]:
    """Recovery of a part from its reduced model, of the study's modulus or of another model's."""
    shared = shared_step(study) if part == "casing" else prepared_step(study, part)
    needs = (component, model or model_step(study, part), *((shared,) if shared else ()))
    return _recovered(part, needs)


@lru_cache(maxsize=SHARED)
def _recovered(part: str, needs: tuple[Step[Any], ...]) -> Step[rom.Recovery]:
    """Factors are too large to be kept, and made when first used."""
    return step(f"recovery {part}", "rom", {}, rom.Recovery, needs, rom.recovery, False, True)
