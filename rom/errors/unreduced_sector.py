"""The unreduced cyclic sector: both parts' finite elements, joined with linear contact springs.

The reference for every reduction error; nothing here is a reduced-order model.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.cyclic import phase_factor
from vanelock.fem import Model, cyclic_transform
from vanelock.rom.joining.pairs import (
    HOOK_SETS,
    Joint,
    contact_pairs,
    key_pairs,
    merged_dofs,
    relative_rows,
)
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

    own, mate = key_pairs(*pieces)
    keys = vane.dofs[own].ravel()
    of_vane = merged_dofs(n_vane, n_casing, keys, casing_dofs(mate).ravel())
    n = n_casing + n_vane - len(keys)

    to_vane = sp.csr_array((np.ones(n_vane), (np.arange(n_vane), of_vane)), shape=(n_vane, n))
    to_casing = sp.hstack([T, sp.csr_array((T.shape[0], n - n_casing))]).tocsr()
    pairs = contact_pairs(*pieces, joints)
    here, there = relative_rows(
        pairs, lambda nodes: of_vane[vane.dofs[nodes]], casing_dofs, n, vane.part.sectors
    )
    B = here + there * phase_factor(nodal_diameter, vane.part.sectors)
    springs = sp.diags_array(pairs.contacts.stiffness.ravel())

    def joined(shell: sp.csc_array, blade: sp.csc_array) -> sp.csc_array:
        return sp.csc_array(to_casing.conj().T @ shell @ to_casing + to_vane.T @ blade @ to_vane)

    K = joined(shell[0], blade[0]) + B.conj().T @ springs @ B
    return sp.csc_array((K + K.conj().T) / 2), joined(shell[1], blade[1])
