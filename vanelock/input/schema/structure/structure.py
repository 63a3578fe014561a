"""Tables of the study file on the structure: ring, materials, meshes, joints, reduction."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, ConfigDict, Field, ValidationInfo, field_validator

from vanelock.common.checked import Check, Checked
from vanelock.common.quantities import (
    Bedding,
    Density,
    Frequency,
    Length,
    Pressure,
    Stiffness,
    Usual,
    Wear,
    quantity,
    si,
)
from vanelock.input.schema.structure.piecewise import ByTemperature
from vanelock.mesh.checks import FEWEST, MOST
from vanelock.mesh.element_size import LARGEST, SIZES, SMALLEST
from vanelock.mesh.element_size import MOST_STRETCH as STRETCH
from vanelock.mesh.refinement import MOST as LARGEST_MESHES


def _mesh_size(value: object) -> object:
    """Pass a named size; anything else is a length in metres, or one of each part."""
    if isinstance(value, str) and value in SIZES:
        return value
    if isinstance(value, list | tuple) and len(value) == 2:
        return tuple(_length(each) for each in value)
    return _length(value)


def _length(value: object) -> float:
    """A length in metres."""
    try:
        length = si(value, "m")
    except ValueError:
        length = None
    if isinstance(length, bool) or not isinstance(length, int | float):
        length = 0.0
    if not SMALLEST <= length <= LARGEST:
        names = ", ".join(f'"{name}"' for name in SIZES)
        raise ValueError(
            f"element size must be {names} or {SMALLEST * 1e3:g} mm to {LARGEST * 1e3:g} mm, "
            f"or [vane, casing], where that makes at most {LARGEST_MESHES:,} degrees of freedom"
        )
    return float(length)


MeshSize = Annotated[Any, BeforeValidator(_mesh_size)]


def sequence(value: object) -> object:
    """A list as the tuple that frozen tables hold."""
    return tuple(value) if isinstance(value, list) else value


def leaves(table: dict[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Dotted key and value of everything in nested tables."""
    found = []
    for key, value in table.items():
        dotted = f"{prefix}{key}"
        found += leaves(value, f"{dotted}.") if isinstance(value, dict) else [(dotted, value)]
    return found


class KeyTable(Checked):
    """A table of the study file: unknown keys and wrong types are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


STIFF, STRONG = Usual(1e9, 1.5e12), Usual(1e6, 2e10)
"""Moduli and strengths of solids, Pa: hard plastics to diamond."""
SPRING = Usual(1.0, 1e13)
"""Stiffness of a contact's node pair, N/m."""


class RingKeys(KeyTable):
    """The ring of vane segments."""

    sectors: int = Field(default=16, ge=FEWEST, le=MOST, description="number of sectors")


class Elastic(KeyTable):
    """An isotropic material; its strength is for the report alone."""

    E: Annotated[Pressure, STIFF] = Field(
        default=170e9, ge=1e3, le=1e15, description="Young's modulus [Pa]"
    )
    E_at: Annotated[ByTemperature, STIFF] | None = Field(
        default=None,
        min_length=2,
        max_length=1000,
        description="Young's modulus by temperature [Pa]",
    )
    expansion: Annotated[float, quantity("1/K"), Usual(1e-7, 5e-5)] | None = Field(
        default=None, gt=0, le=1e-3, description="thermal expansion [1/K]"
    )
    nu: float = Field(default=0.3, gt=-1, lt=0.5, description="Poisson's ratio")
    rho: Annotated[Density, Usual(50, 25e3)] = Field(
        default=8200.0, gt=0, le=1e6, description="density [kg/m^3]"
    )
    fatigue_limit: Annotated[Pressure, STRONG] = Field(
        default=250e6, ge=1e5, le=1e12, description="fatigue limit [Pa]"
    )
    tensile_strength: Annotated[Pressure, STRONG] = Field(
        default=900e6, ge=1e5, le=1e12, description="tensile strength [Pa]"
    )

    @field_validator("tensile_strength")
    @classmethod
    def _above_the_limit(cls, value: float, info: ValidationInfo) -> float:
        limit = info.data.get("fatigue_limit")
        if limit is not None and value < limit:
            raise ValueError(
                f"tensile strength must not be below fatigue_limit = {1e-6 * limit:g} MPa"
            )
        return value


class MaterialKeys(KeyTable):
    """Materials of the parts."""

    vane: Elastic = Elastic()
    casing: Elastic = Elastic()


class MeshKeys(KeyTable):
    """Finite-element meshes of both parts."""

    size: MeshSize = Field(default="medium", description="element size")
    face_nodes: int | None = Field(
        default=None, ge=10, le=100_000, description="number of nodes of each cyclic face"
    )
    stretch: int | None = Field(
        default=None,
        ge=1,
        le=STRETCH,
        description="length of the casing's elements around the ring",
    )
    correction: Literal["none", "modal"] = Field(
        default="modal", description="how mesh stiffening is corrected"
    )


Patch = Literal["node", "area"]
"""Whether a contact acts on its node or on the mean over its node's patch."""


