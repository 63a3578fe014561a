"""Craig-Bampton reduction of a part in one piece.

    { x_m }   [ I  0 ] { x_m }
    { x_s } = [ Ψ  B ] { η   },      Ψ = -K_ss⁻¹ K_sm,    B: fixed-interface modes and more,

R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
(1968) 1313-1319; which vectors B holds is documented in `vanelock.rom.fixed_interface.vectors`.
"""

from vanelock.rom.component import Component
from vanelock.rom.fixed_interface.held import HeldMatrices
from vanelock.rom.fixed_interface.selection import Selection
from vanelock.rom.routes.condensed import Condensed
from vanelock.rom.routes.projection import projected
from vanelock.rom.routes.rows import held_piece


def whole(shared: Condensed, wanted: Selection) -> Component:
    """Reduce a part in one piece to its masters and fixed-interface vectors."""
    problem = shared.problem
    part = held_piece(HeldMatrices(shared.matrix, shared.interior), problem.M, problem.rows)
    chosen, band = wanted.of(part)
    products = projected(part, chosen)
    count = products.candidates.count
    return Component(
        masters=problem.masters,
        cyclic=False,
        route="whole",
        interface_modes=0,
        fixed_modes=count,
        diameters={0: products.reduced()},
        boundary_nodes=problem.boundary_nodes,
        vectors=products.vectors(),
        band=band,
    )
