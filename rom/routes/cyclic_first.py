"""The route "cyclic": cyclic symmetry on the sparse matrices, then Craig-Bampton.

At each nodal diameter the right face follows the left one, and what is left is a part like any
other whose matrices are complex: its masters are those of contacts, loads and outputs alone, its
fixed-interface modes are cyclic ones, and no interface remains to be reduced. All nodal diameters
share one real factorisation (`vanelock.rom.routes.condensed`).
"""

from collections.abc import Iterable

import scipy.sparse as sp

from vanelock.rom.component import Component
from vanelock.rom.fixed_interface.held import HeldPart, held_part
from vanelock.rom.fixed_interface.selection import Selection
from vanelock.rom.routes.condensed import Condensed
from vanelock.rom.routes.projection import projected
from vanelock.rom.system import common_band


def cyclic_first(shared: Condensed, wanted: Selection, diameters: Iterable[int]) -> Component:
    """Reduce a cyclic part at nodal diameters; all keep equally many fixed-interface vectors."""
    problem = shared.problem
    products, bands = {}, []
    for k in diameters:
        part = at_diameter(shared, k)
        chosen = wanted.within(part)
        products[k] = projected(part, chosen.of(part))
        bands.append(chosen.band)
    count = max(found.candidates.count for found in products.values())
    for k, found in products.items():
        if count > found.candidates.most:
            part = at_diameter(shared, k)
            products[k] = projected(part, found.candidates.filled(part, count))
    return Component(
        masters=problem.masters,
        cyclic=True,
        route="cyclic",
        interface_modes=0,
        fixed_modes=count,
        diameters={k: p.reduced(count, p.vectors(count)) for k, p in products.items()},
        boundary_nodes=problem.masters.nodes,
        band=common_band(bands),
    )


def at_diameter(shared: Condensed, nodal_diameter: int) -> HeldPart:
    """The sector at a nodal diameter, its masters held."""
    problem, t = shared.problem, shared.problem.rows
    T = shared.transform(nodal_diameter)
    adjoint = T.conj().T.tocsr()
    M_t = problem.M[:, t]
    return held_part(
        shared.held(nodal_diameter),
        sp.csc_array(adjoint @ M_t),
        sp.csc_array(adjoint @ (problem.M @ T)),
        M_t[t],
    )
