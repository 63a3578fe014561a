"""The route "paper": Craig-Bampton with every face dof a master, cyclic symmetry, Tran."""

from collections.abc import Iterable

from vanelock.rom.component import Component, Reduced
from vanelock.rom.fixed_interface.held import hermitian
from vanelock.rom.fixed_interface.selection import Selection
from vanelock.rom.routes.craig_bampton import CraigBampton, craig_bampton
from vanelock.rom.routes.cyclic import cyclic_constraint
from vanelock.rom.routes.problem import Problem
from vanelock.rom.routes.tran import interface_basis


def paper(
    problem: Problem,
    wanted: Selection,
    diameters: Iterable[int],
    interface_modes: int,
) -> Component:
    """Reduce a cyclic part exactly as published, at nodal diameters."""
    dense = craig_bampton(problem, wanted)
    return Component(
        masters=problem.masters,
        cyclic=True,
        route="paper",
        interface_modes=interface_modes,
        fixed_modes=dense.fixed_modes.shape[1],
        diameters={k: _at_diameter(problem, dense, k, interface_modes) for k in diameters},
        boundary_nodes=problem.boundary_nodes,
        vectors=dense.fixed_modes,
    )


def _at_diameter(
    problem: Problem,
    part: CraigBampton,
    nodal_diameter: int,
    interface_modes: int,
) -> Reduced:
    """Cyclic symmetry, then Tran, of Craig-Bampton matrices with the two faces first."""
    faces, masters = len(problem.left), len(problem.rows)
    sectors = problem.model.part.sectors
    W_cs = cyclic_constraint(faces, len(part.K) - 6 * faces, nodal_diameter, sectors)
    K = W_cs.conj().T @ (part.K @ W_cs)
    M = W_cs.conj().T @ (part.M @ W_cs)
    W = interface_basis(K, M, 3 * faces, masters, interface_modes)
    return Reduced(hermitian(W.conj().T @ K @ W), hermitian(W.conj().T @ M @ W), basis=W_cs @ W)
