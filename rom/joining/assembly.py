"""Join parts to a `System`: ties merge coordinates; contacts, loads and outputs are rows.

The coordinates of several parts are one set, in which those that ties join are there once. With
S_p the 0-1 matrix from the joined coordinates to those of part p,

    K = Σ_p S_pᵀ K_p S_p.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from vanelock.common.arrays import Complex, Floats, Integers
from vanelock.common.cyclic import COMPONENTS, turn
from vanelock.common.errors import InputError
from vanelock.rom.joining.connections import Joinable, Load, Output, Tie, Touching, properties
from vanelock.rom.system.element import spring_along
from vanelock.rom.system.system import Contacts, Diameter, Force, Matrix, System, common_band


@dataclass(frozen=True)
class _Merged:
    """Joined coordinates."""

    places: tuple[Integers, ...]  # by part: the joined coordinate of each of its own
    size: int  # number of joined coordinates n

    def of(self, part: int, coordinates: Integers) -> Integers:
        """Joined coordinates of some of a part's; -1, what does not move, stays -1."""
        return np.where(coordinates < 0, -1, self.places[part][coordinates])

    def sum(self, matrices: Sequence[Any]) -> Any:
        """(n, n) Σ S_pᵀ A_p S_p of one matrix A_p a part, dense or sparse."""
        return sum(S.T @ A @ S for S, A in zip(self._selections, matrices, strict=True))

    @cached_property
    def _selections(self) -> list[sp.csr_array]:
        """(n_p, n) S_p of each part."""
        found = []
        for place in self.places:
            each = np.ones(len(place)), (np.arange(len(place)), place)
            found.append(sp.csr_array(each, shape=(len(place), self.size)))
        return found

    def rows(self, frames: Floats, coordinates: Integers) -> sp.csr_array:
        """(3c, n) matrix with each 3x3 frame in the joined `coordinates` (c, 3) of its node."""
        rows = np.broadcast_to(np.arange(3 * len(frames)).reshape(-1, 3, 1), frames.shape)
        columns = np.broadcast_to(coordinates[:, None, :], frames.shape)
        moves = columns >= 0
        shape = (3 * len(frames), self.size)
        return sp.csr_array((frames[moves], (rows[moves], columns[moves])), shape=shape)


def merged(sizes: Sequence[int], ties: Sequence[Integers] = ()) -> _Merged:
    """Join the coordinates of parts."""
    total = sum(sizes)
    i, j = np.concatenate([np.empty((0, 2), np.int64), *ties]).T
    graph = sp.csr_array((np.ones(len(i)), (i, j)), shape=(total, total))
    place = connected_components(graph, directed=False)[1]
    first = np.unique(place, return_index=True)[1]
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return _Merged(tuple(np.split(rank[place], np.cumsum(sizes)[:-1])), len(first))


