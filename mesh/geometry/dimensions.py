"""Dimensions of the vane segment and of the casing sector, with their defaults and limits.

Positions along the engine axis z are those of the front hook; the rear hook mirrors it about
`HookDimensions.mid_plane`. The defaults make a segment whose second one-nodal-diameter mode lies
at an engine's speed. Designs of 6 to 60 sectors and 1 to 8 aerofoils scaled to their spacing, whose
thicknesses, gaps and distances lie within 30 % of the defaults, are meshed or refused by name:
tests/verification/mesh/test_designs.py draws them.
"""

from collections.abc import Iterator
from itertools import pairwise
from operator import attrgetter
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from vanelock.common.checked import Check, Checked, explain
from vanelock.common.errors import InputError, cut_short
from vanelock.common.quantities import Angle, Length

CLEARANCE = 5e-4  # m; thinner walls and gaps are beyond any mesh


def _length(default: float, description: str, largest: float = 5.0) -> Any:
    return Field(default, ge=1e-4, le=largest, description=f"{description} [m]")


def _fillet(description: str) -> Any:
    return Field(0.0, ge=0, le=0.1, description=f"{description}, 0 for sharp corners [m]")


def _angle(default: float, largest: float, description: str) -> Any:
    return Field(default, ge=-largest, le=largest, description=f"{description} [deg]")


def _share(default: float, least: float, most: float, description: str) -> Any:
    return Field(default, ge=least, le=most, description=description)


def _resolvable(model: Any) -> Iterator[str]:
    """Refuse radii that only a mesh of many slivers could follow."""
    for name in ("fillet", "root_fillet"):
        radius = getattr(model, name, None) or 0.0
        if 0 < radius < CLEARANCE:
            yield f"{name} = {radius:g} m: must be 0 or at least {CLEARANCE:g} m"


def _count(default: int, least: int, description: str) -> Any:
    return Field(default, ge=least, le=201, description=description)


def _odd(value: int, what: str) -> int:
    """A number of nodes with one in the middle and an element's end at both ends."""
    if value % 2 == 0:
        raise ValueError(f"number of {what} must be odd")
    return value


def _ascending(model: BaseModel, *names: str) -> Iterator[str]:
    """Refuse lengths that do not grow along `names` by a wall's thickness; a dot reaches deeper."""
    for low, high in pairwise(names):
        below, above = attrgetter(low, high)(model)
        if below > above - CLEARANCE:
            yield (
                f"{high} = {above:g} m: must exceed {low} = {below:g} m by at least {CLEARANCE:g} m"
            )


