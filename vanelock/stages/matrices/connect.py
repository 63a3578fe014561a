"""Join components to a `System`: ties merge coordinates, contacts, loads and outputs are rows.

The joined coordinates are those of all components in turn, tied ones once. With T the 0-1 matrix
from joined to all coordinates,

    K = Tᵀ diag(K_1, K_2, ...) T,    B = [B_1 B_2 ...] T,    f = Tᵀ (f_1, f_2, ...).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from vanelock.common.cyclic import COMPONENTS, turn
from vanelock.common.errors import InputError
from vanelock.rom import Contacts, Diameter, Force, System
from vanelock.rom.system import common_band
from vanelock.stages.matrices.piece import Matrix, Piece

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Touching:
    """Contact elements of one name.

    Attributes
    ----------
    name : str
        Of the contacts.
    own, mate : str
        Components; an empty mate is ground.
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


@dataclass(frozen=True)
class Tie:
    """Nodes of two components that move as one, in every direction that both have."""

    name: str
    own: str
    mate: str
    own_nodes: Integers
    mate_nodes: Integers


@dataclass(frozen=True)
class Pull:
    """A force on nodes: `vector` (3,) complex, N, on each of them at a harmonic."""

    where: str
    component: str
    nodes: Integers
    vector: NDArray[np.complex128]
    harmonic: int = 1


