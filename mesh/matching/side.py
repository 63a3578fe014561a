"""One part, a user's or the program's own, while it is matched to the other.

Its contact frames come from the faces around its nodes. A node on an edge belongs to faces of
several directions. Contact presses opposed faces together, so of all pairs of a node's and its
mate's normals the most opposed one counts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from vanelock.common.arrays import Floats, Integers
from vanelock.common.cyclic import cylindrical, turn
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.mesh.cells import exterior, nodal_areas, normals, solid
from vanelock.mesh.files.raw import FileMesh, distinct
from vanelock.mesh.part import Part, called

HOOKS = ("hook_front", "hook_rear")
INTERLOCKS = ("interlock_left", "interlock_right")
_NEEDED: dict[str, tuple[str, ...]] = {
    "vane": (*HOOKS, "key", "output"),
    "casing": (*HOOKS, "key", "left", "right", "force", "output"),
}
"""Sets that a part must have; a vane whose interlock has contacts needs those, too."""
_OPTIONAL: dict[str, tuple[str, ...]] = {"vane": (*INTERLOCKS, "fixed"), "casing": ("fixed",)}


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


def own_part(
    mesh: FileMesh,
    name: str,
    sets: Mapping[str, str | Sequence[int]] | None = None,
    interlock: bool = True,
    loaded: Sequence[str] = (),
) -> OwnPart:
    """Find a part's sets in a mesh."""
    given = dict(sets or {})
    needed = _NEEDED[name] + (INTERLOCKS if interlock and name == "vane" else ())
    node_sets, face_sets = {}, {}
    for each in (*needed, *_OPTIONAL[name], *loaded):
        if each in node_sets:
            continue
        wanted = given.get(each, each)
        if isinstance(wanted, str):
            there = mesh.node_sets
            found = called(there, wanted)
            if found is None:
                if each in _OPTIONAL[name] and each not in needed and each not in given:
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
            f"{part.mesh.source}: set key: node {part.mesh.numbers[stray[0]]} belongs to neither "
            "hook: its nodes must be some of theirs"
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
                    f"{part.mesh.source}: node {part.mesh.numbers[both[0]]} is in the sets {first} "
                    f"and {second}, which must not share nodes"
                )


_ALIKE = np.cos(np.radians(30.0))  # normals of one smooth surface, at one node
_ROUND = 2e-6  # of a radius, by which faces on a cylinder may miss it: six digits in a file
OPPOSED = 15.0  # degrees by which mates' faces may miss being parallel
_CLEAR = np.cos(np.radians(45.0))


def _candidates(points: Floats, faces: Integers, nodes: Integers) -> list[Floats]:
    """For each node the directions (c, 3) in which faces around it look.

    The normals of curved faces are taken at the node itself; those of about one direction are
    averaged by the faces' areas. Where their corners lie on a cylinder about the engine axis, as at
    a hook, its normal is taken instead, which flat elements would miss by half the angle they span.
    """
    around = faces[np.isin(faces, nodes).any(axis=1)]
    if not len(around):
        return [np.empty((0, 3)) for _ in nodes]
    normal, area = normals(points, around)
    corners = 3 if faces.shape[1] in (3, 6) else 4
    face, corner = np.nonzero(np.isin(around, nodes))
    order = np.argsort(around[face, corner], kind="stable")
    face, corner = face[order], corner[order]
    owner = around[face, corner]
    found = []
    for node in nodes:
        first, last = np.searchsorted(owner, [node, node + 1])
        own = face[first:last]
        weighted = normal[own, corner[first:last]] * area[own, None]
        radial = cylindrical(points[[node]])[0, 0]
        directions = []
        for mean, members in _directions(weighted):
            ends = points[around[own[members], :corners]].reshape(-1, 3)
            radii = np.hypot(ends[:, 0], ends[:, 1])
            if np.ptp(radii) < _ROUND * radii.max() and abs(mean @ radial) > _ALIKE:
                mean = np.sign(mean @ radial) * radial
            directions.append(mean)
        found.append(np.array(directions).reshape(-1, 3))
    return found


def _directions(weighted: Floats) -> list[tuple[Floats, list[int]]]:
    """Unit means of vectors (k, 3) grouped by direction, with the rows of each, longest first."""
    groups: list[tuple[Floats, list[int]]] = []
    length = np.linalg.norm(weighted, axis=1)
    for row in np.argsort(-length, kind="stable"):
        if not length[row] > 0:
            continue
        for i, (mean, members) in enumerate(groups):
            if mean @ weighted[row] > _ALIKE * length[row] * np.linalg.norm(mean):
                groups[i] = mean + weighted[row], [*members, int(row)]
                break
        else:
            groups.append((weighted[row], [int(row)]))
    return [(mean / np.linalg.norm(mean), members) for mean, members in groups]


def opposed(directions: Floats, other: Floats) -> tuple[Floats, float, bool]:
    """The normal that two nodes in contact share, from the directions of their faces."""
    if not len(directions) or not len(other):
        return np.zeros(3), 180.0, False
    cosine = (-directions @ other.T).clip(-1, 1)
    a, b = np.unravel_index(cosine.argmax(), cosine.shape)
    normal = directions[a] - other[b]
    normal /= max(float(np.linalg.norm(normal)), 1e-300)
    several = (cosine > np.cos(np.radians(OPPOSED))) & (directions @ normal < _CLEAR)[:, None]
    return normal, float(np.degrees(np.arccos(cosine[a, b]))), bool(several.any())


