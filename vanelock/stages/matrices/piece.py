"""A component ready to be joined: dense matrices by nodal diameter, and its coordinates' names.

Forces on nodes of a component from a file, such as a gas or thermal load of another program.

None of their nodes becomes a coordinate: the reduction holds the static answer to all of them
together, and they act on its coordinates as Tᵀ f (`vanelock.rom.routes.rows`). What acts on clamped
nodes the ground bears.

What loads and outputs see of a component without adding to its coordinates.

With x = T y the reduction, a load f acts on the coordinates as Tᵀ f, and row i moves as the row i
of T; the static answer to f is among the columns of T (`vanelock.rom.routes.rows`).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.cyclic import cylindrical
from vanelock.common.errors import InputError
from vanelock.common.files.digests import content_digest
from vanelock.common.product import Product
from vanelock.fem.matrix_files import load_pairs
from vanelock.rom import ReducedRows
from vanelock.rom.component import Reduced
from vanelock.rom.joining.connections import Load, Output

COLUMNS = ("fx", "fy", "fz")


@dataclass(frozen=True)
class NodalForces:
    """A load from a file."""

    where: str
    """Who asks, in messages."""
    part: str
    """Whose nodes."""
    digest: str
    """Of what the file holds."""
    nodes: Integers
    """(k,) of the file."""
    forces: Floats
    """(k, 3) on each of them, N."""
    factor: complex
    """What multiplies them: scale and phase."""
    harmonic: int
    """0: a static load."""


def read_forces(path: Path) -> tuple[str, Integers, Floats]:
    """Digest of a file with the columns node, fx, fy, fz, its nodes (k,) and forces (k, 3), N."""
    digest = content_digest(path)
    return digest, *_read(path, digest)


@lru_cache(maxsize=16)
def _read(path: Path, digest: str) -> tuple[Integers, Floats]:
    """Nodes and forces, once for all cases."""
    table = read_table(path, ("node", *COLUMNS), ("node",))
    if content_digest(path) != digest:
        raise InputError(f"{path}: changed while it was read: run again")
    nodes, none = table["node"], np.zeros(len(table["node"]))
    if nodes.min() < 1:
        raise InputError(f"{path}: a column 'node' of node numbers is needed")
    if len(table) == 1:
        raise InputError(f"{path}: at least one of the columns {', '.join(COLUMNS)} is needed")
    distinct, count = np.unique(nodes, return_counts=True)
    if np.any(count > 1):
        raise InputError(f"{path}: node {distinct[count > 1][0]} is listed twice")
    forces = np.column_stack([np.asarray(table.get(each, none), float) for each in COLUMNS])
    if not forces.any():
        raise InputError(f"{path}: all its forces are 0")
    return np.asarray(nodes), forces


def read_table(
    path: Path, allowed: Iterable[str], numbered: Iterable[str]
) -> Mapping[str, NDArray[Any]]:
    """Columns of numbers of a file; nodes are `numbered` in some, which have to be there."""
    table: Mapping[str, NDArray[Any]] = load_pairs(path)
    if unknown := [column for column in table if column not in allowed]:
        raise InputError(f"{path}: column {unknown[0]!r}: allowed are {', '.join(allowed)}")
    for column in numbered:
        if column not in table or table[column].dtype.kind != "i":
            raise InputError(f"{path}: a column {column!r} of node numbers is needed")
    for column, values in table.items():
        if values.dtype.kind not in "if":
            raise InputError(f"{path}: column {column!r} does not hold numbers")
    return table


def among(numbers: Integers, searched: Integers) -> tuple[Integers, Booleans]:
    """Places of some numbers among others, the first of several, and which of them are there."""
    if not len(numbers):
        return np.zeros_like(searched), np.zeros(searched.shape, bool)
    order = np.argsort(numbers, kind="stable")
    at = order[np.searchsorted(numbers[order], searched).clip(max=len(numbers) - 1)]
    return at, numbers[at] == searched


def rows_of(node: Integers, direction: Integers, nodes: Integers, directions: int = 3) -> Integers:
    """(k, directions) rows of the displacements of nodes, rotations behind them; -1: there is none.

    Of a component whose rows are directions of nodes.
    """
    found = np.full((len(nodes), directions), -1)
    for d in range(directions):
        own = np.flatnonzero(direction == d)
        at, there = among(node[own], nodes)
        found[there, d] = own[at[there]]
    return found


def kept_rows(
    node: Integers, direction: Integers, nodes_kept: tuple[Integers, Integers]
) -> Booleans:
    """(n,) rows of nodes that are named: displacements, and rotations of the second of these."""
    named, turned = (np.isin(node, each) for each in nodes_kept)
    return (named & (direction < 3)) | (turned & (direction < 6))


def on_rows(
    nodal_forces: Sequence[NodalForces], node: Integers, direction: Integers, fixed: Integers
) -> sp.csc_array:
    """(n, p) forces on a component's rows, one load a column, in unit size, N."""
    rows, columns, values = [np.empty(0, np.int64)], [np.empty(0, np.int64)], [np.empty(0)]
    for i, each in enumerate(nodal_forces):
        of = f"of components.{each.part}"
        free = ~np.isin(each.nodes, fixed)
        nodes, forces = each.nodes[free], each.forces[free]
        if len(missing := nodes[~np.isin(nodes, node)]):
            raise InputError(f"{each.where}.file: node {missing[0]} is not among the nodes {of}")
        at, acts = rows_of(node, direction, nodes), forces != 0
        if np.any(lost := acts & (at < 0)):
            k, d = np.argwhere(lost)[0]
            raise InputError(
                f"{each.where}.file: node {nodes[k]} {of} has no row for its {COLUMNS[d]}"
            )
        rows.append(at[acts])
        columns.append(np.full(np.count_nonzero(acts), i))
        values.append(forces[acts])
    where = np.concatenate(rows), np.concatenate(columns)
    return sp.csc_array((np.concatenate(values), where), shape=(len(node), len(nodal_forces)))


