"""Models and reduced parts of a study, each a step from the products before it to its own.

A step's key is the hash of the study's keys that it reads, of its upstream steps' keys and of the
code behind it.
"""

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

from vanelock import fem, rom
from vanelock.common.cyclic import folded
from vanelock.fem import Model
from vanelock.input.band import LEAST, asked_by, least_band, softest
from vanelock.input.cases.values import Given
from vanelock.input.schema.structure.structure import Rom
from vanelock.input.schema.study import Study
from vanelock.mesh import Part, VaneDimensions
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import Component
from vanelock.stages.parts.loads import RestLoad, loads_of, strained, unit_load
from vanelock.stages.parts.meshes import mesh_step
from vanelock.stages.parts.temperatures import modulus, reference

PARTS = ("vane", "casing")
MASTERS = {
    "vane": ("hook_front", "hook_rear", "interlock_left", "interlock_right", "key", "output"),
    "casing": ("hook_front", "hook_rear", "key", "force", "output"),
}


def model_step(study: Study, part: str, E: float | None = None) -> Step[Model]:
    """Stiffness and mass of a part; assembling takes no longer than reading would.

    With the modulus of its temperature in the response, or another, Pa.
    """
    metal = getattr(study.material, part)
    E = modulus(study, part) if E is None else E
    return _assembled(part, E, metal.nu, metal.rho, mesh_step(study, part))


@lru_cache(maxsize=SHARED)
def _assembled(name: str, E: float, nu: float, rho: float, mesh: Step[Part]) -> Step[Model]:
    def compute(part: Part) -> Model:
        return fem.assemble(part, fem.Material(E=E, nu=nu, rho=rho))

    return step(
        f"fem {name}", "fem", {"E": E, "nu": nu, "rho": rho}, Model, (mesh,), compute, False
    )


def reference_step(study: Study, part: str) -> Step[Model]:
    """The model of a part that is reduced, whatever its temperature."""
    return model_step(study, part, reference(study, part))


def rom_step(
    study: Study, part: str, diameters: Iterable[int], prepared: Step[Any] | None = None
) -> Step[Component]:
    """Reduced model of a part at its temperature; the casing's at the given nodal diameters.

    With loads at rest in unit size, see `vanelock.stages.parts.loads`.
    """
    reduced = reduced_step(study, part, diameters, prepared)
    loads = loads_of(study) if part == "vane" else ()
    factor = modulus(study, part) / reference(study, part)
    return stiffened_step(reduced, part, factor, strained(loads))


def casing_step(study: Study, nodal_diameter: int) -> Step[Component]:
    """The casing reduced at one nodal diameter, 0 to N/2, so that a run may stop in time.

    Each is a step of its own; what all of them share is computed when the first of them is.
    """
    return rom_step(study, "casing", [nodal_diameter], shared_step(study))


def shared_step(study: Study) -> Step[Any] | None:
    """What all nodal diameters of the casing share, None by a route that has no such thing."""
    return None if study.rom.route == "paper" else prepared_step(study, "casing")


def diameter_of(study: Study, harmonic: int) -> int:
    """Nodal diameter of a harmonic, 0 to N/2: k and N - k are one another's conjugates."""
    return folded(harmonic * study.excitation.engine_order, study.ring.sectors)


