"""Match the meshes of a vane and a casing, one or both of them a user's, node to node.

Mates are found by place and moved to one common place, so that the later stages find them exact:
the user's node to the program's, the casing's to the vane's, a right one to its left one's image.
One meets one within a tolerance; where none does, a report says so.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from vanelock.common.arrays import Floats, Integers
from vanelock.common.cyclic import cylindrical, turn
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.mesh.files.read import read_mesh
from vanelock.mesh.geometry.contact_places import opposite
from vanelock.mesh.matching import side as contact
from vanelock.mesh.matching.side import HOOKS, INTERLOCKS, OwnPart, Side, check_cut_faces
from vanelock.mesh.part import Part, called

_Teller = Callable[[int], str]  # what errors call the i-th node of a set

_SHOWN = 5  # nodes in a report


def _mates(
    points: Floats,
    other: Floats,
    tolerance: float,
    sets: tuple[str, str],
    tellers: tuple[_Teller, _Teller],
    size: float = np.inf,
) -> tuple[Integers, list[str]]:
    """For each place of one set the node of the other set that lies there."""
    problems = []
    trees = cKDTree(points), cKDTree(other)
    to_other, nearest = trees[1].query(points)
    to_own, _ = trees[0].query(other)
    lost = [_far(to_other, tolerance, tellers[0]), _far(to_own, tolerance, tellers[1])]
    if any(count for count, _ in lost):
        first = 1 if lost[1][0] else 0  # the set whose nodes would be moved, first
        (count, listed), (back, furthest) = lost[first], lost[1 - first]
        total = len(points), len(other)
        line = (
            f"{sets[first]}: {count} of {total[first]} nodes {'is' if count == 1 else 'are'} "
            f"further than {_millimetres(tolerance)} from the nearest node of {sets[1 - first]}: "
            f"{', '.join([*listed, '...'] if count > _SHOWN else listed)}"
        )
        if back:
            line += f"; the other way round {back} of {total[1 - first]}, such as {furthest[0]}"
        if max(to_other.max(), to_own.max()) > size:
            line += ": is the unit right?"
        problems.append(line)
    if not problems:
        shared = np.flatnonzero(np.bincount(nearest, minlength=len(other)) > 1)
        if len(shared):
            own_two = np.flatnonzero(nearest == shared[0])[:2]
            both = " and ".join(tellers[0](int(i)) for i in own_two)
            problems.append(
                f"{sets[0]}: {both} both meet {tellers[1](int(shared[0]))} of {sets[1]}"
            )
        elif len(points) != len(other):
            alone = np.setdiff1d(np.arange(len(other)), nearest)[0]
            problems.append(
                f"{sets[1]}: {tellers[1](int(alone))} lies where another one meets {sets[0]}"
            )
    return np.asarray(nearest, np.int64), problems


def _far(distance: Floats, tolerance: float, teller: _Teller) -> tuple[int, list[str]]:
    """How many nodes have no mate, and a report on each one that may be shown, furthest first."""
    far = np.flatnonzero(~(distance <= tolerance))
    far = far[np.argsort(-distance[far], kind="stable")]
    return len(far), [f"{teller(int(i))} {_millimetres(distance[i])}" for i in far[:_SHOWN]]


def _millimetres(length: float) -> str:
    """A length for a report."""
    return f"{1e3 * length:.4g} mm"


TOLERANCE = 1e-5
"""How far mates may lie apart, m, unless the user says otherwise."""
_REVERSED = np.array([-1.0, 1.0, -1.0])[:, None]


@dataclass(frozen=True)
class Mates(Product):
    """A vane and a casing whose nodes meet.

    Attributes
    ----------
    vane, casing : Part
        Either part; one that the program made is as it was.
    """

    vane: Part
    casing: Part


def pair(
    vane: Part | OwnPart, casing: Part | OwnPart, sectors: int, tolerance: float = TOLERANCE
) -> Mates:
    """Match the hooks of both parts, their keys, the interlock and the cyclic faces.

    Parameters
    ----------
    vane, casing : Part or OwnPart
        A part that the program meshed, or a user's.
    sectors : int
        Sectors N in the ring.
    tolerance : float
        How far mates may lie apart, m.

    Returns
    -------
    Mates
        Parts as the later stages need them: sets in the order of their mates, mates at one place,
        cyclic faces exact, contact frames from the faces' geometry.

    Raises
    ------
    InputError
        One line for each set whose nodes do not match, with the nodes that have no mate and their
        distances, the largest first; or for each whose faces are not opposed, with the node and
        the angle. If nodes of the casing's cut faces are in neither set,
        or no node is clamped.
    """
    sides = {"vane": Side(vane, sectors), "casing": Side(casing, sectors)}
    problems = _held(sides["vane"], sides["casing"])
    for name in HOOKS:
        problems += _meet(sides["vane"], sides["casing"], name, tolerance)
    for side, left, right in ((sides["vane"], *INTERLOCKS), (sides["casing"], "left", "right")):
        if side.own and left in side.sets and right in side.sets:
            problems += _follow(side, left, right, tolerance)
    _refuse(problems)
    if sides["casing"].own:
        _refuse(check_cut_faces(sides["casing"], tolerance))
    _refuse(_keys(sides["vane"], sides["casing"]))
    for name in HOOKS:
        problems += _hook_frames(sides["vane"], sides["casing"], name)
    if sides["vane"].own and INTERLOCKS[0] in sides["vane"].sets:
        problems += _interlock_frames(sides["vane"])
    _refuse(problems)
    _order_keys(sides["vane"], sides["casing"])
    return Mates(sides["vane"].part(), sides["casing"].part())


def _refuse(problems: list[str]) -> None:
    if problems:
        raise InputError("\n".join(problems))


def _held(vane: Side, casing: Side) -> list[str]:
    """Refuse a ring without clamped nodes; the program's own casing has some."""
    original = casing.original
    clamped = any(len(side.sets.get("fixed", ())) for side in (vane, casing))
    if clamped or not isinstance(original, OwnPart):
        return []
    have = ", ".join(sorted(original.mesh.node_sets)) or "none"
    return [
        f"{casing.source}: no clamped nodes: name the set in [casing.sets] fixed = ...; the file "
        f"has {have}"
    ]


