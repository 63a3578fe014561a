"""A user's own meshes, read and matched for a check."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from vanelock.common.product import Product
from vanelock.input.schema.structure.own_mesh import OwnVane, refuse_without_areas
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.pipeline.cache import Cache, Entry
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.stages.parts.components import PARTS, mesh_step

P = TypeVar("P", bound=Product)


@dataclass(frozen=True)
class _Unkept(Cache):
    """Products that are made for the check alone."""

    def load(self, stage: str, key: str, kind: type[Any]) -> Entry[Any] | None:
        """None is known."""
        return None

    def store(self, stage: str, key: str, product: P, seconds: float, cpu: float = 0.0) -> Entry[P]:
        """Hand it back and forget it."""
        return Entry(product, seconds, cpu)


def own_meshes(studies: Iterable[Study]) -> dict[str, Part]:
    """Both parts of the first of some studies; those of the others are read and matched, too."""
    stages = Stages(_Unkept(Path(), lambda text: None), silent)
    first: dict[str, Part] = {}
    known = set()
    for study in studies:
        for name in PARTS:
            step = mesh_step(study, name)
            if step.key not in known:
                known.add(step.key)
                part = stages.get(step)
                first.setdefault(name, part)
                if name == "vane" and isinstance(study.vane, OwnVane):
                    refuse_without_areas(study, part)
    return first
