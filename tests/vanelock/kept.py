"""What a run keeps in its cache and not in its results."""

from pathlib import Path

from vanelock import Study
from vanelock.input.cases.sweep import cases
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages
from vanelock.rom import Component
from vanelock.stages.plan import plan
from vanelock.stages.response.responses import silent_progress


def reduced_parts(study: Study, folder: Path) -> list[Component]:
    """Vane and casing of the first case with the vectors that fields need."""
    stages = Stages(Cache(folder / "cache", print), lambda event: None)
    first = plan(cases(study), silent_progress)[0]
    return [stages.get(step) for step in first.rom.values()]
