"""Which node meets which: contact pairs of the vane's joints and their relative displacement."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.rom.masters import Masters
from vanelock.rom.system import Contacts

HOOK_SETS = ("hook_front", "hook_rear")
COINCIDENT = 1e-9
"""Largest distance of two nodes that meet, relative to their distance from the axis."""


@dataclass(frozen=True)
class Joint:
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


@dataclass(frozen=True)
class Pairs:
    """Node pairs in contact, hooks first.

    Attributes
    ----------
    vane : (c,) int
        The vane's node.
    mate : (c,) int
        The node it meets: the casing's, or the next vane's where `next`.
    next : (c,) bool
        Whether the mate belongs to the next sector.
    frames : (c, 3, 3) float
        Rows: the vane's outward normal and two tangents.
    joint : tuple of str
        Name of each pair's joint.
    contacts : Contacts
        Their properties.
    """

    vane: NDArray[np.int64]
    mate: NDArray[np.int64]
    next: NDArray[np.bool_]
    frames: NDArray[np.float64]
    contacts: Contacts


def contact_pairs(vane: Masters, casing: Masters, joints: Sequence[Joint]) -> Pairs:
    """Pair the nodes of the given joints.

    Raises
    ------
    InputError
        If a joint is unknown or given twice, sets are missing or of different lengths, nodes that
        should meet lie apart, or those of one side alone stand for their patches.
    """
    names = [joint.name for joint in joints]
    for name in names:
        if name not in ("hook", "interlock"):
            raise InputError(f'joint "{name}": allowed are "hook" and "interlock"')
        if names.count(name) > 1:
            raise InputError(f'joint "{name}" is given {names.count(name)} times')
    found = [
        (joint, *pairs)
        for joint in sorted(joints, key=lambda joint: joint.name)
        for pairs in (_hook(vane, casing) if joint.name == "hook" else _interlock(vane))
    ]
    count = [len(own) for _, own, *_ in found]

    def each(values: list[float]) -> NDArray[np.float64]:
        return np.repeat(np.asarray(values, float), count)

    contacts = Contacts(
        kn=_stiffness([(j.name, j.kn, j.kn_area, area) for j, *_, area in found], count),
        kt=np.column_stack(
            [_stiffness([(j.name, j.kt, j.kt_area, area) for j, *_, area in found], count)] * 2
        ),
        mu=each([joint.mu for joint, *_ in found]),
        v0=each([joint.interference for joint, *_ in found]),
        joint=tuple(np.repeat([joint.name for joint, *_ in found], count).tolist()),
        always_closed=("hook",),
    )
    none = np.empty(0, np.int64)
    return Pairs(
        vane=np.concatenate([none, *(own for _, own, *_ in found)]),
        mate=np.concatenate([none, *(mate for _, _, mate, *_ in found)]),
        next=np.repeat([joint.name == "interlock" for joint, *_ in found], count).astype(bool),
        frames=np.concatenate([np.empty((0, 3, 3)), *(frames for *_, frames, _ in found)]),
        contacts=contacts,
    )


Coordinates = Callable[[NDArray[np.int64]], NDArray[np.int64]]
NodePairs = tuple[
    NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64] | None
]
"""Both nodes of each pair, the own one's frame, and its area where that is known."""


def _stiffness(
    joints: list[tuple[str, float, float | None, NDArray[np.float64] | None]], count: list[int]
) -> NDArray[np.float64]:
    """(c,) stiffness of each pair, N/m: the joint's, or the one per area times its node's area."""
    parts = [np.empty(0)]
    for (name, each, per_area, area), pairs in zip(joints, count, strict=True):
        if per_area is None:
            parts.append(np.full(pairs, each))
        elif area is None:
            raise InputError(
                f'joint "{name}": a stiffness per area needs contact sets of the vane that consist '
                "of whole faces"
            )
        else:
            parts.append(per_area * area)
    return np.concatenate(parts)


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


def key_pairs(vane: Masters, casing: Masters) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Vane and casing nodes that are merged."""
    own, mate = vane.set("key"), casing.set("key")
    _act_alike("key", vane, own, casing, mate)
    _coincide("key", vane.position(own), casing.position(mate), mate)
    return own, mate


def _act_alike(
    name: str,
    part: Masters,
    own: NDArray[np.int64],
    other: Masters,
    mate: NDArray[np.int64],
) -> None:
    """Refuse means over patches on one side only, in words that tell why the pairs lie apart."""
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


def merged_dofs(
    vane_size: int, casing_size: int, vane_keys: NDArray[np.int64], casing_keys: NDArray[np.int64]
) -> NDArray[np.int64]:
    """(vane_size,) joined coordinate of each of the vane's, which follow the casing's.

    Parameters
    ----------
    vane_size, casing_size : int
        Numbers of coordinates of the two parts.
    vane_keys, casing_keys : (k,) int
        The vane's coordinates that are merged with the casing's.
    """
    joined = np.empty(vane_size, np.int64)
    free = np.setdiff1d(np.arange(vane_size), vane_keys)
    joined[free] = casing_size + np.arange(len(free))
    joined[vane_keys] = casing_keys
    return joined


def relative_rows(
    pairs: Pairs,
    of_vane: Coordinates,
    of_casing: Coordinates,
    size: int,
    sectors: int,
) -> tuple[sp.csr_array, sp.csr_array]:
    """Rows (normal, t1, t2) of every pair's relative displacement, closing positive.

    Parameters
    ----------
    pairs : Pairs
        c pairs.
    of_vane, of_casing : callable
        (k, 3) coordinates that are the Cartesian displacement of k nodes in their own sector.
    size : int
        Number of coordinates n.
    sectors : int
        N.

    Returns
    -------
    own, next : (3c, n) sparse
        Rows on this sector's coordinates and on the next one's.
    """
    other = ~pairs.next
    vane_dofs = of_vane(pairs.vane)
    mate_dofs = np.empty_like(vane_dofs)
    mate_dofs[pairs.next] = of_vane(pairs.mate[pairs.next])
    mate_dofs[other] = of_casing(pairs.mate[other])
    own = _rows(pairs.frames, vane_dofs, size) - _rows(
        pairs.frames * other[:, None, None], mate_dofs, size
    )
    turned = pairs.frames @ turn(sectors) * pairs.next[:, None, None]
    return own, -_rows(turned, mate_dofs, size)


def _rows(frames: NDArray[np.float64], dofs: NDArray[np.int64], size: int) -> sp.csr_array:
    """(3c, n) matrix with each 3x3 frame in the columns of its node."""
    rows = np.broadcast_to(np.arange(3 * len(frames)).reshape(-1, 3, 1), frames.shape)
    columns = np.broadcast_to(dofs[:, None, :], frames.shape)
    shape = (3 * len(frames), size)
    return sp.csr_array((frames.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