@dataclass(frozen=True)
class Piece(Product):
    """A component of r coordinates.

    Attributes
    ----------
    name : str
        The component's.
    node, direction : (r,) int
        What each coordinate is: the displacement (0 to 2) or rotation (3 to 5) of a node, or, with
        node 0 and direction 6, the amplitude of a mode.
    sectors : int
        N; matters where matrices depend on the nodal diameter.
    blocks : dict of int to Reduced
        Matrices by nodal diameter, with what a reduction leaves out; one under -1 serves all.
    band : float or None
        Frequency up to which it answers, Hz; None where nothing was left out or it is not known.
    places : (p,) int and positions : (p, 3) float
        Nodes with known coordinates, m.
    pushed : dict of int to (k,) int and loads : (p, 3, r) float
        Sets of loaded nodes that are none of the coordinates, by number, and the forces on the
        coordinates of unit forces along x, y, z on each node of a set.
    forces : dict of str to (r,) float
        Forces on the coordinates of those that files hold, by these files' digests, N.
    shown : (o,) int and outputs : (o, 3, r) float
        Output nodes that are none of the coordinates, and their displacements from these.
    """

    name: str
    node: Integers
    direction: Integers
    sectors: int
    blocks: dict[int, Reduced]
    places: Integers
    positions: Floats = field(metadata={"unit": "m"})
    band: float | None = field(default=None, metadata={"unit": "Hz"})
    pushed: dict[int, Integers] = field(default_factory=dict)
    loads: Floats = field(default_factory=lambda: np.empty((0, 3, 0)))
    forces: dict[str, Floats] = field(default_factory=dict)
    shown: Integers = field(default_factory=lambda: np.empty(0, np.int64))
    outputs: Floats = field(default_factory=lambda: np.empty((0, 3, 0)))

    @property
    def rest_loads(self) -> dict[str, Floats]:
        """None: loads at rest are those of harmonic 0."""
        return {}

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return len(self.node)

    @property
    def reach(self) -> float | None:
        """Frequency up to which it answers, Hz: its band."""
        return self.band

    def reduced_load(self, nodal_load: Load) -> Load:
        """A load on it, on the coordinates where its nodes are none of these."""
        for i, nodes in self.pushed.items():
            if np.array_equal(nodes, nodal_load.nodes):
                return replace(nodal_load, reduced=nodal_load.vector @ self.loads[i])
        return nodal_load

    def load_of(self, forces: NodalForces) -> Load:
        """A load of a file on it, on the coordinates."""
        factor = np.complex128(forces.factor)
        vector, own = factor * forces.forces, factor * self.forces[forces.digest]
        return Load(forces.where, forces.part, forces.nodes, vector, forces.harmonic, reduced=own)

    def reduced_outputs(self, output: Output) -> Iterator[Output]:
        """Outputs of it, one by one, by the coordinates where their nodes are none of these."""
        for i, name in enumerate(output.names):
            own = output.nodes[i : i + 1]
            moved = self.outputs[self.shown == own]
            if output.turned and len(moved):
                moved = self.frames(own, output.where) @ moved
            yield replace(output, nodes=own, names=[name], reduced=moved if len(moved) else None)

    def at(self, nodal_diameter: int) -> Reduced:
        """Matrices of a nodal diameter."""
        k, mirrored = nodal_diameter % self.sectors, -nodal_diameter % self.sectors
        for wanted, found in ((-1, False), (k, False), (mirrored, True)):
            if wanted in self.blocks:
                block = self.blocks[wanted]
                return block.conjugate() if found else block
        have = ", ".join(map(str, sorted(self.blocks)))
        raise InputError(
            f"components.{self.name}: no matrices of nodal diameter {k}; it has {have}"
        )

    def coordinates(self, nodes: Integers, where: str, directions: int = 3) -> Integers:
        """(k, 3) coordinates of the x, y, z displacements of nodes; -1 where one does not move.

        With six `directions`, (k, 6): the rotations behind them.
        """
        found = rows_of(self.node, self.direction, nodes, directions)
        if np.any(missing := np.all(found[:, :3] < 0, axis=1)):
            raise InputError(
                f"{where}: node {nodes[missing][0]} of components.{self.name} has no displacement "
                "among its rows"
            )
        return found

    def frames(self, nodes: Integers, where: str) -> Floats:
        """(k, 3, 3) turn from Cartesian components to each node's cylindrical ones."""
        at, there = among(self.places, nodes)
        if not there.all():
            raise InputError(
                f"{where}: the coordinates of node {nodes[~there][0]} are not known: give "
                f"components.{self.name}.nodes"
            )
        return cylindrical(self.positions[at])


