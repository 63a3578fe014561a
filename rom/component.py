"""A reduced part: dense matrices by nodal diameter and what recovery needs."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.product import Product

Matrix = NDArray[np.float64] | NDArray[np.complex128]


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
    """

    K: NDArray[np.complex128] = field(metadata={"unit": "N/m"})
    M: NDArray[np.complex128] = field(metadata={"unit": "kg"})
    basis: NDArray[np.complex128] | None = None


@dataclass(frozen=True)
class Component(Product):
    """A part reduced to its retained masters and a few modal coordinates.

    The reduced coordinates are, in this order: `interface_modes` amplitudes of the cyclic face
    (none for a part in one piece), x, y, z of each retained master node, and the amplitudes of
    the fixed-interface modes.

    Attributes
    ----------
    name : str
        Name of the part.
    sectors : int
        Sectors N in the ring.
    cyclic : bool
        Whether the part continues into its neighbours, with matrices by nodal diameter; if not,
        its one set of matrices is stored under 0 and serves every diameter.
    nodes : (m,) int
        The part's node numbers of the retained masters, in the order of their coordinates.
    points : (m, 3) float
        Their coordinates, m.
    node_sets : dict of str to (k,) int
        Node numbers of the sets that were retained.
    frames : dict of str to (k, 3, 3) float
        Contact frames of those sets, as in `mesh.Part`.
    interface_modes : int
        Number of face coordinates that come first.
    diameters : dict of int to Reduced
        Matrices by nodal diameter; where k is absent and N-k present, its conjugate serves.
    boundary_nodes : (b,) int
        All nodes that were masters of the Craig-Bampton step, cyclic faces included.
    fixed_modes : (s, f) float
        Fixed-interface modes on the dofs of the other nodes, mass-normalised.
    fixed_frequencies : (f,) float
        Their frequencies, Hz.
    """

    name: str
    sectors: int
    cyclic: bool
    nodes: NDArray[np.int64]
    points: NDArray[np.float64] = field(metadata={"unit": "m"})
    node_sets: dict[str, NDArray[np.int64]]
    frames: dict[str, NDArray[np.float64]]
    interface_modes: int
    diameters: dict[int, Reduced]
    boundary_nodes: NDArray[np.int64]
    fixed_modes: NDArray[np.float64] = field(metadata={"unit": "1/sqrt(kg)"})
    fixed_frequencies: NDArray[np.float64] = field(metadata={"unit": "Hz"})

    @property
    def size(self) -> int:
        """Number of reduced coordinates."""
        return self.interface_modes + 3 * len(self.nodes) + len(self.fixed_frequencies)

    def at(self, nodal_diameter: int) -> Reduced:
        """Matrices of a nodal diameter.

        Raises
        ------
        InputError
            If the part was not reduced at it.
        """
        if not self.cyclic:
            return self.diameters[0]
        k = nodal_diameter % self.sectors
        if k in self.diameters:
            return self.diameters[k]
        if (mirrored := (self.sectors - k) % self.sectors) in self.diameters:
            found = self.diameters[mirrored]
            basis = None if found.basis is None else found.basis.conj()
            return Reduced(found.K.conj(), found.M.conj(), basis)
        have = ", ".join(str(k) for k in sorted(self.diameters))
        raise InputError(f"{self.name}: not reduced at nodal diameter {k} (only at {have})")

    def position(self, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        """(k, 3) coordinates of the given retained nodes, m."""
        return self.points[self._places(nodes)]

    def dofs(self, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """(k, 3) reduced coordinates that are the displacement of the given retained nodes."""
        return self.interface_modes + 3 * self._places(nodes)[:, None] + np.arange(3)

    def _places(self, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Where the given nodes stand among the retained ones."""
        order = np.argsort(self.nodes)
        rank = np.searchsorted(self.nodes, nodes, sorter=order)
        places = order[rank.clip(max=len(order) - 1)]
        if np.any(missing := self.nodes[places] != nodes):
            raise InputError(f"{self.name}: node {nodes[missing][0]} was not retained as a master")
        return places