@dataclass(frozen=True)
class Joined:
    """What a scene joins.

    Attributes
    ----------
    sectors, engine_order : int
        N and EO.
    cylindrical : bool
        Whether directions 0 to 2 are radial, circumferential, axial.
    pieces : sequence of Piece
        Components.
    contacts, ties, loads : sequences
        What acts on them.
    outputs : sequence of (component, nodes)
        Output nodes.
    damping_ratio : float, optional
        Modal damping ratio, contacts stuck.
    """

    sectors: int
    engine_order: int
    cylindrical: bool
    pieces: Sequence[Piece]
    contacts: Sequence[Touching] = ()
    ties: Sequence[Tie] = ()
    loads: Sequence[Pull] = ()
    outputs: Sequence[tuple[str, Integers]] = ()
    damping_ratio: float | None = None
    _by_name: Mapping[str, Piece] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_by_name", {piece.name: piece for piece in self.pieces})

    def system(self, nodal_diameters: Sequence[int]) -> System:
        """The system with matrices of nodal diameters.

        Raises
        ------
        InputError
            If a component, node or nodal diameter is missing, or coordinates of outputs are not
            known.
        """
        T = self._merging()
        own, following = self._contact_rows(T)
        self._refuse_still(own, following)
        names, output = self._outputs(T)
        beyond = np.any(following)
        return System(
            sectors=self.sectors,
            engine_order=self.engine_order,
            diameters={
                k: Diameter(
                    K=self._joined("K", k, T),
                    M=self._joined("M", k, T),
                    own=own,
                    next=following if beyond else None,
                    output=output if len(names) else None,
                    C=self._joined("C", k, T) if self._damped(k) else None,
                )
                for k in nodal_diameters
            },
            contacts=self._properties(),
            force=self._forces(T),
            output_names=names,
            damping_ratio=self.damping_ratio,
            band=common_band(piece.band for piece in self.pieces),
        )

    def component(self, name: str, where: str) -> Piece:
        """A component by name.

        Raises
        ------
        InputError
            If there is none; `where` is who asks.
        """
        if name not in self._by_name:
            have = ", ".join(self._by_name)
            raise InputError(f'{where}: no component "{name}"; there are {have}')
        return self._by_name[name]

    def _coordinates(self, name: str, nodes: Integers, where: str, directions: int = 3) -> Integers:
        """(k, 3 or 6) places of nodes among all components' coordinates in turn, -1 for none."""
        piece, start = self.component(name, where), 0
        for each in self.pieces:
            if each is piece:
                break
            start += each.size
        at = piece.coordinates(nodes, where, directions)
        return np.where(at < 0, -1, at + start)

    def _merging(self) -> sp.csr_array:
        """T, (coordinates of all components, joined ones)."""
        total = sum(piece.size for piece in self.pieces)
        links = [np.empty((0, 2), np.int64)]
        for tie in self.ties:
            where = f"ties.{tie.name}"
            a = self._coordinates(tie.own, tie.own_nodes, where, 6).ravel()
            b = self._coordinates(tie.mate, tie.mate_nodes, where, 6).ravel()
            links.append(np.column_stack([a, b])[(a >= 0) & (b >= 0)])
        i, j = np.concatenate(links).T
        graph = sp.csr_array((np.ones(len(i)), (i, j)), shape=(total, total))
        place = connected_components(graph, directed=False)[1]
        order = np.unique(place, return_index=True)[1]  # joined coordinates in order of appearance
        rank = np.empty(len(order), np.int64)
        rank[np.argsort(order)] = np.arange(len(order))
        ones = np.ones(total)
        return sp.csr_array((ones, (np.arange(total), rank[place])), shape=(total, len(order)))

    def _damped(self, k: int) -> bool:
        return any(piece.at(k).C is not None for piece in self.pieces)

    def _joined(self, which: str, k: int, T: sp.csr_array) -> Matrix:
        """Tᵀ diag(...) T of the matrices K, M or C."""
        blocks = [piece.at(k) for piece in self.pieces]
        given = [getattr(block, which) for block in blocks]
        every = [np.zeros_like(b.K) if g is None else g for b, g in zip(blocks, given, strict=True)]
        return np.asarray(T.T @ sl.block_diag(*every) @ T)

    def _contact_rows(self, T: sp.csr_array) -> tuple[Floats, Floats]:
        """(c, 3, n) rows on this sector's coordinates and on the next one's."""
        total = T.shape[0]
        own, following = [np.empty((0, 3, total))], [np.empty((0, 3, total))]
        around = np.eye(3) if self.cylindrical else turn(self.sectors)
        for each in self.contacts:
            where = f"contacts.{each.name}"
            here, there = (np.zeros((len(each.own_nodes), 3, total)) for _ in range(2))
            _scatter(here, each.frames, self._coordinates(each.own, each.own_nodes, where))
            if each.mate:
                at = self._coordinates(each.mate, each.mate_nodes, where)
                frames = each.frames @ around if each.next_sector else each.frames
                _scatter(there if each.next_sector else here, -frames, at)
            own.append(here)
            following.append(there)
        return _merged(np.concatenate(own), T), _merged(np.concatenate(following), T)

    def _refuse_still(self, own: Floats, following: Floats) -> None:
        """A contact between nodes that cannot move against each other is none."""
        moves = np.any(own != 0, axis=(1, 2)) | np.any(following != 0, axis=(1, 2))
        start = 0
        for each in self.contacts:
            still = ~moves[start : start + len(each.own_nodes)]
            start += len(still)
            if still.any():
                a, b = each.own_nodes[still][0], each.mate_nodes[still][0]
                told = f"nodes {a} and {b} are one" if each.mate else f"node {a} is held"
                raise InputError(
                    f"contacts.{each.name}: {told}: nothing moves there (a pair of itself, or of "
                    "nodes that a tie merges?)"
                )

    def _properties(self) -> Contacts:
        each = self.contacts
        none = np.empty(0)
        return Contacts(
            kn=np.concatenate([none, *(c.kn for c in each)]),
            kt=np.concatenate([np.empty((0, 2)), *(c.kt for c in each)]),
            mu=np.concatenate([none, *(c.mu for c in each)]),
            v0=np.concatenate([none, *(c.interference for c in each)]),
            joint=tuple(c.name for c in each for _ in c.own_nodes),
        )

    def _forces(self, T: sp.csr_array) -> dict[int, Force]:
        found: dict[int, NDArray[np.complex128]] = {}
        for load in self.loads:
            vector = found.setdefault(load.harmonic, np.zeros(T.shape[0], complex))
            places = self._coordinates(load.component, load.nodes, load.where)
            for node, at in zip(load.nodes, places, strict=True):
                if np.any(lost := (at < 0) & (np.abs(load.vector) > 0)):
                    raise InputError(
                        f"{load.where}.direction: node {node} of components.{load.component} has "
                        f"no {self._word(int(lost.argmax()))} displacement among its rows"
                    )
                vector[at[at >= 0]] += load.vector[at >= 0]
        return {harmonic: Force(T.T @ vector) for harmonic, vector in sorted(found.items())}

    def _word(self, direction: int) -> str:
        return (COMPONENTS if self.cylindrical else "xyz")[direction]

    def _outputs(self, T: sp.csr_array) -> tuple[tuple[str, ...], Floats]:
        names, rows = [], [np.empty((0, 3, T.shape[0]))]
        for name, nodes in self.outputs:
            where = f"outputs.nodes.{name}"
            at = self._coordinates(name, nodes, where)
            frames = np.tile(np.eye(3), (len(nodes), 1, 1))
            if self.sectors > 1 and not self.cylindrical:
                frames = self.component(name, where).frames(nodes, where)
            found = np.zeros((len(nodes), 3, T.shape[0]))
            _scatter(found, frames, at)
            rows.append(found)
            names += [f"{name} {node}" for node in nodes]
        return tuple(names), _merged(np.concatenate(rows), T)


def _scatter(rows: Floats, frames: Floats, at: Integers) -> None:
    """Add frames (c, 3, 3) to the columns of each node; what does not move is left out."""
    for row, frame, places in zip(rows, frames, at, strict=True):
        row[:, places[places >= 0]] += frame[:, places >= 0]


def _merged(rows: Floats, T: sp.csr_array) -> Floats:
    """Rows (c, 3, ...) over the joined coordinates."""
    flat = rows.reshape(-1, T.shape[0]) @ T
    return np.asarray(flat).reshape(-1, 3, T.shape[1])
