"""The nodes of a part that others can reach: for contacts, ties, loads and outputs."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.mesh import Part
from vanelock.product import Product


@dataclass(frozen=True)
class Masters(Product):
    """Nodes of a part with their places, sets and contact frames.

    Attributes
    ----------
    part : str
        Name of the part.
    sectors : int
        Sectors N in the ring.
    nodes : (m,) int
        The part's node numbers.
    points : (m, 3) float
        Their coordinates, m.
    node_sets : dict of str to (k,) int
        Node numbers of the sets that lie among them.
    frames : dict of str to (k, 3, 3) float
        Contact frames of those sets, as in `mesh.Part`.
    """

    part: str
    sectors: int
    nodes: NDArray[np.int64]
    points: NDArray[np.float64] = field(metadata={"unit": "m"})
    node_sets: dict[str, NDArray[np.int64]]
    frames: dict[str, NDArray[np.float64]]

    def set(self, name: str) -> NDArray[np.int64]:
        """Node numbers of a set.

        Raises
        ------
        InputError
            If the part has no such set among its masters.
        """
        if name not in self.node_sets:
            raise InputError(f"{self.part}: no node set {name!r} among its masters")
        return self.node_sets[name]

    def places(self, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Where nodes stand in `nodes`.

        Raises
        ------
        InputError
            If one is not among them.
        """
        order = np.argsort(self.nodes)
        rank = np.searchsorted(self.nodes, nodes, sorter=order)
        places = order[rank.clip(max=len(order) - 1)]
        if np.any(missing := self.nodes[places] != nodes):
            raise InputError(f"{self.part}: node {nodes[missing][0]} was not retained as a master")
        return np.asarray(places)

    def position(self, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        """(k, 3) coordinates of nodes, m."""
        return self.points[self.places(nodes)]


def choose(part: Part, names: tuple[str, ...]) -> Masters:
    """The nodes of the named sets, each once, in order of first appearance.

    Raises
    ------
    InputError
        If the part lacks a set.
    """
    for name in names:
        if name not in part.node_sets:
            raise InputError(f"{part.name}: no node set {name!r}")
    found = np.concatenate([np.empty(0, np.int64), *(part.node_sets[name] for name in names)])
    nodes = found[np.sort(np.unique(found, return_index=True)[1])]
    sets = {name: part.node_sets[name] for name in names}
    frames = {name: part.frames[name] for name in names if name in part.frames}
    return Masters(part.name, part.sectors, nodes, part.points[nodes], sets, frames)


def everything(part: Part) -> Masters:
    """All nodes of a part, for joining what is not reduced."""
    nodes = np.arange(len(part.points))
    return Masters(part.name, part.sectors, nodes, part.points, part.node_sets, part.frames)
