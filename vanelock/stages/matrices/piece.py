"""A component ready to be joined: dense matrices by nodal diameter, and its coordinates' names."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from vanelock.common.arrays import Integers
from vanelock.common.cyclic import cylindrical
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.rom.component import Reduced
from vanelock.rom.joining.connections import Load, Output
from vanelock.stages.matrices.nodal_forces import NodalForces


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
    positions: NDArray[np.float64] = field(metadata={"unit": "m"})
    band: float | None = field(default=None, metadata={"unit": "Hz"})
    pushed: dict[int, Integers] = field(default_factory=dict)
    loads: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3, 0)))
    forces: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    shown: Integers = field(default_factory=lambda: np.empty(0, np.int64))
    outputs: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3, 0)))

    @property
    def rest_loads(self) -> dict[str, NDArray[np.float64]]:
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

    def reduced_load(self, given: Load) -> Load:
        """A load on it, on the coordinates where its nodes are none of these."""
        for i, nodes in self.pushed.items():
            if np.array_equal(nodes, given.nodes):
                return replace(given, reduced=given.vector @ self.loads[i])
        return given

    def load_of(self, given: NodalForces) -> Load:
        """A load of a file on it, on the coordinates."""
        factor = np.complex128(given.factor)
        vector, own = factor * given.forces, factor * self.forces[given.digest]
        return Load(given.where, given.part, given.nodes, vector, given.harmonic, reduced=own)

    def reduced_outputs(self, given: Output) -> Iterator[Output]:
        """Outputs of it, one by one, by the coordinates where their nodes are none of these."""
        for i, name in enumerate(given.names):
            own = given.nodes[i : i + 1]
            moved = self.outputs[self.shown == own]
            if given.turned and len(moved):
                moved = self.frames(own, given.where) @ moved
            yield replace(given, nodes=own, names=[name], reduced=moved if len(moved) else None)

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
        found = np.full((len(nodes), directions), -1)
        for d in range(directions):
            own = np.flatnonzero(self.direction == d)
            order = own[np.argsort(self.node[own], kind="stable")]
            at = np.searchsorted(self.node[order], nodes).clip(max=max(len(order) - 1, 0))
            if len(order):
                match = self.node[order[at]] == nodes
                found[match, d] = order[at[match]]
        if np.any(missing := np.all(found[:, :3] < 0, axis=1)):
            raise InputError(
                f"{where}: node {nodes[missing][0]} of components.{self.name} has no displacement "
                "among its rows"
            )
        return found

    def frames(self, nodes: Integers, where: str) -> NDArray[np.float64]:
        """(k, 3, 3) turn from Cartesian components to each node's cylindrical ones."""
        order = np.argsort(self.places, kind="stable")
        at = np.searchsorted(self.places[order], nodes).clip(max=max(len(order) - 1, 0))
        if not len(order) or np.any(missing := self.places[order[at]] != nodes):
            node = nodes[0] if not len(order) else nodes[missing][0]
            raise InputError(
                f"{where}: the coordinates of node {node} are not known: give "
                f"components.{self.name}.nodes"
            )
        return cylindrical(self.positions[order[at]])