@lru_cache(maxsize=SHARED)
def stiffened_step(
    reduced: Step[Component], part: str, factor: float, strained: tuple[str, ...] = ()
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
    """The factors that a part's reduction and its recovery share; too large to be kept."""
    return _prepared(part, masters(study, part), averaged(study, part), reference_step(study, part))


@lru_cache(maxsize=SHARED)
def _prepared(
    part: str, kept: tuple[str, ...], means: tuple[str, ...], model: Step[Model]
) -> Step[Any]:
    inputs = {"masters": kept, "averaged": means, "cyclic": part == "casing"}

    def compute(model: Model) -> Any:
        return rom.prepare(model, **inputs)

    return step(f"rom {part}, condensed", "rom", inputs, object, (model,), compute, False)


def reduced_step(
    study: Study, part: str, diameters: Iterable[int], prepared: Step[Any] | None = None
) -> Step[Component]:
    """Reduced model of a part with its modulus of reference.

    With what its nodal diameters share `prepared`, see `casing_step`.

    Where an accuracy is asked for and no band, the vane's tenth elastic mode ends it for both, or
    the highest frequency that the study asks for (`vanelock.input.band`) where that is higher; a
    vane that is reduced to a number of modes gives no band, and the casing then takes its own.
    """
    options, model = study.rom, reference_step(study, part)
    wants = options.of(part)
    follows = wants.get("accuracy") is not None and options.band is None
    least = least_band(asked_by(study), softest(study), LEAST) if follows else None
    own = (masters(study, part), averaged(study, part), options, least, model)
    if part == "vane":
        shape = study.vane if isinstance(study.vane, VaneDimensions) else None
        loads = tuple(load.unit for load in loads_of(study))
        return _reduced_vane(*own, prepared_step(study, part), loads, shape)
    vane = reduced_step(study, "vane", ()) if follows else None
    return _reduced_casing(*own, tuple(sorted(diameters)), vane, prepared)


@lru_cache(maxsize=SHARED)
def _reduced_vane(
    kept: tuple[str, ...],
    means: tuple[str, ...],
    options: Rom,
    least: float | None,
    model: Step[Model],
    prepared: Step[Any],
    loads: tuple[RestLoad, ...],
    shape: VaneDimensions | None,
) -> Step[Component]:
    inputs: dict[str, Any] = {"masters": kept, **options.of("vane"), "averaged": means}
    if least is not None:
        inputs["least"] = least

    def compute(model: Model, prepared: Any) -> Component:
        found = {load.name: unit_load(model, shape, load) for load in loads}
        return rom.reduce(model, **inputs, prepared=prepared, loads=found).shortened()

    given = {**inputs, "loads": [load.name for load in loads]} if loads else inputs
    return step("rom vane", "rom", given, Component, (model, prepared), compute)


@lru_cache(maxsize=SHARED)
def _reduced_casing(
    kept: tuple[str, ...],
    means: tuple[str, ...],
    options: Rom,
    least: float | None,
    model: Step[Model],
    chosen: tuple[int, ...],
    vane: Step[Component] | None,
    prepared: Step[Any] | None,
) -> Step[Component]:
    inputs: dict[str, Any] = {"masters": kept, **options.of("casing"), "averaged": means}
    if least is not None:
        inputs["least"] = least
    inputs |= {"nodal_diameters": list(chosen), "route": options.route}

    def compute(model: Model, *others: Any) -> Component:
        band = {} if vane is None else {"band": others[0].band}
        if prepared is None:
            return rom.reduce(model, **inputs | band).shortened()
        component = rom.reduce(model, **inputs | band, prepared=others[-1])
        if len(chosen) > 1:  # no further one is to come
            others[-1].forget_answers()
        return component.shortened()

    needs = (model, *(each for each in (vane, prepared) if each is not None))
    name = "rom casing" if len(chosen) > 1 else f"rom casing, ND {chosen[0]}"
    return step(name, "rom", inputs, Component, needs, compute)


def masters(study: Study, part: str) -> tuple[str, ...]:
    """Node sets that the joints, loads and outputs of a study use."""
    if study.joints.interlock.enabled:
        return MASTERS[part]
    return tuple(name for name in MASTERS[part] if not name.startswith("interlock"))


def averaged(study: Study, part: str) -> tuple[str, ...]:
    """Those of a part's masters whose contacts act on patches."""
    on_patches = [joint for joint, patch in study.patches.items() if patch == "area"]
    return tuple(name for name in masters(study, part) if name.partition("_")[0] in on_patches)


def diameters(cases: Iterable[Given]) -> tuple[int, ...]:
    """Nodal diameters (h·EO) mod N of all harmonics of some cases, k and N-k once."""
    found = {
        folded(h * each.excitation.engine_order, each.ring.sectors)
        for each in cases
        for h in range(each.response.harmonics + 1)
    }
    return tuple(sorted(found))