def frames(normal: Floats, tangent: Floats, instead: Floats) -> Floats:
    """Frames (k, 3, 3): the normals, a first tangent, and their cross product."""
    along = np.abs(np.sum(normal * tangent, axis=1)) > _CLEAR
    first = np.where(along[:, None], instead, tangent)
    first = first - np.sum(first * normal, axis=1, keepdims=True) * normal
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([normal, first, np.cross(normal, first)], axis=1)


class Side:
    """One part while it is matched: points are moved to their mates, sets put in their order.

    `own` says whether it is a user's; the program's own part stays as it is.
    """

    def __init__(self, original: Part | OwnPart, sectors: int) -> None:
        self.original, self.sectors = original, sectors
        self.own = isinstance(original, OwnPart)
        mesh: Part | FileMesh
        if isinstance(original, OwnPart):
            mesh, numbers, frames = original.mesh, original.mesh.numbers, {}
            self.source = f"{original.name} ({original.mesh.source})"  # what errors call it
        else:
            mesh, numbers, frames = original, np.arange(len(original.points)), original.frames
            self.source = original.name
        self.numbers, self.points = numbers, mesh.points.copy()
        self.cells, self.cell_type = mesh.cells, mesh.cell_type
        self.sets, self.frames = dict(original.node_sets), dict(frames)

    def describe(self, node: int) -> str:
        """What errors call a node."""
        return f"node {self.numbers[node]}"

    def of(self, name: str) -> Floats:
        """Places of a set's nodes."""
        return self.points[self.sets[name]]

    def directions(self, name: str) -> list[Floats]:
        """Directions in which the faces around a set's nodes look; of given faces alone."""
        return _candidates(self.points, self._faces(name), self.sets[name])

    def _faces(self, name: str) -> Integers:
        """Faces on the outside, of a set that was given as faces only its own."""
        faces = exterior(self.cells, solid(self.cell_type))
        if isinstance(self.original, OwnPart) and name in self.original.face_sets:
            corners = self.original.face_sets[name]
            wanted = {tuple(row) for row in np.sort(corners, axis=1).tolist()}
            rows = np.sort(faces[:, : corners.shape[1]], axis=1).tolist()
            faces = faces[[tuple(row) in wanted for row in rows]]
        return faces

    def _areas(self) -> dict[str, Floats]:
        """Areas of the nodes of the contact sets that consist of whole faces."""
        found = {}
        for name, frames in self.frames.items():
            area = nodal_areas(self.points, self._faces(name), self.sets[name], frames[:, 0])
            if area is not None:
                found[name] = area
        return found

    def part(self) -> Part:
        """The part as the later stages need it."""
        if isinstance(self.original, Part):
            return self.original
        return Part(
            self.original.name,
            self.points,
            self.cells,
            self.cell_type,
            self.sets,
            self.frames,
            self.sectors,
            areas=self._areas(),
        )


def check_cut_faces(side: Side, tolerance: float) -> list[str]:
    """Refuse cut faces of which nodes are not listed, or of whose mates one alone is clamped.

    Nodes left out would be a gap in the ring, which later stages would take for a free edge.
    """
    left, right = side.sets["left"], side.sets["right"]
    problems = []
    fixed = side.sets.get("fixed", np.empty(0, np.int64))
    own, mate = _unlisted(side, tolerance)
    both = np.isin(own, fixed) & np.isin(mate, fixed)  # clamped mates move as one in any case
    own, mate = own[~both], mate[~both]
    if len(own):
        count = (
            "1 node of either face is" if len(own) == 1 else f"{len(own)} nodes of either face are"
        )
        problems.append(
            f"{side.source}, left and right: {count} missing, such "
            f"as {side.describe(int(own[0]))}, which meets {side.describe(int(mate[0]))} when "
            f"turned by 2π/{side.sectors}: all nodes of the cut faces are needed"
        )
    alone = np.flatnonzero(np.isin(left, fixed) != np.isin(right, fixed))
    if len(alone):
        pair = [int(left[alone[0]]), int(right[alone[0]])]
        held, free = pair if pair[0] in fixed else pair[::-1]
        problems.append(
            f"{side.source}, fixed: at {len(alone)} of {len(left)} pairs of the cut faces one node "
            f"is clamped and its mate is not, such as {side.describe(held)} and its mate "
            f"{side.describe(free)}: clamp both or neither"
        )
    return problems


def _unlisted(side: Side, tolerance: float) -> tuple[Integers, Integers]:
    """Nodes on the outside that meet another one a sector further, both on neither face's list."""
    outside = np.unique(exterior(side.cells, solid(side.cell_type)))
    outside = np.setdiff1d(outside, np.concatenate([side.sets["left"], side.sets["right"]]))
    places = side.points[outside]
    none = np.empty(0, np.int64)
    if not len(outside):
        return none, none
    distance, nearest = cKDTree(places).query(places @ turn(side.sectors).T)
    own, mate = outside, outside[nearest]
    # A node on the axis meets itself, and in a ring of two either node of a pair meets the other.
    meet = (distance <= tolerance) & (own < mate if side.sectors == 2 else own != mate)
    return own[meet], mate[meet]
