"""The scene file's schema: components from matrices, what joins, loads and touches them.

Field descriptions are the subjects of error messages, as in `vanelock.input.schema.study`.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Annotated, Any, ClassVar, Literal, TypeGuard

from pydantic import AfterValidator, BeforeValidator, Field

from vanelock.common.checked import Check
from vanelock.common.quantities import Angle, Force, Frequency, Length, Stiffness, is_whole
from vanelock.input.band import asked_for
from vanelock.input.schema.comparison import MeasuredCurve, curves
from vanelock.input.schema.distributions import Scatter
from vanelock.input.schema.response import Order, ResponseKeys
from vanelock.input.schema.structure.structure import SPRING, KeyTable, Listed
from vanelock.input.schema.study import Lists
from vanelock.rom.system.system import wider_band

ND = "{nd}"
"""Stands for the nodal diameter in the name of a file."""
GROUND = "ground"
"""What a contact's second component is called where there is none."""
DAMPING = 0.003
"""Modal damping ratio where neither a ratio nor a damping matrix is given."""
OPEN = "open"
"""Contacts in the modes that have this ratio, where it is not said."""

FILES = {
    "components": ("stiffness", "mass", "damping", "dofs", "nodes", "fixed", "low", "high"),
    "contacts": ("pairs",),
    "elements": ("pairs",),
    "ties": ("pairs",),
}
"""Keys of named tables that may hold a file's name."""

Vector = Annotated[Listed[float], Field(min_length=3, max_length=3)]


def _named(value: str) -> str:
    if not value.replace("_", "").replace("-", "").isalnum() or value == GROUND:
        raise ValueError(
            f'a name must consist of letters, digits, "_" and "-", and not be "{GROUND}"'
        )
    return value


Name = Annotated[str, Field(min_length=1, max_length=60), AfterValidator(_named)]


def _are_nodes(value: object) -> TypeGuard[Sequence[int]]:
    return isinstance(value, list | tuple) and all(is_whole(n) and n > 0 for n in value)


def _nodes(value: object) -> object:
    """A file's name, or a list of node numbers."""
    if isinstance(value, str) and value:
        return value
    if value and _are_nodes(value):
        return tuple(value)
    raise ValueError("expected node numbers, such as [17, 18], or a file's name")


def _pairs(value: object) -> object:
    """A file's name, a list of node numbers, or a list of pairs of them."""
    rows = value if isinstance(value, list | tuple) else ()
    if not rows or not all(isinstance(row, list | tuple) for row in rows):
        return _nodes(value)
    if not all(len(row) == 2 and _are_nodes(row) for row in rows):
        raise ValueError("expected pairs of node numbers, such as [[17, 4], [18, 5]]")
    return tuple(map(tuple, rows))


Nodes = Annotated[Any, BeforeValidator(_nodes)]
Pairs = Annotated[Any, BeforeValidator(_pairs)]


class SceneRingKeys(KeyTable):
    """Cyclic symmetry: one sector's matrices stand for the ring."""

    sectors: int = Field(default=1, ge=1, le=100_000, description="number of sectors")
    coordinates: Literal["cartesian", "cylindrical"] = Field(
        default="cartesian", description="components of the degrees of freedom"
    )


class _UnitKeys(KeyTable):
    """Units of a component's files."""

    length: Literal["m", "mm", "cm", "in", "ft"] = Field(default="m", description="length unit")
    mass: Literal["kg", "g", "t", "lb", "slug", "slinch"] = Field(
        default="kg", description="mass unit"
    )
    force: Literal["N", "mN", "kN", "lbf"] = Field(default="N", description="force unit")


class ComponentKeys(KeyTable):
    """A component: its matrices, and how they are used.

    `{nd}` in the names of a superelement's files stands for the nodal diameter.
    """

    stiffness: str = Field(min_length=1, description="stiffness file")
    mass: str | None = Field(default=None, min_length=1, description="mass file")
    damping: str | None = Field(default=None, min_length=1, description="damping file")
    stiffness_name: str | None = Field(default=None, description="name of the stiffness matrix")
    mass_name: str | None = Field(default=None, description="name of the mass matrix")
    damping_name: str | None = Field(default=None, description="name of the damping matrix")
    dofs: str | None = Field(default=None, min_length=1, description="file of rows")
    nodes: str | None = Field(default=None, min_length=1, description="file of nodes")
    units: _UnitKeys = _UnitKeys()
    kind: Literal["full", "superelement"] = Field(default="full", description="kind")
    fixed: Nodes | None = Field(default=None, description="clamped nodes")
    low: Nodes | None = Field(default=None, description="nodes of the low cyclic face")
    high: Nodes | None = Field(default=None, description="nodes of the high cyclic face")
    modes: int | None = Field(default=None, ge=0, le=10_000, description="number of modes")
    cutoff: Frequency | None = Field(default=None, gt=0, description="cut-off frequency [Hz]")
    accuracy: float | None = Field(
        default=None, ge=1e-9, lt=1, description="accuracy of the reduction"
    )
    band: Frequency | None = Field(default=None, gt=0, description="band [Hz]")

    def _is_reduced_in_one_way(self) -> Iterator[str]:
        chosen = [n for n in ("modes", "cutoff", "accuracy") if getattr(self, n) is not None]
        if len(chosen) > 1:
            yield f"{chosen[1]}: give either this or {chosen[0]}, not both"
        elif self.band is not None and chosen in (["modes"], ["cutoff"]):
            yield f"band: goes with accuracy only, not {chosen[0]}"

    def _fits_its_kind(self) -> Iterator[str]:
        if self.kind == "superelement":
            for name in ("modes", "cutoff", "accuracy", "band", "low", "high", "fixed"):
                if getattr(self, name) is not None:
                    yield f'{name}: kind = "superelement" is used as it is'
        elif "{nd}" in self.stiffness:
            yield 'stiffness: "{nd}" goes with kind = "superelement"'

    def _has_both_faces(self) -> Iterator[str]:
        if (self.low is None) != (self.high is None):
            yield "low: cyclic faces come in pairs: give low and high"

    checks: ClassVar[tuple[Check, ...]] = (
        _is_reduced_in_one_way,
        _fits_its_kind,
        _has_both_faces,
    )


