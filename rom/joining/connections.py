"""What joins and loads parts: contacts, ties, forces, and the nodes whose motion is asked for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from vanelock.common.arrays import Array, Complex, Floats, Integers
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.rom.component import Masters
from vanelock.rom.system.element import Element
from vanelock.rom.system.system import Contacts


class Joinable(Protocol):
    """A part with matrices by nodal diameter and coordinates that nodes name."""

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        ...

    @property
    def reach(self) -> float | None:
        """Frequency up to which it answers, Hz; None where that is not known."""
        ...

    @property
    def rest_loads(self) -> Mapping[str, Any]:
        """(r,) of each load at rest that it holds by name, N, at nodal diameter 0."""
        ...

    def at(self, nodal_diameter: int) -> Any:
        """K and M of a nodal diameter, (r, r), and C where it has one."""
        ...

    def coordinates(self, nodes: Integers, where: str, directions: int = 3) -> Integers:
        """(k, 3) coordinates of the displacements of nodes, -1 where one does not move.

        With six `directions`, (k, 6): the rotations behind them.
        """
        ...

    def frames(self, nodes: Integers, where: str) -> Floats:
        """(k, 3, 3) turn from Cartesian components to each node's cylindrical ones."""
        ...


@dataclass(frozen=True)
class Touching:
    """Contact elements of one name."""

    name: str  # of the contacts
    own_part: str  # parts; an empty mate is ground
    mate: str
    own_nodes: Integers  # (c,), nodes that meet; `mate_nodes` counts for nothing at ground
    mate_nodes: Integers
    frames: Floats  # (c, 3, 3), rows: the outward normal of `own_part`, and two tangents
    kn: Floats  # (c,), N/m
    kt: Floats  # (c, 2), N/m
    mu: Floats  # (c,)
    interference: Floats
    next_sector: bool = False  # whether the mate belongs to the next sector of the ring
    element: Element | None = None
    """The law that each of them follows along the normal, where they are no contacts."""

    @property
    def where(self) -> str:
        """What messages call them."""
        return f"{'contacts' if self.element is None else 'elements'}.{self.name}"


@dataclass(frozen=True)
class Tie:
    """Nodes of two parts that move as one, in every direction that both have."""

    name: str
    own_part: str
    mate: str
    own_nodes: Integers
    mate_nodes: Integers


@dataclass(frozen=True)
class Load:
    """Forces on nodes at a harmonic.

    Attributes
    ----------
    where : str
        Who asks, in messages.
    part : str
        Whose nodes.
    nodes : (k,) int
        The nodes.
    vector : (3,) or (k, 3) complex
        On each of them, N (N s² for an unbalance).
    harmonic : int
        0: a static load.
    omega_power : int
        See `Force`; the same for all loads of a harmonic.
    engine_order : int, optional
        That it is of, where its vectors go with one.
    reduced : (r,) complex, optional
        The same on the part's coordinates, N, where the nodes are none of these.
    """

    where: str
    part: str
    nodes: Integers
    vector: Complex
    harmonic: int = 1
    omega_power: int = 0
    engine_order: int | None = None
    reduced: Complex | None = None


@dataclass(frozen=True)
class Output:
    """Nodes whose displacements are answers; in cylindrical components if `turned`.

    `reduced`, (k, 3, r), are they by the part's coordinates, where the nodes are none of these.
    """

    where: str
    part: str
    nodes: Integers
    names: Sequence[str]
    turned: bool
    reduced: Floats | None = None


def properties(contacts: Sequence[Touching], always_closed: tuple[str, ...] = ()) -> Contacts:
    """Stiffness, friction and interference of contacts, all in one."""
    none = np.empty(0)
    laws = [each.element for each in contacts for _ in each.own_nodes]
    return Contacts(
        kn=np.concatenate([none, *(each.kn for each in contacts)]),
        kt=np.concatenate([np.empty((0, 2)), *(each.kt for each in contacts)]),
        mu=np.concatenate([none, *(each.mu for each in contacts)]),
        v0=np.concatenate([none, *(each.interference for each in contacts)]),
        joint=tuple(each.name for each in contacts for _ in each.own_nodes),
        always_closed=always_closed,
        elements={i: law for i, law in enumerate(laws) if law is not None},
    )


_COINCIDENT = 1e-9
"""Largest distance of two nodes that meet, relative to their distance from the axis."""


class HasMasters(Protocol):
    """A part with nodes that others can reach, such as a `Component`."""

    @property
    def masters(self) -> Masters:
        """These nodes."""
        ...


