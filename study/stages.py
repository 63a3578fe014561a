"""The stages of a study, each a step from the products before it to its own.

A step knows what it depends on: its key is the hash of the study's keys that it reads, of its
upstream steps' keys and of the code behind it. So all keys of a study are known before anything
is computed, and a product that is in the cache saves everything upstream of it.
"""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Generic, TypeVar

from vanelock import fem, mesh, rom
from vanelock.fem import Model
from vanelock.mesh import Part
from vanelock.product import Product
from vanelock.rom import Component, Joint, System
from vanelock.study.cache import Cache, key_of
from vanelock.study.model import Study
from vanelock.study.progress import Begun, Done, Listener

P = TypeVar("P", bound=Product)
PARTS = ("vane", "casing")
MASTERS = {
    "vane": ("hook_front", "hook_rear", "interlock_left", "interlock_right", "key", "accessory"),
    "casing": ("hook_front", "hook_rear", "key", "force", "accessory"),
}


@dataclass(frozen=True)
class Step(Generic[P]):
    """One stage of one study.

    Attributes
    ----------
    name : str
        What the progress display calls it.
    key : str
        Hash of all that its product depends on.
    kind : type
        The product's class.
    needs : tuple of Step
        Steps whose products it takes.
    compute : callable
        From those products to its own.
    kept : bool
        Whether the product goes into the cache; one that takes longer to read than to make
        does not.
    quick : bool
        Whether it is done before anyone could read its name.
    """

    name: str
    key: str
    kind: type[P]
    needs: tuple["Step[Any]", ...]
    compute: Callable[..., P]
    kept: bool = True
    quick: bool = False


def step(
    name: str,
    package: str,
    inputs: Mapping[str, Any],
    kind: type[P],
    needs: tuple[Step[Any], ...],
    compute: Callable[..., P],
    kept: bool = True,
    quick: bool = False,
) -> Step[P]:
    """A step whose key follows from its inputs, what it needs and the code of `package`."""
    key = key_of(name, package, inputs, tuple(need.key for need in needs))
    return Step(name, key, kind, needs, compute, kept, quick)


@dataclass
class Stages:
    """Runs steps: from memory, from the cache, or by computing them.

    Attributes
    ----------
    cache : Cache
        Where products are kept between runs.
    listener : callable
        Told about each stage.
    done : dict of str to Done
        The steps so far by key, in order.
    """

    cache: Cache
    listener: Listener
    done: dict[str, Done] = field(default_factory=dict)
    _products: dict[str, Product] = field(default_factory=dict)

    def get(self, step: Step[P]) -> P:
        """Product of a step."""
        if step.key in self._products:
            return self._products[step.key]  # type: ignore[return-value]
        entry = self.cache.load(step.name, step.key, step.kind) if step.kept else None
        if entry is not None:
            product, seconds = entry.product, entry.seconds
        else:
            product, seconds = self._computed(step)
        if step.key not in self.done:
            self.done[step.key] = Done(step.name, seconds, entry is not None)
            if not step.quick:
                self.listener(self.done[step.key])
        self._products[step.key] = product
        return product

    def retain(self, steps: Iterable[Step[Any]]) -> None:
        """Drop from memory what none of the steps, nor any that they need, produces."""
        wanted: set[str] = set()
        waiting = list(steps)
        while waiting:
            step = waiting.pop()
            if step.key not in wanted:
                wanted.add(step.key)
                waiting += step.needs
        self._products = {k: v for k, v in self._products.items() if k in wanted}

    def _computed(self, step: Step[P]) -> tuple[P, float]:
        given = [self.get(need) for need in step.needs]
        if not step.quick and step.key not in self.done:
            self.listener(Begun(step.name))
        began = time.perf_counter()
        product = step.compute(*given)
        seconds = time.perf_counter() - began
        if step.kept:
            self.cache.store(step.name, step.key, product, seconds)
        return product, seconds