Followed: TypeAlias = tuple[tuple[tuple[int, ...], ...], tuple[int, ...]]
"""Sets of nodes that are loaded, and nodes that are shown, which nothing joins to others."""


@dataclass(frozen=True)
class Seen:
    """Sets of loaded nodes and output nodes that are no coordinates.

    Attributes
    ----------
    pushed : tuple of ((k,) int, (k, 3) int)
        Nodes of each set, and their rows x, y, z.
    shown : tuple of (int, (3,) int)
        Output nodes, and their rows.
    rows : (m,) int
        Rows that are kept as coordinates.
    digests : tuple of str
        Files of nodal forces.
    forces : (n, f) sparse, optional
        What they hold, one a column, N.
    """

    pushed: tuple[tuple[Integers, Integers], ...]
    shown: tuple[tuple[int, Integers], ...]
    rows: Integers
    digests: tuple[str, ...] = ()
    forces: sp.csc_array | None = None

    def columns(self, size: int) -> tuple[sp.csc_array | None, Integers | None]:
        """(size, 3p + f) forces, and rows of outputs.

        Forces are units along x, y, z on each node of a set, and behind them those of files.
        """
        loads, outputs = self.forces, None
        if self.pushed:
            at = [rows[:, axis] for _, rows in self.pushed for axis in range(3)]
            column = np.repeat(np.arange(len(at)), [len(each) for each in at])
            entries = np.ones(len(column)), (np.concatenate(at), column)
            units = sp.csc_array(entries, shape=(size, len(at)))
            loads = units if loads is None else sp.hstack([units, loads], format="csc")
        if self.shown:
            outputs = np.concatenate([rows for _, rows in self.shown])
        return loads, outputs

    def by(self, reduced: ReducedRows) -> dict[str, Any]:
        """Fields of a `Piece`."""
        found: dict[str, Any] = {}
        if reduced.loads is not None:
            p, r = len(self.pushed), reduced.loads.shape[1]
            found["pushed"] = {i: nodes for i, (nodes, _) in enumerate(self.pushed)}
            found["loads"] = reduced.loads[: 3 * p].reshape(p, 3, r)
            found["forces"] = dict(zip(self.digests, reduced.loads[3 * p :], strict=True))
        if reduced.outputs is not None:
            found["shown"] = np.array([node for node, _ in self.shown], np.int64)
            found["outputs"] = reduced.outputs.reshape(len(self.shown), 3, -1)
        return found


def seen_from(
    followed: Followed,
    rows_kept: Integers,
    node: Integers,
    direction: Integers,
    K: sp.csc_array,
    M: sp.csc_array,
) -> Seen:
    """What of loads and outputs need not be kept: nodes that move, with mass, in all directions."""
    inert = (K.diagonal().real > 0) & (M.diagonal().real > 0) & (direction < 3)
    own, every = np.flatnonzero(inert), _all(followed)
    rows_of_every = rows_of(node[own], direction[own], every)
    pairs = zip(every.tolist(), rows_of_every, strict=True)
    whole = {n: own[at] for n, at in pairs if np.all(at >= 0)}
    pushed = [each for each in followed[0] if all(n in whole for n in each)]
    held = {n for each in followed[0] if each not in pushed for n in each}
    pushed = [each for each in pushed if held.isdisjoint(each)]
    shown = [n for n in followed[1] if n in whole and n not in held]
    gone = _all((tuple(pushed), tuple(shown)))
    rows = rows_kept[~np.isin(node[rows_kept], gone)]
    if not len(rows):
        return Seen((), (), rows_kept)
    sets = tuple((np.array(each), np.array([whole[n] for n in each])) for each in pushed)
    return Seen(sets, tuple((n, whole[n]) for n in shown), rows)


def _all(followed: Followed) -> Integers:
    return np.array([*{n for each in followed[0] for n in each}, *followed[1]], np.int64)