class _Dimensions(Checked):
    """Frozen dimensions; unknown names are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    if not TYPE_CHECKING:

        def __init__(self, **values: Any) -> None:
            """Say in a line what is wrong; in a table within another, that is left to the outer."""
            try:
                super().__init__(**values)
            except ValidationError as error:
                lines = explain(error, values, type(self))
                raise InputError(cut_short("; ".join(lines))) from None

        __init__.__pydantic_base_init__ = True  # else it were called for tables within others


class HookDimensions(_Dimensions):
    """What a vane's foot and the casing's groove share: the radii and the bands they touch at."""

    roof_radius: Length = _length(0.592, "radius at which the foot touches the groove's roof")
    lip_radius: Length = _length(0.584, "radius at which the foot touches the groove's lip")
    band_position: Length = _length(0.074, "axial position of the front hook's contact bands")
    band_extent: float = _share(
        0.90, 0.1, 0.99, "length of a contact band as a fraction of the pitch"
    )
    band_nodes: int = _count(15, 3, "contact nodes along a band, an odd number")
    mid_plane: Length = _length(0.100, "axial position of the plane that mirrors the hooks")

    @field_validator("band_nodes")
    @classmethod
    def _has_a_middle(cls, value: int) -> int:
        return _odd(value, "contact nodes along a band")

    def _ordered(self) -> Iterator[str]:
        yield from _ascending(self, "lip_radius", "roof_radius")
        yield from _ascending(self, "band_position", "mid_plane")

    checks: ClassVar[tuple[Check, ...]] = (_ordered,)


class VaneDimensions(_Dimensions):
    """A vane segment: outer shroud with two hooks, aerofoils, inner shroud with interlocks."""

    aerofoils: int = Field(default=4, ge=1, le=12, description="aerofoils per segment")
    chord: Length = _length(0.047, "chord of an aerofoil", 0.5)
    thickness: Length = _length(0.0045, "thickness of an aerofoil at mid-chord", 0.1)
    edge_thickness: Length = _length(
        0.0022, "thickness of an aerofoil where its rounded edges begin", 0.1
    )
    camber: float = _share(0.12, 0, 0.4, "height of the camber line as a fraction of the chord")
    stagger: Angle = _angle(35.0, 70, "angle between the chord at mid-span and the engine axis")
    twist: Angle = _angle(
        0.0,
        40,
        "stagger at the outer shroud minus that at the inner one; straight lines join the two "
        "sections, so that the one at mid-span is cos(twist/2) of them",
    )
    lean: Angle = _angle(
        0.0,
        30,
        "angle of the aerofoils' stacking line against the radial direction, circumferentially, "
        "about mid-span",
    )
    inner_shroud_inner_radius: Length = _length(0.410, "inner radius of the inner shroud")
    inner_shroud_outer_radius: Length = _length(0.432, "outer radius of the inner shroud")
    inner_shroud_front: Length = _length(0.070, "axial position of the inner shroud's front face")
    interlock_slant: Angle = _angle(
        35.0, 60, "angle between the interlock faces and the engine axis"
    )
    interlock_nodes: int = _count(
        5, 3, "contact nodes along an interlock face's long edges, an odd number"
    )
    outer_shroud_inner_radius: Length = _length(0.567, "inner radius of the outer shroud")
    outer_shroud_outer_radius: Length = _length(0.573, "outer radius of the outer shroud")
    outer_shroud_front: Length = _length(0.060, "axial position of the outer shroud's front face")
    outer_shroud_extent: float = _share(
        0.96, 0.1, 0.999, "length of the outer shroud and its hooks as a fraction of the pitch"
    )
    foot_front: Length = _length(0.068, "axial position of the front foot's front face")
    leg_front: Length = _length(0.084, "axial position of the front leg's front face")
    leg_rear: Length = _length(0.0885, "axial position of the front leg's and foot's rear face")
    fillet: Length = _fillet("radius of the concave corners of the hooks: leg and foot")
    root_fillet: Length | None = Field(
        default=None,
        ge=0,
        le=0.1,
        description="radius of the fillets where aerofoils meet the shrouds, 0 for sharp corners "
        "[m]",
    )
    hook: HookDimensions = HookDimensions()

    @field_validator("interlock_nodes")
    @classmethod
    def _has_a_middle(cls, value: int) -> int:
        return _odd(value, "contact nodes along an interlock face's long edges")

    def _ordered(self) -> Iterator[str]:
        yield from _ascending(
            self,
            "inner_shroud_inner_radius",
            "inner_shroud_outer_radius",
            "outer_shroud_inner_radius",
            "outer_shroud_outer_radius",
            "hook.lip_radius",
            "hook.roof_radius",
        )
        yield from _ascending(
            self, "foot_front", "hook.band_position", "leg_front", "leg_rear", "hook.mid_plane"
        )
        yield from _ascending(self, "outer_shroud_front", "leg_front")
        yield from _ascending(self, "inner_shroud_front", "hook.mid_plane")

    def _holds_the_bands(self) -> Iterator[str]:
        if not self.hook.band_extent < self.outer_shroud_extent:
            yield (
                f"hook.band_extent = {self.hook.band_extent:g}: the bands must be shorter than the "
                f"foot, outer_shroud_extent = {self.outer_shroud_extent:g}"
            )

    def _has_sharper_edges(self) -> Iterator[str]:
        if self.edge_thickness > self.thickness:
            yield (
                f"edge_thickness = {self.edge_thickness:g}: must not exceed "
                f"thickness = {self.thickness:g}"
            )

    checks: ClassVar[tuple[Check, ...]] = (
        _resolvable,
        _ordered,
        _holds_the_bands,
        _has_sharper_edges,
    )


class CasingDimensions(_Dimensions):
    """A casing sector from z = 0: shell, two end flanges, two rails with C-shaped grooves."""

    length: Length = _length(0.200, "axial length of the casing")
    inner_radius: Length = _length(0.600, "inner radius of the shell")
    outer_radius: Length = _length(0.604, "outer radius of the shell")
    flange_radius: Length = _length(0.625, "outer radius of the end flanges")
    flange_thickness: Length = _length(0.010, "axial thickness of an end flange")
    rail_inner_radius: Length = _length(0.578, "inner radius of the rails")
    rail_front: Length = _length(0.058, "axial position of the front rail's front face")
    groove_bottom: Length = _length(0.066, "axial position of the bottom of the front groove")
    groove_mouth: Length = _length(0.082, "axial position of the mouth of the front groove")
    fillet: Length = _fillet("radius of the concave corners of the rails and their grooves")
    bosses: int = Field(
        default=0, ge=0, le=24, description="number of strut bosses on the shell of a sector"
    )
    boss_diameter: Length = _length(0.025, "diameter of a strut boss", 1.0)
    boss_height: Length = _length(0.010, "height of a strut boss outside the shell", 1.0)
    boss_position: Length = _length(0.035, "axial position of the strut bosses")
    force_nodes: int = _count(16, 1, "loaded nodes around the shell's outside")

    def _ordered(self) -> Iterator[str]:
        yield from _ascending(
            self, "rail_inner_radius", "inner_radius", "outer_radius", "flange_radius"
        )
        yield from _ascending(
            self, "flange_thickness", "rail_front", "groove_bottom", "groove_mouth", "length"
        )

    checks: ClassVar[tuple[Check, ...]] = (_resolvable, _ordered)