def _reference(vane: Side, casing: Side) -> tuple[Side, Side]:
    """The side whose nodes stay, and the one whose nodes are moved."""
    return (casing, vane) if vane.own and not casing.own else (vane, casing)


def _meet(vane: Side, casing: Side, name: str, tolerance: float) -> list[str]:
    """Put a hook's nodes of the moving side in the order of the other's, at their places."""
    stays, moves = _reference(vane, casing)
    if not moves.own:
        return []
    size = min(float(np.linalg.norm(np.ptp(side.points, axis=0))) for side in (stays, moves))
    where = f"{stays.source}, {name}"
    return _moved(stays, name, np.eye(3), where, moves, name, tolerance, size)


def _follow(side: Side, left: str, right: str, tolerance: float) -> list[str]:
    """Put a right face's nodes in the order of the left one's, at the places of their images."""
    where = f"{side.source}, {left} turned by 2π/{side.sectors}"
    return _moved(side, left, turn(side.sectors).T, where, side, right, tolerance)


def _moved(
    stays: Side,
    name: str,
    onto: Floats,
    where: str,
    moves: Side,
    mate: str,
    tolerance: float,
    size: float = np.inf,
) -> list[str]:
    """Put a set of the moving side in the order of the other's, where `onto` takes that."""
    own, other = stays.sets[name], moves.sets[mate]
    places = stays.points[own] @ onto
    found, problems = _mates(
        places,
        moves.points[other],
        tolerance,
        (where, f"{moves.source}, {mate}"),
        (lambda i: stays.describe(int(own[i])), lambda i: moves.describe(int(other[i]))),
        size,
    )
    if not problems:
        moves.sets[mate] = other[found]
        moves.points[moves.sets[mate]] = places
    return problems


def _keys(vane: Side, casing: Side) -> list[str]:
    """Put the keys of the moving side in the order of the other's, their mates at the hooks."""
    stays, moves = _reference(vane, casing)
    if not moves.own:
        return []
    mate = {
        int(a): int(b)
        for name in HOOKS
        for a, b in zip(stays.sets[name], moves.sets[name], strict=True)
    }
    wanted = np.array([mate[int(node)] for node in stays.sets["key"]], np.int64)
    problems = []
    if len(lost := np.setdiff1d(wanted, moves.sets["key"])):
        problems.append(
            f"{moves.source}, key: of its nodes that meet keys of {stays.source}, {len(lost)} "
            f"{'is' if len(lost) == 1 else 'are'} missing, such as {moves.describe(int(lost[0]))}"
        )
    if len(extra := np.setdiff1d(moves.sets["key"], wanted)):
        meet = "meets" if len(extra) == 1 else "meet"
        problems.append(
            f"{moves.source}, key: {len(extra)} of its nodes {meet} no key of {stays.source}, "
            f"such as {moves.describe(int(extra[0]))}"
        )
    moves.sets["key"] = wanted
    return problems


def _order_keys(vane: Side, casing: Side) -> None:
    """Put a user's keys in the order of the hooks' nodes."""
    if vane.own and casing.own:
        hooks = np.concatenate([vane.sets[name] for name in HOOKS])
        place = {int(node): i for i, node in enumerate(hooks)}
        order = np.argsort([place[int(node)] for node in vane.sets["key"]])
        vane.sets["key"], casing.sets["key"] = vane.sets["key"][order], casing.sets["key"][order]


def _hook_frames(vane: Side, casing: Side, name: str) -> list[str]:
    """Frames at a hook: the program's own where there are any, else from both parts' faces."""
    stays, moves = _reference(vane, casing)
    if not moves.own:
        return []
    known = stays.frames.get(name)
    own = stays.directions(name) if known is None else [f[:1] for f in known]
    other = moves.directions(name)
    normal, problems = _normals(own, other, moves, name, stays)
    if problems:
        return problems
    if known is None:
        radial, around = cylindrical(stays.of(name))[:, :2].swapaxes(0, 1)
        known = contact.frames(normal, around, radial)
        order = _by_band(stays.of(name), known[:, 0], radial)
        stays.sets[name], moves.sets[name] = stays.sets[name][order], moves.sets[name][order]
        known = stays.frames[name] = known[order]
    moves.frames[name] = _REVERSED * known
    return []


