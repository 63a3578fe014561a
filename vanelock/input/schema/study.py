"""The study file's schema: every key, its unit, its default and what it may be.

Field descriptions are the subjects of error messages ("friction coefficient must be >= 0").
"""

import re
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    field_validator,
)

from vanelock.common.checked import Check
from vanelock.common.cyclic import COMPONENTS
from vanelock.common.quantities import Force, Frequency, Length, Unbalance, si
from vanelock.common.tables import counted
from vanelock.input.band import BAND_CHECKS
from vanelock.input.schema.assessment import BoundsKeys, StabilityKeys, UnlikeKeys, can_be_assessed
from vanelock.input.schema.comparison import (
    COMPARISON_CHECKS,
    CampbellKeys,
    Fit,
    MeasuredCurve,
    Optimise,
    curves,
)
from vanelock.input.schema.distributions import Scatter
from vanelock.input.schema.loads import LOAD_CHECKS, RestLoadKeys
from vanelock.input.schema.own_mesh import OWN_MESH_CHECKS, Casing, OwnCasing, OwnVane, Vane
from vanelock.input.schema.published import CAMPAIGN_CHECKS, Campaign
from vanelock.input.schema.structure import (
    Joints,
    KeyTable,
    MaterialKeys,
    MeshKeys,
    RingKeys,
    Rom,
    leaves,
    sequence,
)
from vanelock.input.schema.temperature import TEMPERATURE_CHECKS, Temperature
from vanelock.mesh import CasingDimensions, VaneDimensions
from vanelock.mesh.generate.stretch import checked_stretch
from vanelock.mesh.refinement.dof_estimate import check_size
from vanelock.nonlinear.contact.sampling import least_samples

MONITOR = (
    rf"(?P<node>(?:vane|casing) output [1-9][0-9]*)(?:, (?P<component>{'|'.join(COMPONENTS)}))?"
)

_MONITORED = (
    'expected an output node and a component, such as "vane output 1, radial" '
    "(vane or casing; output 1 to 3; radial, circumferential or axial)"
)


FrequencyList = Annotated[
    tuple[Annotated[Frequency, Field(gt=0, description="frequency [Hz]")], ...],
    BeforeValidator(sequence),
]


def _travels(value: int) -> int:
    if value == 0:
        raise ValueError("engine order must not be 0; negative is a backward wave")
    return value


Order = Annotated[
    int, Field(ge=-1000, le=1000, description="engine order"), AfterValidator(_travels)
]


