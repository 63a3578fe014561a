"""Models, reduced parts and recoveries of a study, each a step from the products before it.

A step's key is the hash of the study's keys that it reads, of its upstream steps' keys and of the
code behind it.

The steps to both parts' meshes: from dimensions, or read from files and then matched.
"""

from functools import lru_cache
from pathlib import Path
from typing import Any, cast

from vanelock import fem, mesh, rom
from vanelock.common.errors import InputError
from vanelock.common.files.digests import content_digest
from vanelock.fem import Model
from vanelock.input.band import LEAST, asked_by, least_band, softest
from vanelock.input.schema.structure.own_mesh import Casing, OwnCasing, OwnVane, Vane
from vanelock.input.schema.study import Study
from vanelock.mesh import Mates, OwnPart, Part, VaneDimensions
from vanelock.mesh.element_size import element_size
from vanelock.mesh.matching.pairing import TOLERANCE
from vanelock.mesh.matching.side import own_part
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import Component
from vanelock.stages.parts.loads import RestLoad, loads_of, modulus, reference, strained, unit_load

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
    needs: list[Step[Any]] = [
        _read_step(study, name, part)
        if isinstance(part, OwnVane | OwnCasing)
        else _made_step(study, name)
        for name, part in (("vane", study.vane), ("casing", study.casing))
    ]
    sectors, tolerance = study.ring.sectors, study.mesh.tolerance or TOLERANCE

    def compute(vane: Part | OwnPart, casing: Part | OwnPart) -> Mates:
        return mesh.pair(vane, casing, sectors, tolerance)

    inputs = {"sectors": sectors, "tolerance": tolerance}
    return step("match", "mesh", inputs, Mates, tuple(needs), compute)


def _read_step(study: Study, part: str, part_keys: OwnVane | OwnCasing) -> Step[OwnPart]:
    """A user's mesh with its sets; its key holds what the file contains, not where it is."""
    digest = content_digest(part_keys.mesh)
    interlock, sets = bool(study.joints.interlock), cast("dict[str, Any]", part_keys.sets)
    loaded = tuple(study.loads.pressure) if study.loads is not None and part == "vane" else ()

    def compute() -> OwnPart:
        found = mesh.read_mesh(part_keys.mesh, part_keys.unit)
        if content_digest(part_keys.mesh) != digest:
            raise InputError(f"{part_keys.mesh}: changed while it was read: run again")
        return own_part(found, part, sets, interlock, loaded)

    inputs: dict[str, Any] = {
        "contents": digest,
        "format": Path(part_keys.mesh).suffix.lower(),
        "unit": part_keys.unit,
        "sets": sets,
        "interlock": interlock,
    }
    if loaded:
        inputs["loaded"] = loaded
    return step(f"read {part}", "mesh", inputs, OwnPart, (), compute, False)


PARTS = ("vane", "casing")
MASTERS = {
    "vane": ("hook_front", "hook_rear", "interlock_left", "interlock_right", "key", "output"),
    "casing": ("hook_front", "hook_rear", "key", "force", "output"),
}


def model_step(study: Study, part: str, at_reference: bool = False) -> Step[Model]:
    """Stiffness and mass of a part; assembling takes no longer than reading would.

    With the modulus of its temperature in the response, or with that at which it is reduced.
    """
    metal = getattr(study.material, part)
    E = reference(study, part) if at_reference else modulus(study, part)
    return _assembled(part, E, metal.nu, metal.rho, mesh_step(study, part))


@lru_cache(maxsize=SHARED)
def _assembled(name: str, E: float, nu: float, rho: float, mesh: Step[Part]) -> Step[Model]:
    def compute(part: Part) -> Model:
        return fem.assemble(part, fem.Material(E=E, nu=nu, rho=rho))

    return step(
        f"fem {name}", "fem", {"E": E, "nu": nu, "rho": rho}, Model, (mesh,), compute, False
    )


def part_step(
    study: Study,
    part: str,
    nodal_diameter: int = 0,
    at_reference: bool = False,
    last: int | None = None,
) -> Step[Component]:
    """Reduced model of a part at its temperature, or with its modulus of reference.

    The vane's serves all nodal diameters, and has loads at rest in unit size, see
    `vanelock.stages.parts.loads`; the casing is reduced at one, 0 to N/2, of which the `last` lets
    go of what all of them share.
    """
    if part == "vane":
        reduced, names = _reduced_step(study, part), strained(loads_of(study))
    else:
        is_last = nodal_diameter == last
        reduced, names = _reduced_step(study, part, nodal_diameter, is_last), ()
    factor = 1.0 if at_reference else modulus(study, part) / reference(study, part)
    return _stiffened(reduced, part, factor, names)


@lru_cache(maxsize=SHARED)
def _stiffened(
    reduced: Step[Component], part: str, factor: float, strained: tuple[str, ...]
) -> Step[Component]:
    """A reduced part whose modulus is another; scaling takes no time, so it is not kept.

    With the names of its loads at rest that are of thermal strain.
    """
    if factor == 1:
        return reduced

    def compute(component: Component) -> Component:
        return rom.stiffened(component, factor, strained)

    name, inputs = f"rom {part}, modulus", {"factor": factor}
    return step(name, "rom", inputs, Component, (reduced,), compute, False, True)