def contact_pairs(
    name: str,
    part: HasMasters,
    node_set: str,
    mate: HasMasters,
    mate_set: str,
    *,
    kn: float,
    kt: float,
    mu: float,
    interference: float = 0.0,
    kn_area: float | None = None,
    kt_area: float | None = None,
    next_sector: bool = False,
    tied: str = "",
) -> Touching:
    """Contact elements between two node sets that lie on one another.

    Parameters
    ----------
    name : str
        Of the joint.
    part, mate : Component
        The parts; the normal is that of the first one.
    node_set, mate_set : str
        Their nodes, in the order in which they meet.
    kn, kt : float
        Normal and tangential stiffness of a node pair, N/m.
    mu : float
        Friction coefficient.
    interference : float
        Overlap of the unloaded parts at a pair, m; negative: a gap.
    kn_area, kt_area : float, optional
        Stiffnesses per area, N/m³, instead: of a pair, that times the area of the part's node.
    next_sector : bool
        Whether the mate belongs to the next sector of the ring.
    tied : str
        A set of the part whose nodes are tied, and carry no contact.

    Raises
    ------
    InputError
        If the sets differ in number, do not lie on one another, or have no areas.
    """
    one, other = part.masters, mate.masters
    own, meets = _meeting(one, node_set, other, mate_set, next_sector)
    touches = ~np.isin(own, one.set(tied) if tied else ())
    area = one.areas.get(node_set)
    count = int(touches.sum())

    def stiffness(value: float, per_area: float | None) -> Floats:
        if per_area is None:
            return np.full(count, float(value))
        if area is None:
            raise InputError(
                f'joint "{name}": a stiffness per area needs contact sets of the {one.part} that '
                "consist of whole faces"
            )
        return np.asarray(per_area * area[touches])

    tangential = stiffness(kt, kt_area)
    return Touching(
        name=name,
        own_part=one.part,
        mate=other.part,
        own_nodes=own[touches],
        mate_nodes=meets[touches],
        frames=one.frames[node_set][touches],
        kn=stiffness(kn, kn_area),
        kt=np.column_stack([tangential, tangential]),
        mu=np.full(count, float(mu)),
        interference=np.full(count, float(interference)),
        next_sector=next_sector,
    )


def tied_nodes(part: HasMasters, node_set: str, mate: HasMasters, mate_set: str) -> Tie:
    """Nodes of two parts that lie on one another and are merged; raises as `contact_pairs`."""
    one, other = part.masters, mate.masters
    own, meets = _meeting(one, node_set, other, mate_set)
    return Tie(node_set, one.part, other.part, own, meets)


def travelling_load(
    part: HasMasters, node_set: str, engine_order: int, force: float = 0.0, unbalance: float = 0.0
) -> Load:
    """First harmonic of a radial load that travels around the ring, F e_r(θ) e^{-i EO θ}.

    Parameters
    ----------
    part, node_set
        The nodes that it acts on.
    engine_order : int
        EO; negative: a backward wave.
    force : float
        Amplitude at each node, N.
    unbalance : float
        Or a rotating unbalance of the shaft, kg m, whose force U ω² all these nodes of the ring
        share as a pressure that varies with the cosine of the angle; excites EO ±1.

    Raises
    ------
    InputError
        If both are given, or an unbalance of another engine order.
    """
    masters = part.masters
    nodes, amplitude, power = masters.set(node_set), force, 0
    if unbalance:
        if force:
            raise InputError("excitation: give force or unbalance, not both")
        if abs(engine_order) != 1:
            raise InputError(
                f"excitation.unbalance: excites engine order 1 or -1, not {engine_order}"
            )
        # Σ over the ring of a cos²θ = U ω², θ the angle from the load's direction.
        amplitude, power = 2 * unbalance / (masters.sectors * len(nodes)), 2
    points = masters.position(nodes)
    theta = np.arctan2(points[:, 1], points[:, 0])
    radial = np.column_stack([np.cos(theta), np.sin(theta), np.zeros(len(nodes))])
    wave = np.exp(-1j * engine_order * theta)[:, None]
    vector = np.asarray(amplitude * radial * wave, complex)
    return Load("excitation", masters.part, nodes, vector, 1, power, engine_order)


def output_nodes(part: HasMasters, node_set: str = "output") -> Output:
    """Nodes of a set as answers, in (radial, circumferential, axial) components."""
    name, nodes = part.masters.part, part.masters.set(node_set)
    names = [f"{name} {node_set} {i + 1}" for i in range(len(nodes))]
    return Output("outputs", name, nodes, names, turned=True)


def _meeting(
    one: Masters, node_set: str, other: Masters, mate_set: str, next_sector: bool = False
) -> tuple[Integers, Integers]:
    """Nodes of two sets that lie on one another, in their order."""
    own, meets = one.set(node_set), other.set(mate_set)
    _act_alike(node_set, one, own, other, meets)
    places = other.position(meets) @ turn(one.sectors).T if next_sector else other.position(meets)
    _coincide(node_set, one.position(own), places, meets)
    return own, meets


def _act_alike(name: str, part: Masters, nodes: Integers, other: Masters, mate: Integers) -> None:
    """Refuse means over patches on one side only, in words that say why the pairs lie apart."""
    means, mates = np.isin(nodes, part.averaged), np.isin(mate, other.averaged)
    if len(means) == len(mates) and np.any(means != mates):
        raise InputError(
            f"{name}: a patch on one side and a node on the other: average both sets of a joint, "
            "or neither"
        )


def _coincide(name: str, points: Floats, mate: Floats, mate_nodes: Array) -> None:
    if len(points) != len(mate):
        raise InputError(f"{name}: {len(points)} nodes on one part and {len(mate)} on the other")
    distance = np.linalg.norm(points - mate, axis=1)
    radius = np.hypot(points[:, 0], points[:, 1]).max(initial=1e-300)
    if np.any(distance > _COINCIDENT * radius):
        worst = int(np.argmax(distance))
        raise InputError(
            f"{name}: pair {worst} (mate node {mate_nodes[worst]}) lies "
            f"{distance[worst]:.3g} m apart"
        )
