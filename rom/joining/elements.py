"""What joins and loads parts: contacts, ties, forces, and the nodes whose motion is asked for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from vanelock.common.arrays import Complex, Floats, Integers
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
    """Contact elements of one name.

    Attributes
    ----------
    name : str
        Of the contacts.
    own, mate : str
        Parts; an empty mate is ground.
    own_nodes, mate_nodes : (c,) int
        Nodes that meet; `mate_nodes` counts for nothing at ground.
    frames : (c, 3, 3) float
        Rows: the outward normal of `own`, and two tangents.
    kn, mu, interference : (c,) float
        N/m, -, m.
    kt : (c, 2) float
        N/m.
    next_sector : bool
        Whether the mate belongs to the next sector of the ring.
    element : Element, optional
        The law that each of them follows along the normal, where they are no contacts.
    """

    name: str
    own: str
    mate: str
    own_nodes: Integers
    mate_nodes: Integers
    frames: Floats
    kn: Floats
    kt: Floats
    mu: Floats
    interference: Floats
    next_sector: bool = False
    element: Element | None = None

    @property
    def where(self) -> str:
        """What messages call them."""
        return f"{'contacts' if self.element is None else 'elements'}.{self.name}"


@dataclass(frozen=True)
class Tie:
    """Nodes of two parts that move as one, in every direction that both have."""

    name: str
    own: str
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