def _one_of_each(joint: "_HookJoint | InterlockJoint") -> Iterator[str]:
    """Refuse a stiffness per pair beside the same one per area."""
    for name in ("kn", "kt"):
        value = getattr(joint, f"{name}_area")
        if value is not None and name in joint.model_fields_set:
            yield f"{name}_area = {value:g}: give either this or {name}, not both"


class _HookJoint(KeyTable):
    """Contacts between the vane's hooks and the casing's grooves, per node pair."""

    kn: Annotated[Stiffness, SPRING] = Field(
        default=1.67e7, gt=0, le=1e15, description="normal stiffness [N/m]"
    )
    kt: Annotated[Stiffness, SPRING] = Field(
        default=1.67e7, gt=0, le=1e15, description="tangential stiffness [N/m]"
    )
    kn_area: Annotated[Bedding, Usual(1e4, 1e19)] | None = Field(
        default=None, gt=0, le=1e20, description="normal stiffness per area [N/m^3]"
    )
    kt_area: Annotated[Bedding, Usual(1e4, 1e19)] | None = Field(
        default=None, gt=0, le=1e20, description="tangential stiffness per area [N/m^3]"
    )
    mu: float = Field(default=0.3, ge=0, le=1000, description="friction coefficient")
    interference: Length = Field(default=20e-6, gt=0, le=1e-3, description="interference [m]")
    wear_coefficient: Annotated[Wear, Usual(1e-20, 1e-9)] | None = Field(
        default=None, gt=0, le=1e-6, description="wear coefficient [m^2/N]"
    )
    patch: Patch | None = Field(default=None, description="what a contact acts on")

    checks: ClassVar[tuple[Check, ...]] = (_one_of_each,)


class InterlockJoint(KeyTable):
    """Contacts between neighbouring segments' inner shrouds, per node pair."""

    enabled: bool = Field(default=True, description="whether the interlock has contacts")
    kn: Annotated[Stiffness, SPRING] = Field(
        default=1e6, gt=0, le=1e15, description="normal stiffness [N/m]"
    )
    kt: Annotated[Stiffness, SPRING] = Field(
        default=1e6, gt=0, le=1e15, description="tangential stiffness [N/m]"
    )
    kn_area: Annotated[Bedding, Usual(1e4, 1e19)] | None = Field(
        default=None, gt=0, le=1e20, description="normal stiffness per area [N/m^3]"
    )
    kt_area: Annotated[Bedding, Usual(1e4, 1e19)] | None = Field(
        default=None, gt=0, le=1e20, description="tangential stiffness per area [N/m^3]"
    )
    mu: float = Field(default=0.3, ge=0, le=1000, description="friction coefficient")
    interference: Length = Field(default=2e-6, ge=-1e-3, le=1e-3, description="interference [m]")
    wear_coefficient: Annotated[Wear, Usual(1e-20, 1e-9)] | None = Field(
        default=None, gt=0, le=1e-6, description="wear coefficient [m^2/N]"
    )
    patch: Patch | None = Field(default=None, description="what a contact acts on")

    checks: ClassVar[tuple[Check, ...]] = (_one_of_each,)


class Joints(KeyTable):
    """The joints with friction contacts."""

    hook: _HookJoint = _HookJoint()
    interlock: InterlockJoint = InterlockJoint()


ACCURACY, MODES = 1e-4, 10
"""What the routes take unless the study says otherwise."""

Modes = Annotated[int | None, Field(ge=1, le=1000)]


class Rom(KeyTable):
    """Reduced-order model."""

    route: Literal["cyclic", "paper"] = Field(default="cyclic", description="route")
    accuracy: float | None = Field(
        default=None, ge=1e-9, lt=1, description="relative error of natural frequencies"
    )
    band: Annotated[Frequency, Field(gt=0)] | None = Field(
        default=None, description="frequency up to which the accuracy holds [Hz]"
    )
    vane_modes: Modes = Field(default=None, description="number of fixed-interface modes")
    casing_modes: Modes = Field(default=None, description="number of fixed-interface modes")

    def _belongs_to_the_route(self) -> Iterator[str]:
        """What the route would not heed is refused."""
        by_number = self.vane_modes is not None and self.casing_modes is not None
        by_number = by_number or self.route != "cyclic"
        for name in ("accuracy", "band"):
            if by_number and (value := getattr(self, name)) is not None:
                why = (
                    "vane_modes and casing_modes are given"
                    if self.route == "cyclic"
                    else f'rom.route = "{self.route}" takes numbers of modes'
                )
                yield f"{name} = {value:g}: {why}"

    checks: ClassVar[tuple[Check, ...]] = (_belongs_to_the_route,)

    def of(self, part: str) -> dict[str, int | float | None]:
        """How many vectors `rom.reduce` is asked for."""
        modes = {"vane": self.vane_modes, "casing": self.casing_modes}[part]
        if modes is not None:
            return {"modes": modes}
        if self.route != "cyclic":
            return {"modes": MODES}
        return {"accuracy": ACCURACY if self.accuracy is None else self.accuracy, "band": self.band}
