"""The nodes of a part that others can reach: for contacts, ties, loads and outputs.

A contact node can stand for its patch: then its displacement is the mean over the patch, and its
place the patch's centroid.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.mesh import Part
from vanelock.mesh.part import called


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
        Their coordinates, m; the patch's centroid where a node is averaged.
    node_sets : dict of str to (k,) int
        Node numbers of the sets that lie among them.
    frames : dict of str to (k, 3, 3) float
        Contact frames of those sets, as in `mesh.Part`.
    averaged : (a,) int
        Those of the nodes whose displacement is the mean over their contact patch.
    areas : dict of str to (k,) float
        Areas of the nodes of those contact sets that have them, m², as in `mesh.Part`.
    """

    part: str
    sectors: int
    nodes: Integers
    points: Floats = field(metadata={"unit": "m"})
    node_sets: dict[str, Integers]
    frames: dict[str, Floats]
    averaged: Integers = field(default_factory=lambda: np.empty(0, np.int64))
    areas: dict[str, Floats] = field(default_factory=dict, metadata={"unit": "m^2"})

    def set(self, name: str) -> Integers:
        """Node numbers of a set."""
        if (own := called(self.node_sets, name)) is None:
            raise InputError(f"{self.part}: no node set {name!r} among its masters")
        return self.node_sets[own]

    def places(self, nodes: Integers) -> Integers:
        """Where nodes stand in `nodes`."""
        order = np.argsort(self.nodes)
        rank = np.searchsorted(self.nodes, nodes, sorter=order)
        places = order[rank.clip(max=len(order) - 1)]
        if np.any(missing := self.nodes[places] != nodes):
            raise InputError(f"{self.part}: node {nodes[missing][0]} was not retained as a master")
        return np.asarray(places)

    def position(self, nodes: Integers) -> Floats:
        """(k, 3) coordinates of nodes, m."""
        return self.points[self.places(nodes)]


def choose(part: Part, names: Sequence[str], averaged: Sequence[str] = ()) -> Masters:
    """The nodes of the named sets, each once, in order of first appearance."""
    none = np.empty(0, np.int64)
    names, averaged = (
        [called(part.node_sets, each) or each for each in given] for given in (names, averaged)
    )
    found = np.concatenate([none, *map(part.nodes, names)])
    nodes = found[np.sort(np.unique(found, return_index=True)[1])]
    places = _places(part, averaged)
    means = np.concatenate([none, *(part.node_sets[name] for name in averaged)])
    return Masters(
        part=part.name,
        sectors=part.sectors,
        nodes=nodes,
        points=places[nodes],
        node_sets={name: part.node_sets[name] for name in names},
        frames={name: part.frames[name] for name in names if name in part.frames},
        averaged=nodes[np.isin(nodes, means)],
        areas={name: part.areas[name] for name in names if name in part.areas},
    )


def everything(part: Part, averaged: Sequence[str] = ()) -> Masters:
    """All nodes of a part, for joining what is not reduced."""
    nodes = np.arange(len(part.points))
    points = _places(part, averaged)
    means = np.concatenate([nodes[:0], *(part.node_sets[name] for name in averaged)])
    return Masters(
        part.name, part.sectors, nodes, points, part.node_sets, part.frames, means, part.areas
    )


def _places(part: Part, averaged: Sequence[str]) -> Floats:
    """Coordinates (n, 3) of the nodes, m, or of the centroids of the patches they stand for."""
    points: Floats = part.points.copy()
    for name in averaged:
        if name not in part.patches:
            have = ", ".join(sorted(part.patches)) or "none"
            raise InputError(f"{part.name}: no contact patches of {name!r}; it has {have}")
        points[part.node_sets[name]] = part.patches[name] @ part.points
    return points
