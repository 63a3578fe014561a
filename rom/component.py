"""A reduced part: dense matrices by nodal diameter, its masters, and what recovery needs.

Masters are the nodes that others can reach: for contacts, ties, loads and outputs. A contact node
can stand for its patch: then its displacement is the mean over the patch, and its place the patch's
centroid.

A component takes another Young's modulus without being reduced again. A part of one material whose
modulus E becomes sE, Poisson's ratio and density as they were, has the stiffness sK and the mass M.
Constraint modes -K_ss⁻¹ K_sm, fixed-interface modes of (K_ss, M_ss), their static answers K_ss⁻¹
M_ss B and the modes of the cyclic faces all span what they spanned, so the reduced matrices follow
exactly:

    K → s K,    M → M,    frequencies → √s,

and of what the reduction leaves out (`errors.frequency_errors`: ε = rᴴ K_ss⁻¹ r, with a residual r
that is partly stiffness and partly inertia force)

    G₀ → s G₀,    G₁ → G₁,    G₂ → G₂ / s.

Static answers to loads at rest span what they spanned, too; a load of thermal strain grows with E.
"""

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.cyclic import cylindrical
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.mesh import Part
from vanelock.mesh.part import called
from vanelock.rom.system.system import Matrix, common_band, conjugated


@dataclass(frozen=True)
class Masters(Product):
    """Nodes of a part with their places, sets and contact frames."""

    part: str  # name of the part
    sectors: int  # sectors N in the ring
    nodes: Integers  # (m,), the part's node numbers
    points: Floats = field(metadata={"unit": "m"})
    """(m, 3), their coordinates, m; the patch's centroid where a node is averaged."""
    node_sets: dict[str, Integers]  # by name (k,), node numbers of the sets that lie among them
    frames: dict[str, Floats]  # by name (k, 3, 3), contact frames of those sets, as in `mesh.Part`
    averaged: Integers = field(default_factory=lambda: np.empty(0, np.int64))
    """(a,), those of the nodes whose displacement is the mean over their contact patch."""
    areas: dict[str, Floats] = field(default_factory=dict, metadata={"unit": "m^2"})
    """By name (k,), areas of the nodes of those contact sets that have them, m², as in
    `mesh.Part`."""

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


def _places(part: Part, averaged: Sequence[str]) -> Floats:
    """Coordinates (n, 3) of the nodes, m, or of the centroids of the patches they stand for."""
    points: Floats = part.points.copy()
    for name in averaged:
        if name not in part.patches:
            have = ", ".join(sorted(part.patches)) or "none"
            raise InputError(f"{part.name}: no contact patches of {name!r}; it has {have}")
        points[part.node_sets[name]] = part.patches[name] @ part.points
    return points


@dataclass(frozen=True)
class Reduced(Product):
    """Matrices of one nodal diameter, in n reduced coordinates.

    Attributes
    ----------
    K, M : (n, n)
        Hermitian stiffness and mass; real at ND 0 and N/2 and where there is no symmetry.
    basis : (b, n) or None
        Craig-Bampton coordinates (all masters, then fixed-interface modes) from the reduced ones;
        None where the two are the same.
    vectors : (s, f) or None
        Fixed-interface vectors of this diameter, in the order of `Condensed.transform`; None where
        those of the component serve.
    neglected : (3, n, n) or None
        What the reduction leaves out, see `errors.frequency_errors`; None where it is not known.
    complete : float or None
        Frequency up to which no fixed-interface mode is left out, Hz; infinite where none is.
    C : (n, n) or None
        Hermitian damping, N s/m, where a part has its own.
    """

    K: Matrix = field(metadata={"unit": "N/m"})
    M: Matrix = field(metadata={"unit": "kg"})
    basis: Matrix | None = None
    vectors: Matrix | None = None
    neglected: Matrix | None = None
    complete: float | None = field(default=None, metadata={"unit": "Hz"})
    C: Matrix | None = field(default=None, metadata={"unit": "N s/m"})

    @property
    def reach(self) -> float | None:
        """Frequency up to which it answers without an accuracy, Hz: `complete`, where known."""
        return self.complete or None

    def conjugate(self) -> "Reduced":
        """The same part at the nodal diameter N - k."""
        names = ("K", "M", "basis", "vectors", "neglected", "C")
        return replace(self, **conjugated(self, names))


