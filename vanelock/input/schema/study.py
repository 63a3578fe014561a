"""The study file's schema: every key, its unit, its default and what it may be.

Field descriptions are the subjects of error messages ("friction coefficient must be >= 0").
"""

import re
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from vanelock.common.checked import Check
from vanelock.common.tables import counted
from vanelock.input.schema.comparison import (
    COMPARISON_CHECKS,
    CampbellKeys,
    Fit,
    MeasuredCurve,
    Optimise,
    curves,
)
from vanelock.input.schema.distributions import Scatter
from vanelock.input.schema.outputs import MONITOR, MONITORED, Outputs
from vanelock.input.schema.response import Damping, ExcitationKeys, ResponseKeys
from vanelock.input.schema.structure.loads import LOAD_CHECKS, RestLoadKeys
from vanelock.input.schema.structure.own_mesh import (
    OWN_MESH_CHECKS,
    Casing,
    OwnCasing,
    OwnVane,
    Vane,
)
from vanelock.input.schema.structure.structure import (
    Joints,
    KeyTable,
    Listed,
    MaterialKeys,
    MeshKeys,
    RingKeys,
    Rom,
    flat,
)
from vanelock.input.schema.structure.temperature import TEMPERATURE_CHECKS, Temperature
from vanelock.mesh import CasingDimensions, VaneDimensions
from vanelock.mesh.element_size import checked_stretch
from vanelock.mesh.refinement import check_size
from vanelock.nonlinear.contact.sampling import least_samples

Lists = Annotated[dict[str, Listed[Any]], BeforeValidator(flat)]
"""Values of dotted keys."""


class Study(KeyTable):
    """A study: one scene, and the keys that are swept over it."""

    name: str = Field(default="vane segment", min_length=1, max_length=200, description="name")
    accuracy: float | None = Field(
        default=None, ge=1e-4, lt=0.3, description="relative error of the largest response"
    )
    seed: int = Field(default=1, ge=0, le=2**31 - 1, description="seed of random numbers")
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
    campbell: CampbellKeys | None = Field(default=None, description="Campbell diagram")
    measured: Annotated[tuple[MeasuredCurve, ...], BeforeValidator(curves)] = Field(
        default=(), max_length=100, description="measured curves"
    )
    fit: Fit | None = Field(default=None, description="fit to the measured curves")
    optimise: Optimise | None = Field(default=None, description="joints whose peak is smallest")

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints with contacts."""
        return ("hook", "interlock")[: 2 if self.joints.interlock else 1]

    @property
    def wear_coefficients(self) -> dict[str, float]:
        """Of the joints that wear, m²/N."""
        known = {name: getattr(self.joints, name).wear_coefficient for name in self.joint_names}
        return {name: k for name, k in known.items() if k is not None}

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
        return {
            "hook": self.joints.patch or ("node" if vane or casing else "area"),
            "interlock": self.joints.patch or ("node" if vane else "area"),
        }

    def _is_sampled_enough(self) -> Iterator[str]:
        samples, least = self.response.samples, least_samples(self.response.harmonics)
        shown = f"response.samples = {samples}"
        if samples is not None and self.response.friction == "isotropic":
            yield f"{shown}: isotropic friction has its events located: leave it out"
        elif samples is not None and samples < least:
            harmonics = counted(self.response.harmonics, "harmonic")
            yield f"{shown}: number of samples must be >= {least} for {harmonics}"

    def _has_the_output(self) -> Iterator[str]:
        """The program's own parts have three output nodes; others are checked on reading."""
        wanted = self.outputs.monitor
        found = re.fullmatch(MONITOR, wanted or "")
        if found is None:
            return
        part, _, number = found["node"].split()
        if not isinstance(getattr(self, part), OwnVane | OwnCasing) and int(number) > 3:
            yield f'outputs.monitor = "{wanted}": {MONITORED}'

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
        *TEMPERATURE_CHECKS,
        *LOAD_CHECKS,
        *COMPARISON_CHECKS,
        _can_be_meshed,
        *OWN_MESH_CHECKS,
    )