class ContactKeys(KeyTable):
    """Contact elements between two components, or of one to ground.

    Those of a joined system are there already: what is given replaces their properties.
    """

    between: Listed[str] | None = Field(
        default=None, min_length=2, max_length=2, description="components"
    )
    pairs: Pairs | None = Field(default=None, description="node pairs")
    next_sector: bool = Field(default=False, description="whether the mate is the next sector's")
    normal: Vector | None = Field(default=None, description="normal")
    tangent: Vector | None = Field(default=None, description="tangent")
    kn: Annotated[Stiffness, SPRING] | None = Field(
        default=None, gt=0, le=1e15, description="normal stiffness of a pair [N/m]"
    )
    kt: Annotated[Stiffness, SPRING] | None = Field(
        default=None, gt=0, le=1e15, description="tangential stiffness of a pair [N/m]"
    )
    mu: float | None = Field(default=None, ge=0, le=1e6, description="friction coefficient")
    interference: Length | None = Field(
        default=None, ge=-1, le=1, description="interference of a pair [m]"
    )


class TieKeys(KeyTable):
    """Nodes of two components that move as one."""

    between: Listed[str] = Field(min_length=2, max_length=2, description="components")
    pairs: Pairs = Field(description="node pairs")


class ElementKeys(TieKeys):
    """Nonlinear elements along a direction, between two components or of one to ground."""

    next_sector: bool = Field(default=False, description="whether the mate is the next sector's")
    direction: Vector = Field(description="direction")
    law: Literal["cubic_spring", "stop", "quadratic_damper", "tanh_friction", "jenkins"] = Field(
        description="law"
    )
    parameters: Listed[float] = Field(
        min_length=1, max_length=1000, description="parameters of the law, in SI units"
    )


class LoadKeys(KeyTable):
    """Forces on nodes of a component: the same on each, or those of a file."""

    component: str = Field(description="component")
    nodes: Nodes | None = Field(default=None, description="loaded nodes")
    direction: Vector | None = Field(default=None, description="direction")
    amplitude: Force | None = Field(default=None, description="force on each node [N]")
    file: str | None = Field(default=None, min_length=1, description="file of nodal forces")
    scale: float = Field(default=1.0, description="factor of the file's forces")
    phase: Angle = Field(default=0.0, ge=-360, le=360, description="phase [deg]")
    harmonic: int = Field(default=1, ge=0, le=99, description="harmonic")

    @property
    def acts(self) -> bool:
        """Whether it is more than zero."""
        return bool(self.amplitude if self.file is None else self.scale)

    def _is_given_in_one_way(self) -> Iterator[str]:
        for name in ("nodes", "direction", "amplitude"):
            if self.file is None and getattr(self, name) is None:
                yield f"{name}: must be given, or file"
            elif self.file is not None and getattr(self, name) is not None:
                yield f"{name}: give either this or file, not both"
        if self.file is None and "scale" in self.model_fields_set:
            yield "scale: goes with file"

    checks: ClassVar[tuple[Check, ...]] = (_is_given_in_one_way,)


class _SystemKeys(KeyTable):
    """A system that is joined already, in place of components."""

    file: str = Field(min_length=1, description="system file")


class _SceneExcitation(KeyTable):
    """The travelling wave of the loads."""

    engine_order: Order = Field(default=1, description="engine order")


class _SceneDamping(KeyTable):
    """Structural damping."""

    ratio: float | None = Field(default=None, gt=0, lt=1, description="damping ratio")
    joints: Literal["open", "stuck"] | None = Field(
        default=None, description="contacts in the modes that have this ratio"
    )


class _SceneResponse(ResponseKeys):
    """Where and how finely the forced response is computed."""

    mode: int = Field(default=1, ge=1, le=1000, description="mode of interest")


class _SceneOutputs(KeyTable):
    """What a run shows of its results."""

    nodes: dict[str, Nodes] = Field(default_factory=dict, description="output nodes")
    monitor: str | None = Field(default=None, description="monitored displacement")
    show: Listed[Literal["loops", "report"]] = Field(
        default=("loops", "report"), description="what is drawn and written"
    )


