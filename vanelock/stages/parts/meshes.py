"""The steps to both parts' meshes: from dimensions, or read from files and then matched."""

from functools import lru_cache
from pathlib import Path
from typing import Any, cast

from vanelock import mesh
from vanelock.common.errors import InputError
from vanelock.input.schema.structure.own_mesh import Casing, OwnCasing, OwnVane, Vane
from vanelock.input.schema.study import Study
from vanelock.mesh import Mates, OwnPart, Part
from vanelock.mesh.element_size import element_size
from vanelock.mesh.matching.pairing import TOLERANCE
from vanelock.mesh.matching.side import own_part
from vanelock.pipeline.cache import content_digest
from vanelock.pipeline.step import SHARED, Step, step

NOWHERE = (0.0, 0.0)
"""Overlap of the hooks' faces where a mesh takes a part's place: contacts act on nodes then."""


def mesh_step(study: Study, part: str) -> Step[Part]:
    """Mesh of a part."""
    if not isinstance(getattr(study, part), OwnVane | OwnCasing):
        return _made_step(study, part)

    def chosen(mates: Mates) -> Part:
        return mates.vane if part == "vane" else mates.casing

    needs = (_mates_step(study),)
    return step(f"mesh {part}", "mesh", {"part": part}, Part, needs, chosen, False, True)


def _made_step(study: Study, part: str) -> Step[Part]:
    """Mesh of a part that has dimensions."""
    keys = study.mesh.size, study.mesh.face_nodes, study.stretch
    return _meshed(study.vane, study.casing, study.ring.sectors, keys, part)


@lru_cache(maxsize=SHARED)
def _meshed(
    vane: Vane, casing: Casing, sectors: int, keys: tuple[Any, int | None, int], part: str
) -> Step[Part]:
    length, face_nodes, stretch = element_size(keys[0], part), *keys[1:]
    if isinstance(vane, OwnVane) or isinstance(casing, OwnCasing):
        overlap = NOWHERE
    else:
        overlap = mesh.hook_overlap(vane, casing)
    dimensions = {"vane": vane, "casing": casing}[part].model_dump()
    inputs = {"sectors": sectors, "size": length, "dimensions": dimensions, "overlap": overlap}
    if part == "casing":
        inputs["hook"] = vane.hook.model_dump()
        inputs["face_nodes"] = face_nodes
        inputs["stretch"] = stretch

    def compute() -> Part:
        if part == "vane":
            assert isinstance(vane, mesh.VaneDimensions)
            return mesh.vane_segment(vane, sectors, length, overlap)
        assert isinstance(casing, mesh.CasingDimensions)
        return mesh.casing_sector(casing, vane.hook, sectors, length, overlap, face_nodes, stretch)

    return step(f"mesh {part}", "mesh", inputs, Part, (), compute)


def _mates_step(study: Study) -> Step[Mates]:
    """Both parts, matched; one that has dimensions comes out as it was."""
    own = {
        name: part
        for name, part in (("vane", study.vane), ("casing", study.casing))
        if isinstance(part, OwnVane | OwnCasing)
    }
    needs = tuple(
        _read_step(study, name, own[name]) if name in own else _made_step(study, name)
        for name in ("vane", "casing")
    )
    sectors, tolerance = study.ring.sectors, study.mesh.tolerance or TOLERANCE

    def compute(vane: Part | OwnPart, casing: Part | OwnPart) -> Mates:
        return mesh.pair(vane, casing, sectors, tolerance)

    inputs = {"sectors": sectors, "tolerance": tolerance}
    return step("match", "mesh", inputs, Mates, needs, compute)


def _read_step(study: Study, part: str, own: OwnVane | OwnCasing) -> Step[OwnPart]:
    """A user's mesh with its sets; its key holds what the file contains, not where it is."""
    digest = content_digest(own.mesh)
    interlock, sets = bool(study.joints.interlock), cast("dict[str, Any]", own.sets)
    loaded = tuple(study.loads.pressure) if study.loads is not None and part == "vane" else ()

    def compute() -> OwnPart:
        found = mesh.read_mesh(own.mesh, own.unit)
        if content_digest(own.mesh) != digest:
            raise InputError(f"{own.mesh}: changed while it was read: run again")
        return own_part(found, part, sets, interlock, loaded)

    inputs: dict[str, Any] = {
        "contents": digest,
        "format": Path(own.mesh).suffix.lower(),
        "unit": own.unit,
        "sets": sets,
        "interlock": interlock,
    }
    if loaded:
        inputs["loaded"] = loaded
    return step(f"read {part}", "mesh", inputs, OwnPart, (), compute, False)
