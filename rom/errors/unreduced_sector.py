"""The unreduced cyclic sector: both parts' finite elements, joined with linear contact springs.

The reference for every reduction error; nothing here is a reduced-order model.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.cyclic import phase_factor, turn
from vanelock.fem import Model, cyclic_transform
from vanelock.rom.joining.elements import properties
from vanelock.rom.joining.joined import merged, relative_rows
from vanelock.rom.joining.pairs import HOOK_SETS, Joint, contact_pairs, key_tie
from vanelock.rom.joining.patches import with_means
from vanelock.rom.masters import everything


def unreduced(
    vane: Model,
    casing: Model,
    joints: Sequence[Joint],
    nodal_diameter: int,
    averaged: Sequence[str] = (),
) -> tuple[sp.csc_array, sp.csc_array]:
    """K and M of the sector at a nodal diameter, every given joint closed.

    Parameters
    ----------
    vane, casing : fem.Model
        The parts; the casing's faces are cyclic, the vane continues through the interlock only.
    joints : sequence of Joint
        Joints whose contacts are linear springs; the others are open.
    nodal_diameter : int
        ND.
    averaged : sequence of str
        The vane's contact sets whose nodes, and their mates, stand for their patches.

    Returns
    -------
    K, M : (n, n) sparse, Hermitian
        In the cyclic casing's coordinates, then the vane's without its key nodes.
    """
    T = sp.csr_array(cyclic_transform(casing, nodal_diameter))
    n_casing, n_vane = T.shape[1], vane.K.shape[0]
    pieces = (
        everything(vane.part, averaged),
        everything(casing.part, [name for name in averaged if name in HOOK_SETS]),
    )
    _, *blade = with_means(vane, pieces[0].averaged)
    _, *shell = with_means(casing, pieces[1].averaged)

    def casing_dofs(nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        # A node off the faces has a coordinate of its own: one unit entry in its row of T.
        return np.asarray(T.indices[T.indptr[casing.dofs[nodes]]], np.int64)

    tie = key_tie(*pieces)
    keys = casing_dofs(tie.mate_nodes).ravel(), n_casing + vane.dofs[tie.own_nodes].ravel()
    joined = merged((n_casing, n_vane), [np.column_stack(keys)])

    def places(part: str, nodes: NDArray[np.int64], where: str) -> NDArray[np.int64]:
        if part == "vane":
            return joined.of(1, vane.dofs[nodes])
        return joined.of(0, casing_dofs(nodes))

    contacts, N = contact_pairs(*pieces, joints), vane.part.sectors
    here, there = relative_rows(contacts, joined, places, turn(N))
    B = here + there * phase_factor(nodal_diameter, N)
    springs = sp.diags_array(properties(contacts).stiffness.ravel())
    K, M = (joined.sum((T.conj().T @ A @ T, D)) for A, D in zip(shell, blade, strict=True))
    K = K + B.conj().T @ springs @ B
    return sp.csc_array((K + K.conj().T) / 2), sp.csc_array(M)