class ExcitationKeys(KeyTable):
    """The travelling radial load on the casing: a force per node, or a rotating unbalance.

    A load too small would drown in the round-off of the static deformation.
    """

    engine_order: Order = Field(default=1, description="engine order")
    engine_orders: Annotated[tuple[Order, ...], BeforeValidator(sequence)] | None = Field(
        default=None, min_length=1, description="engine orders"
    )
    force: Force | None = Field(
        default=None, ge=1e-6, le=1e6, description="radial force per node [N]"
    )
    unbalance: Unbalance | None = Field(
        default=None, ge=1e-9, le=100, description="unbalance [kg m]"
    )

    @field_validator("engine_orders")
    @classmethod
    def _distinct(cls, value: tuple[int, ...] | None) -> tuple[int, ...] | None:
        if value is not None and len(set(value)) < len(value):
            raise ValueError("engine orders must differ from each other")
        return value

    @field_validator("unbalance")
    @classmethod
    def _one_load(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is None:
            return value
        if info.data.get("force") is not None:
            raise ValueError("give either unbalance or excitation.force, not both")
        orders = info.data.get("engine_orders") or [info.data.get("engine_order", 1)]
        if any(abs(order) != 1 for order in orders):
            raise ValueError("an unbalance excites excitation.engine_order 1 or -1 only")
        return value

    def _one_list(self) -> Iterator[str]:
        if self.engine_orders is not None and "engine_order" in self.model_fields_set:
            given = list(self.engine_orders)
            yield f"engine_orders = {given}: give either this or excitation.engine_order, not both"

    checks: ClassVar[tuple[Check, ...]] = (_one_list,)

    @property
    def force_per_node(self) -> float:
        """Radial force per node, N: 30 N unless the study says otherwise, 0 with an unbalance."""
        if self.unbalance is not None:
            return 0.0
        return 30.0 if self.force is None else self.force


class Damping(KeyTable):
    """Structural damping."""

    ratio: float = Field(default=0.003, gt=0, lt=1, description="damping ratio")
    joints: Literal["open", "stuck"] = Field(
        default="open", description="contacts in the modes that have this ratio"
    )


class ResponseKeys(KeyTable):
    """Where and how finely the forced response is computed."""

    mode: int = Field(default=2, ge=1, le=20, description="mode of interest")
    frequencies: FrequencyList | None = Field(
        default=None, min_length=1, description="excitation frequency [Hz]"
    )
    range: FrequencyList | None = Field(
        default=None, min_length=2, max_length=2, description="[low, high] frequency [Hz]"
    )
    points: int | None = Field(default=None, ge=2, le=100_000, description="number of frequencies")
    direction: Literal["up", "down", "both"] = Field(
        default="up", description="direction of the sweep"
    )
    harmonics: int = Field(default=3, ge=1, le=99, description="highest harmonic")
    friction: Literal["orthogonal", "isotropic"] = Field(
        default="orthogonal", description="friction in the tangential plane"
    )
    coupling: Literal["coupled", "uncoupled", "constant-load"] = Field(
        default="coupled", description="coupling of the static and the dynamic balance"
    )
    harmonic_diameters: Literal["wave", "sector"] = Field(
        default="wave", description="nodal diameter of each harmonic"
    )
    samples: int | None = Field(
        default=None,
        ge=8,
        le=1_000_000,
        description="number of samples of a period",
    )
    effort: int = Field(default=3000, ge=1, le=1_000_000, description="Newton steps of a point")

    @field_validator("points")
    @classmethod
    def _on_a_range(cls, value: int | None, info: ValidationInfo) -> int | None:
        if value is not None and info.data.get("frequencies") is not None:
            raise ValueError("give either response.points or response.frequencies, not both")
        return value

    @field_validator("frequencies")
    @classmethod
    def _ascends(cls, value: tuple[float, ...] | None) -> tuple[float, ...] | None:
        if value is not None and any(a >= b for a, b in pairwise(value)):
            raise ValueError("frequencies must ascend")
        return value

    @field_validator("range")
    @classmethod
    def _low_high(
        cls, value: tuple[float, ...] | None, info: ValidationInfo
    ) -> tuple[float, ...] | None:
        if value is None:
            return value
        if info.data.get("frequencies") is not None:
            raise ValueError("give either response.range or response.frequencies, not both")
        if value[0] >= value[1]:
            raise ValueError("must be [low, high] with low < high")
        return value


def _direction(value: object) -> object:
    """Pass "span" and "chord"; anything else is an angle in degrees."""
    if value in ("span", "chord"):
        return value
    try:
        angle = si(value, "deg")
    except ValueError:
        angle = None
    if isinstance(angle, bool) or not isinstance(angle, int | float) or not -180 <= angle <= 180:
        raise ValueError(
            'gauge direction must be "span", "chord" or the angle from the former to the latter, '
            "-180 to 180 deg"
        )
    return float(angle)


class GaugeKeys(KeyTable):
    """A strain gauge on an aerofoil of the vane."""

    aerofoil: int = Field(ge=1, description="number of the aerofoil")
    span: float = Field(ge=0, le=1, description="fraction of the span")
    chord: float = Field(ge=0, le=1, description="fraction of the chord")
    side: Literal["suction", "pressure"] = Field(default="suction", description="side")
    direction: Annotated[Any, BeforeValidator(_direction)] = Field(
        default="span", description="direction"
    )
    length: Length = Field(default=0.002, ge=1e-5, le=0.05, description="gauge length [m]")


class Outputs(KeyTable):
    """What a run shows of its results."""

    monitor: str | None = Field(default=None, description="monitored displacement")
    shapes: bool = Field(default=True, description="whether shapes are drawn")
    ring: bool = Field(default=False, description="whether .vtu files of the ring are written")
    loops: bool = Field(default=True, description="whether a hysteresis loop is drawn")
    animations: bool = Field(default=False, description="whether shapes and loops are animated")
    steps: int = Field(
        default=0, ge=0, le=360, description="number of instants of the period at the peak"
    )
    report: bool = Field(default=True, description="whether the report is written")
    gauges: Annotated[tuple[GaugeKeys, ...], BeforeValidator(sequence)] = Field(
        default=(), max_length=100, description="strain gauges"
    )

    @field_validator("monitor")
    @classmethod
    def _named(cls, value: str | None) -> str | None:
        if value is not None and not re.fullmatch(MONITOR, value):
            former = re.sub(r"\baccessory\b", "output", value)
            renamed = f'accessory nodes are called output nodes now: "{former}"'
            raise ValueError(_MONITORED if former == value else renamed)
        return value


def _flat(value: object) -> object:
    """Accept `joints.interlock.mu = [...]` without quotes, which TOML nests."""
    return dict(leaves(value)) if isinstance(value, dict) else value


Lists = Annotated[
    dict[str, Annotated[tuple[Any, ...], BeforeValidator(sequence)]], BeforeValidator(_flat)
]
"""Values of dotted keys."""


class Study(KeyTable):
    """A study: one scene, and the keys that are swept over it."""

    name: str = Field(default="vane segment", min_length=1, max_length=200, description="name")
    accuracy: float | None = Field(
        default=None, ge=1e-4, lt=0.3, description="relative error of the largest response"
    )
    ring: RingKeys = RingKeys()
    vane: Vane = VaneDimensions()
    casing: Casing = CasingDimensions()
    material: MaterialKeys = MaterialKeys()
    temperature: Temperature = Temperature()
    loads: RestLoadKeys | None = Field(default=None, description="loads at rest")
    mesh: MeshKeys = MeshKeys()
    joints: Joints = Joints()
    rom: Rom = Rom()
    excitation: ExcitationKeys = ExcitationKeys()
    damping: Damping = Damping()
    response: ResponseKeys = ResponseKeys()
    sweep: Lists = Field(default_factory=dict, description="swept keys")
    rows: Lists = Field(default_factory=dict, description="keys that vary together")
    scatter: Scatter | None = Field(default=None, description="scattering keys")
    outputs: Outputs = Outputs()
    bounds: BoundsKeys | None = Field(default=None, description="bounds over static friction")
    stability: StabilityKeys | None = Field(default=None, description="stability")
    unlike: UnlikeKeys | None = Field(default=None, description="rings of unlike segments")
    campbell: CampbellKeys | None = Field(default=None, description="Campbell diagram")
    measured: Annotated[tuple[MeasuredCurve, ...], BeforeValidator(curves)] = Field(
        default=(), max_length=100, description="measured curves"
    )
    fit: Fit | None = Field(default=None, description="fit to the measured curves")
    optimise: Optimise | None = Field(default=None, description="joints whose peak is smallest")
    campaign: Campaign | None = Field(default=None, description="published study")

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints with contacts."""
        return ("hook", "interlock")[: 1 + self.joints.interlock.enabled]

    @property
    def stretch(self) -> int:
        """Of the casing's elements; by default 3, and 1 where no other is allowed."""
        if isinstance(self.casing, CasingDimensions):
            return checked_stretch(self.mesh.stretch, self.casing)
        return self.mesh.stretch or 1

    @property
    def patches(self) -> dict[str, str]:
        """What the contacts of each joint act on; by default areas, and nodes of own meshes."""
        vane, casing = isinstance(self.vane, OwnVane), isinstance(self.casing, OwnCasing)
        hook, interlock = self.joints.hook.patch, self.joints.interlock.patch
        return {
            "hook": hook or ("node" if vane or casing else "area"),
            "interlock": interlock or ("node" if vane else "area"),
        }

    def _is_sampled_enough(self) -> Iterator[str]:
        least = least_samples(self.response.harmonics, self.response.friction)
        if self.response.samples is not None and self.response.samples < least:
            harmonics = counted(self.response.harmonics, "harmonic")
            yield (
                f"response.samples = {self.response.samples}: number of samples must be >= {least} "
                f"for {harmonics} and {self.response.friction} friction"
            )

    def _has_the_output(self) -> Iterator[str]:
        """The program's own parts have three output nodes; others are checked on reading."""
        wanted = self.outputs.monitor
        found = re.fullmatch(MONITOR, wanted or "")
        if found is None:
            return
        part, _, number = found["node"].split()
        if not isinstance(getattr(self, part), OwnVane | OwnCasing) and int(number) > 3:
            yield f'outputs.monitor = "{wanted}": {_MONITORED}'

    def _has_the_aerofoils(self) -> Iterator[str]:
        if isinstance(self.vane, OwnVane):
            return
        for i, gauge in enumerate(self.outputs.gauges):
            if gauge.aerofoil > self.vane.aerofoils:
                yield (
                    f"outputs.gauges[{i}].aerofoil = {gauge.aerofoil}: a vane segment has "
                    f"aerofoils 1 to {self.vane.aerofoils}"
                )

    def _needs_error_estimates(self) -> Iterator[str]:
        """An accuracy needs an estimate of every error."""
        text = "" if self.accuracy is None else f"accuracy = {self.accuracy:g}"
        if text and self.rom.route != "cyclic":
            yield (
                f'{text}: rom.route = "{self.rom.route}" gives no estimate of what it leaves out; '
                'choose "cyclic"'
            )
        if text and self.response.harmonic_diameters != "wave":
            yield (
                f'{text}: response.harmonic_diameters = "{self.response.harmonic_diameters}" is '
                'not what a wave does; choose "wave"'
            )
        if text and self.response.direction != "up":
            yield (
                f'{text}: response.direction = "{self.response.direction}": leave it out, since '
                "the highest of the solutions in both directions is looked for anyway: of a range "
                "always, of listed frequencies where the sweep upwards jumps or loses a point"
            )

    def _has_points_to_choose(self) -> Iterator[str]:
        if self.accuracy is None or "points" not in self.response.model_fields_set:
            return
        if self.response.points is not None and self.response.points < 5:
            yield (
                f"accuracy = {self.accuracy:g}: response.points = {self.response.points}: "
                "needs at least 5"
            )

    def _can_be_meshed(self) -> None:
        vane = None if isinstance(self.vane, OwnVane) else self.vane
        casing = None if isinstance(self.casing, OwnCasing) else self.casing
        check_size(self.mesh.size, vane, casing, self.ring.sectors, self.vane.hook, self.stretch)

    checks: ClassVar[tuple[Check, ...]] = (
        _is_sampled_enough,
        _has_the_output,
        _has_the_aerofoils,
        _needs_error_estimates,
        _has_points_to_choose,
        can_be_assessed,
        *TEMPERATURE_CHECKS,
        *LOAD_CHECKS,
        *COMPARISON_CHECKS,
        *CAMPAIGN_CHECKS,
        *BAND_CHECKS,
        _can_be_meshed,
        *OWN_MESH_CHECKS,
    )