@dataclass(frozen=True)
class Assembly:
    """Parts and what joins and loads them.

    Attributes
    ----------
    sectors, engine_order : int
        N and EO.
    parts : dict of str to Joinable
        By their own names, in the order of their coordinates.
    contacts, ties, loads, outputs : sequences
        What acts on them.
    cylindrical : bool
        Whether directions 0 to 2 of the parts are radial, circumferential, axial.
    always_closed : tuple of str
        Contacts that the linear limit "free" keeps closed.
    damping_ratio : float, optional
        Modal damping ratio.
    damping_joints : {"stuck", "open"}
        As of `System`.

    Raises
    ------
    InputError
        If there is no part, one is of a ring of other sectors, something names a part that is not
        there, or loads do not go together.
    """

    sectors: int
    engine_order: int
    parts: Mapping[str, Joinable]
    contacts: Sequence[Touching] = ()
    ties: Sequence[Tie] = ()
    loads: Sequence[Load] = ()
    outputs: Sequence[Output] = ()
    cylindrical: bool = False
    always_closed: tuple[str, ...] = ()
    damping_ratio: float | None = None
    damping_joints: str = "stuck"

    def __post_init__(self) -> None:
        for name in ("contacts", "ties", "loads", "outputs"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        if not self.parts:
            raise InputError("parts: given none: needs one or more")
        for name, part in self.parts.items():
            own = getattr(getattr(part, "masters", None), "sectors", self.sectors)
            if own != self.sectors:
                raise InputError(f"{name}: of a ring of {own} sectors, not {self.sectors}")
        wanted = [(each.where, each.own_part) for each in self.contacts]
        wanted += [(each.where, each.mate) for each in self.contacts]
        wanted += [(f"ties.{each.name}", each.own_part) for each in self.ties]
        wanted += [(f"ties.{each.name}", each.mate) for each in self.ties]
        wanted += [(load.where, load.part) for load in self.loads]
        wanted += [(output.where, output.part) for output in self.outputs]
        for where, name in wanted:
            if name and name not in self.parts:
                have = ", ".join(self.parts)
                raise InputError(f"{where}: no part {name!r}; there are {have}")
        self._check_loads()

    def _check_loads(self) -> None:
        """Loads of a harmonic grow alike with the speed, and are of the assembly's engine order."""
        powers: dict[int, int] = {}
        for load in self.loads:
            if load.engine_order not in (None, self.engine_order):
                raise InputError(
                    f"{load.where}: of engine order {load.engine_order}, not {self.engine_order}"
                )
            if powers.setdefault(load.harmonic, load.omega_power) != load.omega_power:
                raise InputError(
                    f"{load.where}: a force and an unbalance in harmonic {load.harmonic}: give one"
                )

    @cached_property
    def merged(self) -> _Merged:
        """Joined coordinates: those that ties join are there once."""
        sizes = [part.size for part in self.parts.values()]
        start = dict(zip(self.parts, np.cumsum([0, *sizes]), strict=False))
        links = []
        for tie in self.ties:
            where, sides = f"ties.{tie.name}", (tie.own_nodes, tie.mate_nodes)
            parts = self.parts[tie.own_part], self.parts[tie.mate]
            a, b = (p.coordinates(n, where, 6) for p, n in zip(parts, sides, strict=True))
            both = (a >= 0) & (b >= 0)
            links.append(
                np.column_stack([start[tie.own_part] + a[both], start[tie.mate] + b[both]])
            )
        return merged(sizes, links)

    def system(self, nodal_diameters: Sequence[int]) -> System:
        """The system with matrices of nodal diameters, and the loads that act at these."""
        if not (chosen := list(dict.fromkeys(int(k) % self.sectors for k in nodal_diameters))):
            raise InputError("nodal_diameters: given none: needs one or several whole numbers")
        own, following = (self._by_node(rows) for rows in self.relative_rows())
        self._refuse_still(own, following)
        output = self._output_rows()
        names = tuple(name for each in self.outputs for name in each.names)
        diameters = {
            k: Diameter(
                own=own,
                next=following if np.any(following) else None,
                output=output if len(names) else None,
                parts={name: self.coordinates(name) for name in self.parts},
                **self._matrices(k),
            )
            for k in chosen
        }
        return System(
            sectors=self.sectors,
            engine_order=self.engine_order,
            diameters=diameters,
            contacts=_around(properties(self.contacts, self.always_closed), diameters),
            force=self._forces(diameters),
            output_names=names,
            damping_ratio=self.damping_ratio,
            damping_joints=self.damping_joints,
            band=common_band(part.reach for part in self.parts.values()),
        )

    def places(self, name: str, nodes: Integers, where: str) -> Integers:
        """(k, 3) joined coordinates of a part's nodes, -1 where one does not move."""
        own = self.parts[name].coordinates(nodes, where)
        return self.merged.of(list(self.parts).index(name), own)

    def coordinates(self, name: str) -> Integers:
        """(r,) joined coordinates of a part."""
        return self.merged.places[list(self.parts).index(name)]

    def rest_loads(self) -> dict[str, Complex]:
        """(n,) of each load at rest that the parts hold, N, at nodal diameter 0.

        Loads of one name on several parts are one.
        """
        found: dict[str, Complex] = {}
        for name, part in self.parts.items():
            for load, vector in part.rest_loads.items():
                none = np.zeros(self.merged.size, complex)
                np.add.at(found.setdefault(load, none), self.coordinates(name), vector)
        return found

    def relative_rows(self) -> tuple[sp.csr_array, sp.csr_array]:
        """(3c, n) rows (normal, t1, t2) of every contact's relative displacement, closing positive.

        From this sector's coordinates, and from the next sector's.
        """
        around = np.eye(3) if self.cylindrical else turn(self.sectors)
        none = sp.csr_array((0, self.merged.size))
        own, following = [none], [none]
        for each in self.contacts:
            where = each.where
            here = self.merged.rows(each.frames, self.places(each.own_part, each.own_nodes, where))
            there = sp.csr_array(here.shape)
            if each.mate:
                mate = self.places(each.mate, each.mate_nodes, where)
                if each.next_sector:
                    there = self.merged.rows(-each.frames @ around, mate)
                else:
                    here = here - self.merged.rows(each.frames, mate)
            own.append(here)
            following.append(there)
        return sp.vstack(own, format="csr"), sp.vstack(following, format="csr")

    def _by_node(self, rows: sp.csr_array) -> Floats:
        """(c, 3, n) of rows (3c, n)."""
        return np.asarray(rows.toarray().reshape(-1, 3, self.merged.size))

    def _matrices(self, k: int) -> dict[str, Matrix]:
        """The joined K and M, and C where a part has one; the others add nothing to it."""
        blocks = [part.at(k) for part in self.parts.values()]
        given = {name: [getattr(block, name, None) for block in blocks] for name in ("K", "M", "C")}
        still = [np.zeros_like(K) for K in given["K"]]
        return {
            name: self.merged.sum([z if A is None else A for A, z in zip(own, still, strict=True)])
            for name, own in given.items()
            if any(A is not None for A in own)
        }

    def _refuse_still(self, rows: Floats, following: Floats) -> None:
        """A contact between nodes that cannot move against each other is none."""
        moves = np.any(rows != 0, axis=(1, 2)) | np.any(following != 0, axis=(1, 2))
        start = 0
        for each in self.contacts:
            still = ~moves[start : start + len(each.own_nodes)]
            start += len(still)
            if still.any():
                a, b = each.own_nodes[still][0], each.mate_nodes[still][0]
                text = f"nodes {a} and {b} are one" if each.mate else f"node {a} is held"
                raise InputError(
                    f"{each.where}: {text}: nothing moves there (a pair of itself, or of "
                    "nodes that a tie merges?)"
                )

    def _forces(self, diameters: Collection[int]) -> dict[int, Force]:
        acting, N = {*diameters, *(-k % self.sectors for k in diameters)}, self.sectors
        found: dict[int, Complex] = {}
        if 0 in acting and (at_rest := self.rest_loads()):
            found[0] = np.sum(list(at_rest.values()), axis=0)
        for load in self.loads:
            if load.harmonic * self.engine_order % N not in acting:
                continue
            vector = found.setdefault(load.harmonic, np.zeros(self.merged.size, complex))
            if load.reduced is not None:
                np.add.at(vector, self.coordinates(load.part), load.reduced)
                continue
            places = self.places(load.part, load.nodes, load.where)
            forces = np.broadcast_to(load.vector, places.shape)
            if np.any(lost := (places < 0) & (np.abs(forces) > 0)):
                i, direction = np.argwhere(lost)[0]
                raise InputError(
                    f"{load.where}.direction: node {load.nodes[i]} of components.{load.part} has "
                    f"no {self._word(int(direction))} displacement among its rows"
                )
            np.add.at(vector, places[places >= 0], forces[places >= 0])
        power = {0: 0, **{load.harmonic: load.omega_power for load in self.loads}}
        return {h: Force(vector, power[h]) for h, vector in sorted(found.items())}

    def _word(self, direction: int) -> str:
        return (COMPONENTS if self.cylindrical else "xyz")[direction]

    def _output_rows(self) -> Floats:
        rows = [np.empty((0, 3, self.merged.size))]
        for each in self.outputs:
            if each.reduced is not None:
                moved = np.zeros((*each.reduced.shape[:2], self.merged.size))
                np.add.at(moved.T, self.coordinates(each.part), each.reduced.T)
                rows.append(moved)
                continue
            at = self.places(each.part, each.nodes, each.where)
            frames = np.tile(np.eye(3), (len(at), 1, 1))
            if each.turned:
                frames = self.parts[each.part].frames(each.nodes, each.where)
            rows.append(self._by_node(self.merged.rows(frames, at)))
        return np.concatenate(rows)


def _around(contacts: Contacts, diameters: Mapping[int, Diameter]) -> Contacts:
    """Contacts whose elements are solved around springs of the structure's own size."""
    if not contacts.elements:
        return contacts
    kn, kt, first = contacts.kn.copy(), contacts.kt.copy(), next(iter(diameters.values()))
    for i in contacts.elements:
        kn[i] = kt[i] = spring_along(first.own[i, 0], first.K, first.M)
    return replace(contacts, kn=kn, kt=kt)


def united(systems: Sequence[System]) -> System:
    """The system that holds the nodal diameters of several.

    A part that is reduced at one nodal diameter after the other, as they are needed, keeps what
    each of them takes: the numbers of coordinates may differ from diameter to diameter.

    Parameters
    ----------
    systems : sequence of System
        The same parts, joints and excitation joined at different nodal diameters.

    Raises
    ------
    InputError
        If there are none, a nodal diameter comes twice, or contacts or outputs differ.
    """
    if not systems:
        raise InputError("united: no systems given")
    first, *others = systems
    diameters, force = dict(first.diameters), dict(first.force)
    for other in others:
        if twice := diameters.keys() & other.diameters.keys():
            raise InputError(f"united: nodal diameter {min(twice)} comes twice")
        alike = ("sectors", "engine_order", "output_names", "damping_ratio", "damping_joints")
        differing = [name for name in alike if getattr(first, name) != getattr(other, name)]
        if differing or first.contacts.joint != other.contacts.joint:
            raise InputError(f"united: the systems differ in {(differing or ['contacts'])[0]}")
        diameters |= other.diameters
        force |= other.force
    band = common_band(each.band for each in systems)
    return replace(
        first,
        diameters=dict(sorted(diameters.items())),
        force=dict(sorted(force.items())),
        band=band,
    )