@dataclass(frozen=True)
class Component(Product):
    """A part reduced to its retained masters and a few modal coordinates.

    The reduced coordinates are, in this order: `interface_modes` amplitudes of the cyclic face
    (none for a part in one piece, or by the route "cyclic"), x, y, z of each retained master node,
    and the amplitudes of the fixed-interface vectors.

    Attributes
    ----------
    masters : Masters
        The retained nodes, in the order of their coordinates.
    cyclic : bool
        Whether the part continues into its neighbours, with matrices by nodal diameter; if not,
        its one set of matrices is stored under 0 and serves every diameter.
    route : str
        How it was reduced: "whole" (a part in one piece), "paper" or "cyclic".
    interface_modes : int
        Number of face coordinates that come first.
    fixed_modes : int
        Number of fixed-interface vectors f.
    diameters : dict of int to Reduced
        Matrices by nodal diameter; where k is absent and N-k present, its conjugate serves.
    boundary_nodes : (b,) int
        All nodes that were masters of the Craig-Bampton step, cyclic faces included.
    vectors : (s, f) float or None
        Fixed-interface vectors on the dofs of the other nodes, mass-normalised, where they are the
        same at all diameters.
    band : float or None
        Frequency up to which an accuracy was asked for, at every diameter, Hz.
    loads : dict of str to (n,) or None
        Loads at rest by name, N, in the coordinates of nodal diameter 0; None where there are none.
    """

    masters: Masters
    cyclic: bool
    route: str
    interface_modes: int
    fixed_modes: int
    diameters: dict[int, Reduced]
    boundary_nodes: Integers
    vectors: Floats | None = field(default=None, metadata={"unit": "kg^-0.5"})
    band: float | None = field(default=None, metadata={"unit": "Hz"})
    loads: dict[str, Matrix] | None = field(default=None, metadata={"unit": "N"})

    @property
    def reach(self) -> float | None:
        """Frequency up to which the part answers, Hz.

        Its band, or where a number of modes or a cut-off was asked for the frequency up to which
        no fixed-interface mode is left out; None where the route gives no estimate.
        """
        if self.band is not None:
            return self.band
        return common_band(each.reach for each in self.diameters.values())

    def shortened(self) -> "Component":
        """The same with its fixed-interface vectors in single precision.

        Fields alone are recovered with them, to 1e-7; its matrices stay as they are.
        """
        diameters = {k: replace(r, vectors=_single(r.vectors)) for k, r in self.diameters.items()}
        return replace(self, vectors=_single(self.vectors), diameters=diameters)

    @property
    def rest_loads(self) -> dict[str, Matrix]:
        """Its loads at rest by name, N; none where it has none."""
        return self.loads or {}

    @property
    def size(self) -> int:
        """Number of reduced coordinates."""
        return self.interface_modes + 3 * len(self.masters.nodes) + self.fixed_modes

    def at(self, nodal_diameter: int) -> Reduced:
        """Matrices of a nodal diameter.

        Raises
        ------
        InputError
            If the part was not reduced at it.
        """
        if not self.cyclic:
            return self.diameters[0]
        k = nodal_diameter % self.masters.sectors
        if k in self.diameters:
            return self.diameters[k]
        if (mirrored := (self.masters.sectors - k) % self.masters.sectors) in self.diameters:
            return self.diameters[mirrored].conjugate()
        have = ", ".join(str(k) for k in sorted(self.diameters))
        raise InputError(f"{self.masters.part}: not reduced at nodal diameter {k} (only at {have})")

    def carrying(self, sums: Iterable[tuple[str, str, float]]) -> "Component":
        """The same with other loads at rest: of each name the sum of multiples of those it has."""
        found: dict[str, Matrix] = {}
        for name, kind, factor in sums:
            own = self.rest_loads[kind]
            found[name] = found.get(name, np.zeros_like(own)) + factor * own
        return replace(self, loads=found)

    def coordinates(self, nodes: Integers, where: str, directions: int = 3) -> Integers:
        """(k, 3) or, with rotations, which are no coordinates, (k, 6): see `dofs`."""
        none = np.full((len(nodes), directions - 3), -1)
        return np.column_stack([self.dofs(nodes), none])

    def frames(self, nodes: Integers, where: str) -> Floats:
        """(k, 3, 3) turn from Cartesian components to each retained node's cylindrical ones."""
        return cylindrical(self.masters.position(nodes))

    def dofs(self, nodes: Integers) -> Integers:
        """(k, 3) reduced coordinates that are the displacement of the given retained nodes."""
        return self.interface_modes + 3 * self.masters.places(nodes)[:, None] + np.arange(3)


def _single(array: Array | None) -> Array | None:
    if array is None:
        return None
    return array.astype(np.complex64 if np.iscomplexobj(array) else np.float32)


def stiffened(component: Component, factor: float, strained: Collection[str] = ()) -> Component:
    """The same part with Young's modulus times `factor`, at all its nodal diameters.

    Parameters
    ----------
    component : Component
        The part as it was reduced. What it keeps stays the same, so the frequency up to which it
        is accurate moves by √factor.
    factor : float
        New modulus over old, > 0.
    strained : collection of str
        Names of its loads at rest that are of thermal strain.

    Raises
    ------
    InputError
        If the factor is not positive and finite.
    """
    if not (factor > 0 and math.isfinite(factor)):
        raise InputError(f"factor = {factor:g}: Young's modulus must stay > 0 and finite")
    band = None if component.band is None else component.band * math.sqrt(factor)
    diameters = {k: _stiffened(each, factor) for k, each in component.diameters.items()}
    loads = component.loads and {
        name: factor * load if name in strained else load for name, load in component.loads.items()
    }
    return replace(component, diameters=diameters, band=band, loads=loads)


def _stiffened(reduced: Reduced, s: float) -> Reduced:
    neglected = reduced.neglected
    if neglected is not None:
        neglected = neglected * np.array([s, 1.0, 1 / s])[:, None, None]
    complete = None if reduced.complete is None else reduced.complete * math.sqrt(s)
    return replace(reduced, K=s * reduced.K, neglected=neglected, complete=complete)
