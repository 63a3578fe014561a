"""Craig-Bampton reduction of a part in one piece.

    { x_m }   [ I  0 ] { x_m }
    { x_s } = [ Ψ  B ] { η   },      Ψ = -K_ss⁻¹ K_sm,    B: fixed-interface modes and more,

R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
(1968) 1313-1319; which vectors B holds is documented in `vanelock.rom.fixed_interface.vectors`.
"""

from vanelock.rom.component import Component
from vanelock.rom.fixed_interface.held import HeldMatrices
from vanelock.rom.fixed_interface.projection import projected
from vanelock.rom.fixed_interface.selection import Selection
from vanelock.rom.routes.at_rest import Loads, held_loads
from vanelock.rom.routes.condensed import Condensed
from vanelock.rom.routes.rows import held_piece


def whole(shared: Condensed, wanted: Selection, loads: Loads | None = None) -> Component:
    """Reduce a part in one piece to its masters, fixed-interface vectors and answers to loads."""
    problem = shared.problem
    part = held_piece(HeldMatrices(shared.matrix, shared.interior), problem.M, problem.rows)
    chosen, band = wanted.of(part)
    at_rest = held_loads(shared, loads) if loads else None
    if at_rest is not None:
        chosen, answers = at_rest.answered(chosen, part)
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
        loads=None if at_rest is None else at_rest.reduced(part, products, answers),
    )
