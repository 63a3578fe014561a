"""Tables of the study file for a part that is the user's own mesh instead of dimensions."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, BeforeValidator, Discriminator, Field, Tag, model_validator

from vanelock.common.checked import DIMENSIONS, OWN, Check
from vanelock.common.errors import InputError, raised
from vanelock.common.quantities import is_whole
from vanelock.input.schema.structure.structure import PER_AREA, KeyTable
from vanelock.mesh import Part
from vanelock.mesh.files.read import metres
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.matching.side import HOOKS, INTERLOCKS


def _set(value: object) -> object:
    """A set's name in the file, or numbers of nodes."""
    if isinstance(value, str) and value:
        return value
    if isinstance(value, list | tuple) and value:
        if all(map(is_whole, value)):
            return tuple(value)
    raise ValueError(
        "expected the name of a set in the mesh file, or a list of the file's node numbers"
    )


def _unit(value: object) -> object:
    if not isinstance(value, str) or raised(lambda: metres(value)):
        raise ValueError('expected a unit of length, such as "mm"')
    return value


Unit = Annotated[str, BeforeValidator(_unit)]


VaneSet = Literal[
    "hook_front", "hook_rear", "key", "interlock_left", "interlock_right", "output", "fixed"
]
CasingSet = Literal["hook_front", "hook_rear", "key", "left", "right", "force", "output", "fixed"]
NodeSet = Annotated[Any, BeforeValidator(_set)]


class _OwnMesh(KeyTable):
    """A part's mesh from a file."""

    mesh: str = Field(min_length=1, max_length=4096, description="mesh file")
    unit: Unit = Field(default="m", description="unit of the mesh's coordinates")

    dimensions: ClassVar[type[BaseModel]]

    @model_validator(mode="before")
    @classmethod
    def _instead_of_dimensions(cls, data: Any) -> Any:
        if isinstance(data, dict):
            for key in cls.dimensions.model_fields:
                if key in data and key not in cls.model_fields:
                    raise ValueError(
                        f"{key} = {data[key]}: a mesh is given, so dimensions cannot be"
                    )
        return data


class OwnVane(_OwnMesh):
    """A vane segment from a file; its hook is the groove of a casing that has dimensions."""

    sets: dict[VaneSet, NodeSet] = Field(default={}, description="node set")
    hook: HookDimensions = HookDimensions()

    dimensions: ClassVar[type[BaseModel]] = VaneDimensions


class OwnCasing(_OwnMesh):
    """A casing sector from a file."""

    sets: dict[CasingSet, NodeSet] = Field(default={}, description="node set")

    dimensions: ClassVar[type[BaseModel]] = CasingDimensions


_OWN_KEYS = {*_OwnMesh.model_fields, "sets"}


def _kind(value: object) -> str:
    given = isinstance(value, dict) and not _OWN_KEYS.isdisjoint(value)
    return OWN if given or isinstance(value, _OwnMesh) else DIMENSIONS


Vane = Annotated[
    Annotated[VaneDimensions, Tag(DIMENSIONS)] | Annotated[OwnVane, Tag(OWN)], Discriminator(_kind)
]
Casing = Annotated[
    Annotated[CasingDimensions, Tag(DIMENSIONS)] | Annotated[OwnCasing, Tag(OWN)],
    Discriminator(_kind),
]


def _has_areas(study: Any) -> Iterator[str]:
    for joint in () if isinstance(study.vane, OwnVane) else study.joint_names:
        for name, value in getattr(study.joints, joint).per_area.items():
            yield (
                f"joints.{joint}.{name} = {value:g} {PER_AREA}: needs vane.mesh, whose contact "
                "sets consist of whole faces"
            )


def _has_the_dimensions(study: Any) -> Iterator[str]:
    """What needs the dimensions of a part that is given as a mesh."""
    vane, casing = isinstance(study.vane, OwnVane), isinstance(study.casing, OwnCasing)
    why = f"needs dimensions, while {'vane.mesh' if vane else 'casing.mesh'} is given"
    if vane and study.outputs.gauges:
        yield f"outputs.gauges: a gauge's place {why}"
    if (vane or casing) and study.joints.patch == "area":
        yield f'joints.patch = "area": {why}'
    if not (vane or casing) and study.mesh.tolerance is not None:
        yield f"mesh.tolerance = {study.mesh.tolerance:g}: needs vane.mesh or casing.mesh"
    if casing and study.mesh.face_nodes is not None:
        yield f"mesh.face_nodes = {study.mesh.face_nodes}: casing.mesh is given"
    if casing and study.stretch > 1:
        yield f"mesh.stretch = {study.stretch}: casing.mesh is given"
    if vane and casing and study.vane.hook != HookDimensions():
        yield "vane.hook: both parts are given as meshes, so it has no use"


OWN_MESH_CHECKS: tuple[Check, ...] = (_has_areas, _has_the_dimensions)
"""Of a `Study`."""


def refuse_without_areas(study: Any, vane: Part) -> None:
    """Refuse a stiffness per area of a `Study` where the vane's contact nodes have no areas."""
    for joint in study.joint_names:
        sets = HOOKS if joint == "hook" else INTERLOCKS
        lacking = [each for each in sets if each not in vane.areas]
        for name, value in getattr(study.joints, joint).per_area.items() if lacking else ():
            raise InputError(
                f"joints.{joint}.{name} = {value:g} {PER_AREA}: the vane's set {lacking[0]} does "
                "not consist of whole faces: give stiffnesses per node pair"
            )