def mesh_step(study: Study, part: str) -> Step[Part]:
    """Mesh of a part."""
    sectors, size = study.ring.sectors, study.mesh.size
    dimensions = {"vane": study.vane, "casing": study.casing}[part].model_dump()
    overlap = mesh.hook_overlap(study.vane, study.casing)
    inputs = {"sectors": sectors, "size": size, "dimensions": dimensions, "overlap": overlap}
    if part == "casing":
        inputs["hook"] = study.vane.hook.model_dump()
        inputs["face_nodes"] = study.mesh.face_nodes

    def compute() -> Part:
        if part == "vane":
            return mesh.vane_segment(study.vane, sectors, size, overlap)
        return mesh.casing_sector(
            study.casing, study.vane.hook, sectors, size, overlap, study.mesh.face_nodes
        )

    return step(f"mesh {part}", "mesh", inputs, Part, (), compute)


def model_step(study: Study, part: str) -> Step[Model]:
    """Stiffness and mass of a part; assembling takes no longer than reading would."""
    elastic = getattr(study.material, part).model_dump()

    def compute(part: Part) -> Model:
        return fem.assemble(part, fem.Material(**elastic))

    return step(f"fem {part}", "fem", elastic, Model, (mesh_step(study, part),), compute, False)


def rom_step(study: Study, part: str, diameters: Iterable[int]) -> Step[Component]:
    """Reduced model of a part; the casing's at the given nodal diameters.

    Where an accuracy is asked for and no band, the vane's tenth elastic mode ends it for both; a
    vane that is reduced to a number of modes tells no band, and the casing then takes its own.
    """
    options = study.rom
    kept, means = masters(study, part), averaged(study, part)
    inputs: dict[str, Any] = {"masters": kept, **options.of(part), "averaged": means}
    if part == "vane":

        def compute(model: Model) -> Component:
            return rom.reduce(model, **inputs)

        return step("rom vane", "rom", inputs, Component, (model_step(study, part),), compute)
    inputs |= {"nodal_diameters": sorted(diameters), "route": options.route}
    inputs |= {"interface": options.interface, "interface_modes": options.interface_modes}
    needs: tuple[Step[Any], ...] = (model_step(study, part),)
    if inputs.get("accuracy") is not None and inputs["band"] is None:
        needs += (rom_step(study, "vane", ()),)

    def follow(model: Model, vane: Component | None = None) -> Component:
        band = {} if vane is None else {"band": vane.band}
        return rom.reduce(model, **inputs | band)

    return step("rom casing", "rom", inputs, Component, needs, follow)


def masters(study: Study, part: str) -> tuple[str, ...]:
    """Node sets that the joints, loads and outputs of a study use."""
    if study.joints.interlock.enabled:
        return MASTERS[part]
    return tuple(name for name in MASTERS[part] if not name.startswith("interlock"))


def averaged(study: Study, part: str) -> tuple[str, ...]:
    """Those of a part's masters whose contacts act on patches."""
    chosen = {"hook": study.joints.hook.patch, "interlock": study.joints.interlock.patch}
    on_patches = [joint for joint, patch in chosen.items() if patch == "area"]
    return tuple(name for name in masters(study, part) if name.partition("_")[0] in on_patches)


def diameters(studies: Iterable[Study]) -> tuple[int, ...]:
    """Nodal diameters (h·EO) mod N of all harmonics of some cases, k and N-k once."""
    found = set()
    for study in studies:
        N = study.ring.sectors
        for h in range(study.response.harmonics + 1):
            k = (h * study.excitation.engine_order) % N
            found.add(min(k, N - k))
    return tuple(sorted(found))


def joints(study: Study) -> tuple[Joint, ...]:
    """The joints with contact elements."""
    hook, interlock = study.joints.hook, study.joints.interlock
    found = [Joint("hook", hook.kn, hook.kt, hook.mu, hook.interference)]
    if interlock.enabled:
        properties = interlock.model_dump(exclude={"enabled", "patch"})
        found.append(Joint("interlock", **properties))
    return tuple(found)


def system_step(study: Study, vane: Step[Component], casing: Step[Component]) -> Step[System]:
    """The system of a case; joining takes no time, so it is not kept."""
    excitation = rom.Excitation(
        engine_order=study.excitation.engine_order,
        force=study.excitation.force_per_node,
        unbalance=study.excitation.unbalance or 0.0,
    )
    joined = joints(study)
    inputs = {
        "joints": [asdict(joint) for joint in joined],
        "excitation": asdict(excitation),
        "damping": study.damping.ratio,
    }

    def compute(vane: Component, casing: Component) -> System:
        return rom.join(vane, casing, joined, excitation, study.damping.ratio)

    return step("system", "rom", inputs, System, (vane, casing), compute, False, True)