def prepared_step(study: Study, part: str) -> Step[Any]:
    """What a part's reductions share, and its recovery; too large to be kept.

    The factors of its interior, or by the route "paper" the casing's Craig-Bampton model.
    """
    options, cyclic = study.rom, part == "casing"
    inputs: dict[str, Any] = {"cyclic": cyclic, **_kept(study, part)}
    if cyclic and options.route == "paper":
        inputs |= {"route": options.route, **options.of(part)}
    return _prepared(part, tuple(inputs.items()), model_step(study, part, True))


@lru_cache(maxsize=SHARED)
def _prepared(part: str, options: tuple[tuple[str, Any], ...], model: Step[Model]) -> Step[Any]:
    inputs = dict(options)

    def compute(model: Model) -> Any:
        return rom.prepare(model, **inputs)

    return step(f"rom {part}, condensed", "rom", inputs, object, (model,), compute, False)


def _reduced_step(
    study: Study, part: str, nodal_diameter: int = 0, is_last: bool = False
) -> Step[Component]:
    """A part reduced with its modulus of reference.

    Where an accuracy is asked for, the vane's tenth elastic mode ends the band of both parts, or
    the highest frequency that the study asks for (`vanelock.input.band`) where that is higher; a
    vane that is reduced to a number of modes gives no band, and the casing then takes its own.
    """
    follows = "accuracy" in study.rom.of(part)
    least = least_band(asked_by(study), softest(study), LEAST) if follows else None
    needs: list[Step[Any]] = [model_step(study, part, True), prepared_step(study, part)]
    loads: tuple[RestLoad, ...] = ()
    if part == "vane":
        loads = tuple(load.unit for load in loads_of(study))
    elif follows:
        needs.append(_reduced_step(study, "vane"))
    inputs: dict[str, Any] = {**study.rom.of(part), **_kept(study, part)}
    if least is not None:
        inputs["least"] = least
    if part == "casing":
        inputs |= {"nodal_diameters": (nodal_diameter,), "route": study.rom.route}
    shape = study.vane if isinstance(study.vane, VaneDimensions) else None
    return _reduced(part, tuple(inputs.items()), tuple(needs), loads, shape, is_last)


@lru_cache(maxsize=SHARED)
def _reduced(
    part: str,
    options: tuple[tuple[str, Any], ...],
    needs: tuple[Step[Any], ...],
    loads: tuple[RestLoad, ...],
    shape: VaneDimensions | None,
    is_last: bool,
) -> Step[Component]:
    """Without the vane's band, which a casing's may follow, and `loads` in unit size."""
    inputs = dict(options)

    def compute(model: Model, prepared: Any, *vane: Component) -> Component:
        band = {"band": vane[0].band} if vane else {}
        at_rest = {load.name: unit_load(model, shape, load) for load in loads}
        component = rom.reduce(model, **inputs | band, prepared=prepared, loads=at_rest)
        if is_last:
            prepared.forget_answers()
        return component.shortened()

    name = "rom vane" if part == "vane" else f"rom casing, ND {inputs['nodal_diameters'][0]}"
    keys = {**inputs, "loads": [load.name for load in loads]} if loads else inputs
    return step(name, "rom", keys, Component, needs, compute)


def recovery_step(
    study: Study,
    part: str,
    nodal_diameter: int = 0,
    at_reference: bool = False,
    last: int | None = None,
) -> Step[rom.Recovery]:
    """Recovery of a part at a nodal diameter; moduli as of `part_step`."""
    needs: list[Step[Any]] = [
        part_step(study, part, nodal_diameter, at_reference, last),
        model_step(study, part, at_reference),
    ]
    if part == "vane" or study.rom.route != "paper":
        needs.append(prepared_step(study, part))
    return _recovered(part, tuple(needs))


@lru_cache(maxsize=SHARED)
def _recovered(part: str, needs: tuple[Step[Any], ...]) -> Step[rom.Recovery]:
    """Factors are too large to be kept, and made when first used."""
    return step(f"recovery {part}", "rom", {}, rom.Recovery, needs, rom.recovery, False, True)


def _masters(study: Study, part: str) -> tuple[str, ...]:
    """Node sets that the joints, loads and outputs of a study use."""
    if study.joints.interlock:
        return MASTERS[part]
    return tuple(name for name in MASTERS[part] if not name.startswith("interlock"))


def _kept(study: Study, part: str) -> dict[str, Any]:
    """What a part keeps of its nodes."""
    return {"masters": _masters(study, part), "averaged": averaged(study, part)}


def averaged(study: Study, part: str) -> tuple[str, ...]:
    """Those of a part's masters whose contacts act on patches."""
    on_patches = [joint for joint, patch in study.patches.items() if patch == "area"]
    return tuple(name for name in _masters(study, part) if name.partition("_")[0] in on_patches)
