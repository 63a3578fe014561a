"""Which node of a vane meets which: the pairs of its joints, and those that the key merges."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.common.arguments import OfKind
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.rom.joining.elements import Tie, Touching
from vanelock.rom.masters import Masters

HOOK_SETS = ("hook_front", "hook_rear")
COINCIDENT = 1e-9
"""Largest distance of two nodes that meet, relative to their distance from the axis."""


@dataclass(frozen=True)
class Joint(OfKind):
    """Contact properties of a joint, the same at each of its node pairs.

    Attributes
    ----------
    name : str
        "hook" (vane to casing) or "interlock" (vane to the next vane).
    kn, kt : float
        Normal and tangential stiffness of a node pair, N/m.
    mu : float
        Friction coefficient.
    interference : float
        Overlap of the unloaded parts at a pair, m; negative: a gap.
    kn_area, kt_area : float, optional
        Stiffnesses per area, N/m³, instead: of a pair, that times the area of the vane's node.
    """

    name: str
    kn: float
    kt: float
    mu: float
    interference: float
    kn_area: float | None = None
    kt_area: float | None = None


def contact_pairs(vane: Masters, casing: Masters, joints: Sequence[Joint]) -> list[Touching]:
    """Pair the nodes of the given joints: of "vane" and "casing", or the next sector's "vane"."""
    names = [joint.name for joint in joints]
    for name in names:
        if name not in ("hook", "interlock"):
            raise InputError(f'joint "{name}": allowed are "hook" and "interlock"')
        if names.count(name) > 1:
            raise InputError(f'joint "{name}" is given {names.count(name)} times')
    return [
        _touching(joint, *pairs)
        for joint in sorted(joints, key=lambda joint: joint.name)
        for pairs in (_hook(vane, casing) if joint.name == "hook" else _interlock(vane))
    ]


NodePairs = tuple[
    NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64] | None
]
"""Both nodes of each pair, the own one's frame, and its area where that is known."""


def _touching(
    joint: Joint,
    own: NDArray[np.int64],
    mate: NDArray[np.int64],
    frames: NDArray[np.float64],
    area: NDArray[np.float64] | None,
) -> Touching:
    around, same = joint.name == "interlock", np.ones(len(own))
    kn = _stiffness(joint.name, joint.kn, joint.kn_area, area, len(own))
    kt = _stiffness(joint.name, joint.kt, joint.kt_area, area, len(own))
    return Touching(
        name=joint.name,
        own="vane",
        mate="vane" if around else "casing",
        own_nodes=own,
        mate_nodes=mate,
        frames=frames,
        kn=kn,
        kt=np.column_stack([kt, kt]),
        mu=joint.mu * same,
        interference=joint.interference * same,
        next_sector=around,
    )


def _stiffness(
    name: str, each: float, per_area: float | None, area: NDArray[np.float64] | None, count: int
) -> NDArray[np.float64]:
    """(c,) stiffness of each pair, N/m: the joint's, or the one per area times its node's area."""
    if per_area is None:
        return np.full(count, float(each))
    if area is None:
        raise InputError(
            f'joint "{name}": a stiffness per area needs contact sets of the vane that consist '
            "of whole faces"
        )
    return per_area * area


def _hook(vane: Masters, casing: Masters) -> list[NodePairs]:
    """Both hooks' pairs; the key nodes are merged and carry no contact."""
    pairs = []
    for name in HOOK_SETS:
        own, mate = vane.set(name), casing.set(name)
        _act_alike(name, vane, own, casing, mate)
        _coincide(name, vane.position(own), casing.position(mate), mate)
        contact = ~np.isin(own, vane.node_sets.get("key", ()))
        area = vane.areas.get(name)
        pairs.append(
            (
                own[contact],
                mate[contact],
                vane.frames[name][contact],
                None if area is None else area[contact],
            )
        )
    return pairs


def _interlock(vane: Masters) -> list[NodePairs]:
    """The right face on the left face of the next sector's vane."""
    own, mate = vane.set("interlock_right"), vane.set("interlock_left")
    _act_alike("interlock_right", vane, own, vane, mate)
    _coincide(
        "interlock_right", vane.position(own), vane.position(mate) @ turn(vane.sectors).T, mate
    )
    return [(own, mate, vane.frames["interlock_right"], vane.areas.get("interlock_right"))]


def key_tie(vane: Masters, casing: Masters) -> Tie:
    """Nodes of vane and casing that are merged."""
    own, mate = vane.set("key"), casing.set("key")
    _act_alike("key", vane, own, casing, mate)
    _coincide("key", vane.position(own), casing.position(mate), mate)
    return Tie("key", "vane", "casing", own, mate)


def _act_alike(
    name: str,
    part: Masters,
    own: NDArray[np.int64],
    other: Masters,
    mate: NDArray[np.int64],
) -> None:
    """Refuse means over patches on one side only, in words that say why the pairs lie apart."""
    means, mates = np.isin(own, part.averaged), np.isin(mate, other.averaged)
    if len(means) == len(mates) and np.any(means != mates):
        raise InputError(
            f"{name}: a patch on one side and a node on the other: average both sets of a joint, "
            "or neither"
        )


def _coincide(
    name: str,
    own: NDArray[np.float64],
    mate: NDArray[np.float64],
    mate_nodes: NDArray[np.int64],
) -> None:
    if len(own) != len(mate):
        raise InputError(f"{name}: {len(own)} nodes on one part and {len(mate)} on the other")
    distance = np.linalg.norm(own - mate, axis=1)
    radius = np.hypot(own[:, 0], own[:, 1]).max(initial=1e-300)
    if np.any(distance > COINCIDENT * radius):
        worst = int(np.argmax(distance))
        raise InputError(
            f"{name}: pair {worst} (mate node {mate_nodes[worst]}) lies "
            f"{distance[worst]:.3g} m apart"
        )
