"""Tables of the study file on the structure: ring, materials, meshes, joints, reduction."""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, TypeVar

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    field_validator,
)

from vanelock.common.checked import OTHER, PLAIN, Check, Checked
from vanelock.common.quantities import (
    Density,
    Length,
    Pressure,
    Usual,
    Wear,
    number_within,
    quantity,
    si,
)
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
    names = ", ".join(f'"{name}"' for name in SIZES)
    needed = (
        f"element size must be {names} or {SMALLEST * 1e3:g} mm to {LARGEST * 1e3:g} mm, "
        f"or [vane, casing], where that makes at most {LARGEST_MESHES:,} degrees of freedom"
    )
    return number_within(value, "m", SMALLEST, LARGEST, needed)


MeshSize = Annotated[Any, BeforeValidator(_mesh_size)]


def sequence(value: object) -> object:
    """A list as the tuple that frozen tables hold."""
    return tuple(value) if isinstance(value, list) else value


T = TypeVar("T")
Listed = Annotated[tuple[T, ...], BeforeValidator(sequence)]
"""A list of values of one kind."""


def ascending(value: tuple[float, ...] | None) -> tuple[float, ...] | None:
    """Both ends of a range, refused where the second is not above the first."""
    if value is not None and value[0] >= value[1]:
        raise ValueError("must be [low, high] with low < high")
    return value


def leaves(
    table: dict[str, Any],
    prefix: str = "",
    nests: Callable[[Any], bool] = lambda value: isinstance(value, dict),
) -> list[tuple[str, Any]]:
    """Dotted key and value of everything in nested tables; `nests`: whether a value is one."""
    found = []
    for key, value in table.items():
        dotted = f"{prefix}{key}"
        found += leaves(value, f"{dotted}.", nests) if nests(value) else [(dotted, value)]
    return found


def flat(value: object) -> object:
    """Accept keys such as `joints.interlock.mu` without quotes, which TOML nests."""
    return dict(leaves(value)) if isinstance(value, dict) else value


class KeyTable(Checked):
    """A table of the study file: unknown keys and wrong types are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


def _tuples(value: object) -> object:
    if isinstance(value, list | tuple):
        return tuple(map(sequence, value))
    return value


def _ascending_pairs(value: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    for (a, _), (b, _) in pairwise(value):
        if a >= b:
            raise ValueError(f"{a:g} and {b:g}: the first number of each pair must ascend")
    return value


_Degrees = Annotated[float, Field(ge=-273.15, le=5000, description="temperature [degC]")]
_Modulus = Annotated[Pressure, Field(ge=1e3, le=1e15, description="Young's modulus [Pa]")]
_ByTemperature = Annotated[
    tuple[tuple[_Degrees, _Modulus], ...],
    BeforeValidator(_tuples),
    AfterValidator(_ascending_pairs),
    Field(min_length=2, max_length=1000),
]
"""E = [[20, "200 GPa"], [600, "165 GPa"]]: ((degC, Pa), ...), with straight lines between them."""


def at(pairs: Sequence[tuple[float, float]], x: float) -> float:
    """Value on the line through the pairs; outside of them that of the nearest."""
    return float(np.interp(x, *np.transpose(pairs)))


def ends(pairs: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """First and last place."""
    return float(pairs[0][0]), float(pairs[-1][0])


STIFF, STRONG = Usual(1e9, 1.5e12), Usual(1e6, 2e10)
"""Moduli and strengths of solids, Pa: hard plastics to diamond."""
SPRING = Usual(1.0, 1e13)
"""Stiffness of a contact's node pair, N/m."""


class RingKeys(KeyTable):
    """The ring of vane segments."""

    sectors: int = Field(default=16, ge=FEWEST, le=MOST, description="number of sectors")


class _Elastic(KeyTable):
    """An isotropic material; its strength is for the report alone."""

    E: Annotated[
        Annotated[_Modulus, Tag(PLAIN)] | Annotated[_ByTemperature, Tag(OTHER)],
        Discriminator(lambda value: OTHER if isinstance(value, list | tuple) else PLAIN),
        STIFF,
    ] = Field(default=170e9, description="Young's modulus [Pa]")
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

    @property
    def moduli(self) -> tuple[tuple[float, float], ...]:
        """Young's modulus by temperature, (degC, Pa), where it is given so."""
        return self.E if isinstance(self.E, tuple) else ()

    def modulus(self, temperature: float) -> float:
        """Young's modulus, Pa, at a temperature, degC."""
        return at(self.E, temperature) if isinstance(self.E, tuple) else self.E

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

    vane: _Elastic = _Elastic()
    casing: _Elastic = _Elastic()


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
    tolerance: Length | None = Field(
        default=None, gt=0, le=1e-3, description="largest distance between mates [m]"
    )


PER_AREA = "N/m^3"
STIFFEST_AREA = 1e20
"""Largest stiffness per area, N/m³."""


