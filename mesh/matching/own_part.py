"""A user's mesh with the sets that the program knows, and what each of them must be."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.mesh.files.raw import FileMesh, distinct
from vanelock.mesh.part import called

Integers = NDArray[np.int64]

HOOKS = ("hook_front", "hook_rear")
INTERLOCKS = ("interlock_left", "interlock_right")
NEEDED: dict[str, tuple[str, ...]] = {
    "vane": (*HOOKS, "key", "output"),
    "casing": (*HOOKS, "key", "left", "right", "force", "output"),
}
"""Sets that a part must have; a vane whose interlock has contacts needs those, too."""
"""What files of earlier versions call a set."""
OPTIONAL: dict[str, tuple[str, ...]] = {"vane": (*INTERLOCKS, "fixed"), "casing": ("fixed",)}


@dataclass(frozen=True)
class OwnPart(Product):
    """A part's mesh from a file, whose sets have the program's names.

    Attributes
    ----------
    name : str
        "vane" or "casing".
    mesh : FileMesh
        The mesh.
    node_sets : dict of str to (k,) int
        The sets of `Part` that were found.
    face_sets : dict of str to (f, c) int
        Corner nodes of the faces of those that consist of faces.
    """

    name: str
    mesh: FileMesh
    node_sets: dict[str, Integers]
    face_sets: dict[str, Integers]

    def describe(self, node: int) -> str:
        """What errors call a node."""
        return f"node {self.mesh.numbers[node]}"


def own_part(
    mesh: FileMesh,
    name: str,
    sets: Mapping[str, str | Sequence[int]] | None = None,
    interlock: bool = True,
    loaded: Sequence[str] = (),
) -> OwnPart:
    """Find a part's sets in a mesh."""
    given = dict(sets or {})
    needed = NEEDED[name] + (INTERLOCKS if interlock and name == "vane" else ())
    node_sets, face_sets = {}, {}
    for each in (*needed, *OPTIONAL[name], *loaded):
        if each in node_sets:
            continue
        wanted = given.get(each, each)
        if isinstance(wanted, str):
            there = mesh.node_sets
            found = called(there, wanted)
            if found is None:
                if each in OPTIONAL[name] and each not in needed and each not in given:
                    continue
                have = ", ".join(sorted(mesh.node_sets)) or "none"
                raise InputError(f"{mesh.source}: no set {wanted} for {name}.{each}; it has {have}")
            if found in mesh.absent:
                strays = mesh.absent[found]
                raise InputError(
                    f"{mesh.source}: set {found}: {len(strays)} of its nodes belong to no solid "
                    f"element, such as {strays[0]}"
                )
            node_sets[each] = mesh.node_sets[found]
            if found in mesh.face_sets:
                face_sets[each] = mesh.face_sets[found]
        else:
            node_sets[each] = _listed(mesh, each, wanted)
        if not len(node_sets[each]):
            raise InputError(f"{mesh.source}: set {wanted} for {name}.{each}: it has no nodes")
    part = OwnPart(name, mesh, node_sets, face_sets)
    _check_key(part)
    _check_apart(part)
    return part


def _listed(mesh: FileMesh, name: str, numbers: Sequence[int]) -> Integers:
    wanted = distinct(np.array(list(numbers), np.int64))
    order = np.argsort(mesh.numbers)
    rank = np.searchsorted(mesh.numbers, wanted, sorter=order).clip(max=len(order) - 1)
    rows = order[rank]
    if np.any(absent := mesh.numbers[rows] != wanted):
        raise InputError(
            f"{mesh.source}: {name}: node {wanted[absent][0]} belongs to no solid element"
        )
    return np.asarray(rows)


def _check_key(part: OwnPart) -> None:
    hooks = np.concatenate([part.node_sets[name] for name in HOOKS])
    stray = np.setdiff1d(part.node_sets["key"], hooks)
    if len(stray):
        raise InputError(
            f"{part.mesh.source}: set key: {part.describe(stray[0])} belongs to neither hook: its "
            "nodes must be some of theirs"
        )


def _check_apart(part: OwnPart) -> None:
    """Refuse nodes whose displacement two sets would prescribe."""
    excluded = [("hook_front", "hook_rear"), ("left", "right"), INTERLOCKS]
    excluded += [(name, face) for name in HOOKS for face in ("left", "right", *INTERLOCKS)]
    excluded += [(name, face) for name in ("force", "output") for face in ("left", "right")]
    clamped = (*HOOKS, *INTERLOCKS, "force", "output")
    excluded += [("fixed", name) for name in clamped]
    for first, second in excluded:
        if first in part.node_sets and second in part.node_sets:
            both = np.intersect1d(part.node_sets[first], part.node_sets[second])
            if len(both):
                raise InputError(
                    f"{part.mesh.source}: {part.describe(both[0])} is in the sets {first} and "
                    f"{second}, which must not share nodes"
                )