class Scene(KeyTable):
    """A scene: components, what joins them, and the keys that are swept."""

    name: str = Field(default="scene", min_length=1, max_length=200, description="name")
    seed: int = Field(default=1, ge=0, le=2**31 - 1, description="seed of random numbers")
    ring: SceneRingKeys = SceneRingKeys()
    components: dict[Name, ComponentKeys] = Field(default_factory=dict, description="components")
    system: _SystemKeys | None = Field(default=None, description="joined system")
    ties: dict[Name, TieKeys] = Field(default_factory=dict, description="ties")
    contacts: dict[Name, ContactKeys] = Field(default_factory=dict, description="contacts")
    elements: dict[Name, ElementKeys] = Field(default_factory=dict, description="elements")
    loads: Listed[LoadKeys] = Field(default=(), description="loads")
    excitation: _SceneExcitation = _SceneExcitation()
    damping: _SceneDamping = _SceneDamping()
    response: _SceneResponse = _SceneResponse()
    outputs: _SceneOutputs = _SceneOutputs()
    measured: Annotated[tuple[MeasuredCurve, ...], BeforeValidator(curves)] = Field(
        default=(), max_length=100, description="measured curves"
    )
    sweep: Lists = Field(default_factory=dict, description="swept keys")
    rows: Lists = Field(default_factory=dict, description="keys that vary together")
    scatter: Scatter | None = Field(default=None, description="scattering keys")

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints with contacts; those of a joined system are not known before it is read."""
        return () if self.system is not None else tuple(self.contacts)

    @property
    def whole_ring(self) -> str:
        """The table that takes all nodal diameters, "" where none does."""
        return ""

    def _harmonics_are_computed(self) -> Iterator[str]:
        for i, load in enumerate(self.loads):
            if load.harmonic > self.response.harmonics:
                yield (
                    f"loads[{i}].harmonic: given {load.harmonic}: must be <= response.harmonics, "
                    f"{self.response.harmonics}"
                )

    def _turns_in_a_ring(self) -> Iterator[str]:
        if self.ring.sectors == 1 and self.excitation.engine_order != 1:
            yield "excitation.engine_order: needs ring.sectors of at least 2"

    def _has_components(self) -> Iterator[str]:
        if self.system is None and not self.components:
            yield "components: at least one must be given, or system.file"

    def _touches_somewhere(self) -> Iterator[str]:
        for name, contact in self.contacts.items() if self.system is None else ():
            for key in ("between", "pairs"):
                if getattr(contact, key) is None:
                    yield f"contacts.{name}.{key}: must be given"

    def _vibrates(self) -> Iterator[str]:
        loaded = any(load.harmonic > 0 and load.acts for load in self.loads)
        if self.system is None and not loaded:
            yield "loads: nothing vibrates: give one with an amplitude, harmonic >= 1"

    def _spares_cyclic_components(self) -> Iterator[str]:
        for i, load in enumerate(self.loads):
            part = self.components.get(load.component)
            if load.file is not None and part is not None and part.low is not None:
                yield (
                    f"loads[{i}].file: components.{load.component} is cyclic, and its reduction "
                    "has no static answers to forces: give nodes, direction and amplitude"
                )

    def _shows_something(self) -> Iterator[str]:
        if self.loads and not self.outputs.nodes and all(load.file for load in self.loads):
            yield "outputs.nodes: must be given where all loads are of files, whose nodes are none"

    def _leaves_to_the_system_what_it_holds(self) -> Iterator[str]:
        if self.system is None:
            return
        tables = ("ring", "components", "ties", "elements", "loads", "excitation")
        held = [name for name in tables if name in self.model_fields_set]
        held += ["outputs.nodes"] if self.outputs.nodes else []
        own = {"kn", "kt", "mu", "interference"}
        for name, contact in self.contacts.items():
            held += [f"contacts.{name}.{key}" for key in sorted(contact.model_fields_set - own)]
        if held:
            yield f"{', '.join(held)}: system.file holds it already"

    def _measures_displacement(self) -> Iterator[str]:
        for i, curve in enumerate(self.measured):
            if curve.gauge is not None:
                yield f"measured[{i}].gauge: a scene of matrices has no strain gauges"

    def _answers_its_range(self) -> Iterator[str]:
        bands = {name: keys.band for name, keys in self.components.items() if keys.band}
        for name, (key, highest) in product(bands, asked_for(self.response).items()):
            if highest > bands[name]:
                yield (
                    f"components.{name}.band = {bands[name]:g}: {key} reaches {highest:.6g} Hz, "
                    "where the reduced model would be wrong: write "
                    f'"{wider_band(highest):g} Hz", or leave it out'
                )

    checks: ClassVar[tuple[Check, ...]] = (
        _harmonics_are_computed,
        _answers_its_range,
        _measures_displacement,
        _turns_in_a_ring,
        _has_components,
        _touches_somewhere,
        _vibrates,
        _spares_cyclic_components,
        _shows_something,
        _leaves_to_the_system_what_it_holds,
    )
