"""The unreduced cyclic sector: finite elements of parts, joined with linear contact springs.

The reference for every reduction error; nothing here is a reduced-order model.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.cyclic import cylindrical, phase_factor
from vanelock.fem import Model, cyclic_transform
from vanelock.rom.component import Masters, choose
from vanelock.rom.joining.assembly import Assembly
from vanelock.rom.joining.connections import properties
from vanelock.rom.routes.problem import with_means
from vanelock.stages.parts.segment import HOOK_SETS, Joint, Segment


class SparseMatrices(NamedTuple):
    """K and M of a part at a nodal diameter, Hermitian, N/m and kg."""

    K: Any
    M: Any


@dataclass(frozen=True)
class UnreducedPart:
    """A part as it is, to be joined like a `Component`: all its nodes can be reached.

    Attributes
    ----------
    model : fem.Model
        Its finite elements.
    nodal_diameter : int or None
        ND of a part whose faces are cyclic; None: it is in one piece.
    averaged : tuple of str
        Contact sets whose nodes stand for their patches.
    """

    model: Model
    nodal_diameter: int | None = None
    averaged: tuple[str, ...] = ()
    reach: None = None

    @cached_property
    def masters(self) -> Masters:
        """All its nodes."""
        part = self.model.part
        sets = {"everywhere": np.arange(len(part.points)), **part.node_sets}
        return choose(replace(part, node_sets=sets), tuple(sets), self.averaged)

    @cached_property
    def _transform(self) -> sp.csr_array:
        """(n, r) its free dofs from its coordinates."""
        if self.nodal_diameter is None:
            return sp.csr_array(sp.eye_array(self.model.K.shape[0]))
        return sp.csr_array(cyclic_transform(self.model, self.nodal_diameter))

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return int(self._transform.shape[1])

    @property
    def rest_loads(self) -> dict[str, Any]:
        """None."""
        return {}

    def at(self, nodal_diameter: int) -> SparseMatrices:
        """K and M, (r, r) sparse."""
        T, (_, *matrices) = self._transform, with_means(self.model, self.masters.averaged)
        return SparseMatrices(*(T.conj().T @ A @ T for A in matrices))

    def coordinates(
        self, nodes: NDArray[np.int64], where: str, directions: int = 3
    ) -> NDArray[np.int64]:
        """(k, 3) or (k, 6) coordinates of nodes off the faces: one unit entry in a row of T."""
        T, dofs = self._transform, self.model.dofs[nodes]
        found = np.where(dofs < 0, -1, T.indices[T.indptr[dofs]])
        return np.column_stack([found, np.full((len(nodes), directions - 3), -1)])

    def frames(self, nodes: NDArray[np.int64], where: str) -> NDArray[np.float64]:
        """(k, 3, 3) turn from Cartesian components to each node's cylindrical ones."""
        return cylindrical(self.masters.position(nodes))


def unreduced(assembly: Assembly, nodal_diameter: int) -> tuple[sp.csc_array, sp.csc_array]:
    """K and M of a sector of unreduced parts at a nodal diameter, every contact closed.

    Parameters
    ----------
    assembly : Assembly
        Parts, `UnreducedPart` of that nodal diameter, and their contacts and ties.
    nodal_diameter : int
        ND.

    Returns
    -------
    K, M : (n, n) sparse, Hermitian
        In joined coordinates.
    """
    here, there = assembly.relative_rows()
    B = here + there * phase_factor(nodal_diameter, assembly.sectors)
    springs = sp.diags_array(properties(assembly.contacts).stiffness.ravel())
    blocks = [part.at(nodal_diameter) for part in assembly.parts.values()]
    K, M = (assembly.merged.sum([getattr(each, name) for each in blocks]) for name in ("K", "M"))
    K = K + B.conj().T @ springs @ B
    return sp.csc_array((K + K.conj().T) / 2), sp.csc_array(M)


def unreduced_segment(
    vane: Model,
    casing: Model,
    joints: Sequence[Joint],
    diameter: int,
    averaged: Sequence[str] = (),
) -> tuple[sp.csc_array, sp.csc_array]:
    """K and M of the joined parts as they are; contact sets that are `averaged` on both sides."""
    hooks = tuple(name for name in averaged if name in HOOK_SETS)
    parts = (
        UnreducedPart(vane, None, tuple(averaged)),
        UnreducedPart(casing, diameter, hooks),
    )
    K, M = unreduced(Segment(tuple(joints)).assembly(*parts), diameter)
    return K, M