def _by_band(places: Floats, normal: Floats, radial: Floats) -> Integers:
    """Outer faces before inner ones, then by axial position, then by ascending angle."""
    inner = np.sum(normal * radial, axis=1) < 0
    angle = np.arctan2(places[:, 1], places[:, 0])
    return np.lexsort((angle, np.round(places[:, 2] / TOLERANCE), inner))


def _interlock_frames(side: Side) -> list[str]:
    """Frames of the interlock: the first tangent is radial, as at the middle of the left set."""
    left, right = INTERLOCKS
    order = _by_row(side.of(left))
    side.sets[left], side.sets[right] = side.sets[left][order], side.sets[right][order]
    back = turn(side.sectors)
    mate = [found @ back for found in side.directions(right)]  # turned to where the left one is
    normal, problems = _normals(side.directions(left), mate, side, right, side)
    if problems:
        return problems
    middle = side.of(left).mean(axis=0)[None].repeat(len(normal), axis=0)
    radial, around = cylindrical(middle)[:, :2].swapaxes(0, 1)
    side.frames[left] = contact.frames(normal, radial, around)
    side.frames[right] = opposite(side.frames[left], side.sectors)
    return []


def _by_row(places: Floats) -> Integers:
    """By radius in ten steps, then by axial position."""
    radius = np.hypot(places[:, 0], places[:, 1])
    step = max(float(np.ptp(radius)) / 10, TOLERANCE)
    return np.lexsort((places[:, 2], np.round((radius - radius.min()) / step)))


def _normals(
    directions: list[Floats], other: list[Floats], moves: Side, name: str, stays: Side
) -> tuple[Floats, list[str]]:
    """Normals (k, 3) that the nodes share with their mates, and what is wrong with them."""
    normal = np.zeros((len(directions), 3))
    off = np.zeros(len(directions))
    several = np.zeros(len(directions), bool)
    for i, (a, b) in enumerate(zip(directions, other, strict=True)):
        normal[i], off[i], several[i] = contact.opposed(a, b)
    problems = []
    where = f"{moves.source}, {name}"
    wrong = np.flatnonzero(off > contact.OPPOSED)
    if len(wrong):
        worst = wrong[np.argsort(-off[wrong], kind="stable")]
        listed = [f"{moves.describe(int(moves.sets[name][i]))} {off[i]:.1f}" for i in worst[:5]]
        more = ", ..." if len(worst) > 5 else ""
        mate = "its mates" if moves is stays else stays.source
        problems.append(
            f"{where}: at {len(wrong)} of {len(directions)} nodes the faces are not opposed "
            f"to those of {mate}, within {contact.OPPOSED:g} degrees: {', '.join(listed)}{more}"
        )
    elif several.any():
        node = moves.sets[name][int(np.flatnonzero(several)[0])]
        problems.append(
            f"{where}: at {several.sum()} nodes faces of several directions are opposed, such as "
            f"{moves.describe(int(node))}: give the set as faces"
        )
    return normal, problems


_KNOWN = ("fixed", "left", "right", "force", "output")


def read_sector(
    path: str | os.PathLike[str], sectors: int = 1, unit: str = "m", tolerance: float = TOLERANCE
) -> Part:
    """Read a part with all sets of its file, its cyclic faces matched.

    Parameters
    ----------
    path : path
        Of any format that `read_mesh` reads.
    sectors : int
        Sectors N in the ring, which need the sets `left` and `right`; 1 if the part is whole.
    unit : str
        Of its coordinates, such as "mm".
    tolerance : float
        How far a node of `right` may lie from its mate in `left` turned by 2π/N, m; it is then
        moved there.

    Returns
    -------
    Part
        Called like the file. Sets have the file's names, those that the later stages know also in
        lower case. Without contact frames.

    Raises
    ------
    InputError
        If the file cannot be used, a face or some of its nodes are missing, or the faces do
        not match.

    Examples
    --------
    Two-nodal-diameter modes of a ring of 16 such sectors::

        part = mesh.read_sector("sector.msh", sectors=16)
        modes = fem.modes(fem.assemble(part, fem.Material(E=210e9, nu=0.3, rho=7800)), 10, 2)
    """
    found = read_mesh(path, unit)
    sets = dict(found.node_sets)
    for name in _KNOWN:
        if (alike := called(found.node_sets, name)) is not None:
            sets[name] = found.node_sets[alike]
    side = Side(OwnPart(Path(path).stem, found, sets, {}), sectors)
    if sectors > 1:
        for name in ("left", "right"):
            if not len(sets.get(name, np.empty(0))):
                have = ", ".join(sorted(found.node_sets)) or "none"
                raise InputError(f"{found.source}: no set {name}; it has {have}")
        problems = _follow(side, "left", "right", tolerance)
        if problems := problems or check_cut_faces(side, tolerance):
            raise InputError("\n".join(problems))
    return side.part()
