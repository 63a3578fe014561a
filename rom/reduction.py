"""From a finite-element model to a component: Craig-Bampton, cyclic symmetry, Tran."""

from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.fem import Model, cyclic_faces
from vanelock.rom.component import Component, Reduced
from vanelock.rom.craig_bampton import CraigBampton, craig_bampton
from vanelock.rom.cyclic import cyclic_constraint
from vanelock.rom.masters import choose
from vanelock.rom.tran import Interface, interface_basis

Route = Literal["paper"]


def reduce(
    model: Model,
    masters: Sequence[str],
    modes: int = 10,
    nodal_diameters: Iterable[int] | None = None,
    route: Route = "paper",
    interface: Interface = "published",
    interface_modes: int = 10,
) -> Component:
    """Reduce one part to its master nodes and a few modes.

    Parameters
    ----------
    model : fem.Model
        Sparse stiffness and mass of the part.
    masters : sequence of str
        Node sets whose displacements are kept, in this order. The cyclic faces `left` and `right`
        are masters by themselves where the part is cyclic.
    modes : int
        Fixed-interface modes kept.
    nodal_diameters : iterable of int, optional
        Reduce a cyclic part at these diameters; None: the part is in one piece.
    route : "paper"
        Craig-Bampton with every face dof a master, then cyclic symmetry, then Tran.
    interface : "published" or "followed"
        Basis of the face, see `vanelock.rom.tran`.
    interface_modes : int
        Face modes kept; at most the face's dofs.

    Raises
    ------
    InputError
        If a set is missing or clamped, or a count is out of range.
    """
    if route != "paper":
        raise InputError(f'route = "{route}": allowed is "paper"')
    part = model.part
    kept = choose(part, tuple(masters))

    cyclic = nodal_diameters is not None
    if not cyclic:
        reduced = craig_bampton(model, kept.nodes, modes)
        diameters = {0: Reduced(reduced.K, reduced.M)}
        interface_modes = 0
    else:
        left, right = _free_faces(model)
        if shared := sorted(set(kept.nodes) & {*left, *right}):
            raise InputError(f"{part.name}: node {shared[0]} is a master and on a cyclic face")
        if not 1 <= interface_modes <= 3 * len(left):
            raise InputError(
                f"interface_modes = {interface_modes}: allowed are 1 to {3 * len(left)}, "
                "the dofs of a face"
            )
        reduced = craig_bampton(model, np.concatenate([left, right, kept.nodes]), modes)
        diameters = {
            k: _at_diameter(reduced, len(left), k, part.sectors, interface, interface_modes)
            for k in sorted({k % part.sectors for k in nodal_diameters or ()})
        }
    return Component(
        masters=kept,
        cyclic=cyclic,
        interface_modes=interface_modes,
        diameters=diameters,
        boundary_nodes=reduced.nodes,
        fixed_modes=reduced.fixed_modes,
        fixed_frequencies=reduced.fixed_frequencies,
    )


def _free_faces(model: Model) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Matching nodes of the left and right faces, those of clamped edges left out."""
    left, right = cyclic_faces(model.part, model.part.sectors)
    free = model.dofs[left, 0] >= 0
    if np.any(alone := free != (model.dofs[right, 0] >= 0)):
        raise InputError(
            f"{model.part.name}: node {left[alone][0]} of `left` and its mate {right[alone][0]} of "
            "`right`: one is clamped, the other free"
        )
    return left[free], right[free]


def _at_diameter(
    part: CraigBampton,
    faces: int,
    nodal_diameter: int,
    sectors: int,
    interface: Interface,
    interface_modes: int,
) -> Reduced:
    """Cyclic symmetry, then Tran, of Craig-Bampton matrices with the two faces first."""
    W_cs = cyclic_constraint(faces, len(part.K) - 6 * faces, nodal_diameter, sectors)
    K = W_cs.conj().T @ (part.K @ W_cs)
    M = W_cs.conj().T @ (part.M @ W_cs)
    masters = 3 * (len(part.nodes) - 2 * faces)
    W = interface_basis(K, M, 3 * faces, masters, interface_modes, interface)
    K, M = W.conj().T @ K @ W, W.conj().T @ M @ W
    return Reduced((K + K.conj().T) / 2, (M + M.conj().T) / 2, W_cs @ W)