def _stiffness(value: object) -> object:
    """A number in N/m, or text in N/m³, which a stiffness per area stays."""
    try:
        per_area = si(value, PER_AREA) if isinstance(value, str) else None
    except ValueError:
        per_area = None
    if not isinstance(per_area, float):
        return si(value, "N/m")
    if not 0 < per_area <= STIFFEST_AREA:
        raise ValueError(f"stiffness per area must be > 0 and <= {STIFFEST_AREA:g} {PER_AREA}")
    return f"{per_area:.12g} {PER_AREA}"


PairStiffness = Annotated[
    Annotated[float, SPRING, Field(gt=0, le=1e15), Tag(PLAIN)] | Annotated[str, Tag(OTHER)],
    Discriminator(lambda value: OTHER if isinstance(value, str) else PLAIN),
    BeforeValidator(_stiffness),
]
"""Stiffness of a node pair, N/m; or text, of the area of its node, N/m³."""


class _HookJoint(KeyTable):
    """Contacts between the vane's hooks and the casing's grooves."""

    kn: PairStiffness = Field(default=1.67e7, description="normal stiffness [N/m]")
    kt: PairStiffness = Field(default=1.67e7, description="tangential stiffness [N/m]")
    mu: float = Field(default=0.3, ge=0, le=1000, description="friction coefficient")
    interference: Length = Field(default=20e-6, gt=0, le=1e-3, description="interference [m]")
    wear_coefficient: Annotated[Wear, Usual(1e-20, 1e-9)] | None = Field(
        default=None, gt=0, le=1e-6, description="wear coefficient [m^2/N]"
    )

    @property
    def per_area(self) -> dict[str, float]:
        """Stiffnesses that are of the area of a pair's node, N/m³."""
        stiffness = {"kn": self.kn, "kt": self.kt}
        return {
            name: float(value.removesuffix(PER_AREA))
            for name, value in stiffness.items()
            if isinstance(value, str)
        }

    @property
    def contact(self) -> dict[str, float]:
        """Its numbers as `rom.contact_pairs` takes them."""
        numbers = self.model_dump(exclude={"wear_coefficient"})
        for name, value in self.per_area.items():
            numbers |= {name: 0.0, f"{name}_area": value}
        return numbers


class _InterlockJoint(_HookJoint):
    """Contacts between neighbouring segments' inner shrouds."""

    kn: PairStiffness = Field(default=1e6, description="normal stiffness [N/m]")
    kt: PairStiffness = Field(default=1e6, description="tangential stiffness [N/m]")
    interference: Length = Field(default=2e-6, ge=-1e-3, le=1e-3, description="interference [m]")


def _touching(value: object) -> object:
    """The table of a joint; true is that of its defaults, false none."""
    if not isinstance(value, bool | dict | _InterlockJoint):
        raise ValueError("expected a table, or false: the inner shrouds do not touch")
    return {} if value is True else value


class Joints(KeyTable):
    """The joints with friction contacts."""

    patch: Literal["node", "area"] | None = Field(
        default=None, description="what a contact acts on"
    )
    hook: _HookJoint = _HookJoint()
    interlock: Annotated[
        Annotated[_InterlockJoint, Tag(OTHER)] | Annotated[Literal[False], Tag(PLAIN)],
        Discriminator(lambda value: PLAIN if value is False else OTHER),
        BeforeValidator(_touching),
    ] = Field(default=_InterlockJoint(), description="whether the inner shrouds touch")


ACCURACY, MODES = 1e-4, 10
"""What the routes take unless the study says otherwise."""

Count = Annotated[int, Field(ge=1, le=1000, description="number of fixed-interface modes")]
Modes = Annotated[
    Annotated[Count, Tag(PLAIN)] | Annotated[tuple[Count, Count], Tag(OTHER)],
    Discriminator(lambda value: OTHER if isinstance(value, tuple) else PLAIN),
    BeforeValidator(sequence),
]


class Rom(KeyTable):
    """Reduced-order model."""

    route: Literal["cyclic", "paper"] = Field(default="cyclic", description="route")
    accuracy: float | None = Field(
        default=None, ge=1e-9, lt=1, description="relative error of natural frequencies"
    )
    modes: Modes | None = Field(default=None, description="number of fixed-interface modes")

    def _belongs_to_the_route(self) -> Iterator[str]:
        """What the route would not heed is refused."""
        if self.accuracy is not None and (self.modes is not None or self.route != "cyclic"):
            paper = f'rom.route = "{self.route}" takes numbers of modes'
            yield f"accuracy = {self.accuracy:g}: {'modes is given' if self.modes else paper}"

    checks: ClassVar[tuple[Check, ...]] = (_belongs_to_the_route,)

    def of(self, part: str) -> dict[str, int | float]:
        """How many vectors `rom.reduce` is asked for."""
        modes = MODES if self.modes is None and self.route != "cyclic" else self.modes
        if modes is not None:
            return {"modes": modes if isinstance(modes, int) else modes[part == "casing"]}
        return {"accuracy": ACCURACY if self.accuracy is None else self.accuracy}
