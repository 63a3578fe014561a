"""The route "cyclic": cyclic symmetry on the sparse matrices, then Craig-Bampton.

At each nodal diameter the right face follows the left one, and what is left is a part like any
other whose matrices are complex: its masters are those of contacts, loads and outputs alone, its
fixed-interface modes are cyclic ones, and no interface remains to be reduced. All nodal diameters
share one real factorisation (`vanelock.rom.routes.condensed`).
"""

from collections.abc import Iterable

import scipy.linalg as sl

from vanelock.rom.component import Component
from vanelock.rom.fixed_interface.held import HeldPart, hermitian
from vanelock.rom.fixed_interface.inertia import SectorInertia
from vanelock.rom.fixed_interface.projection import projected
from vanelock.rom.fixed_interface.selection import Selection
from vanelock.rom.routes.at_rest import Loads, held_loads
from vanelock.rom.routes.condensed import Condensed, Sector
from vanelock.rom.system.system import common_band


def cyclic_first(
    shared: Condensed, wanted: Selection, diameters: Iterable[int], loads: Loads | None = None
) -> Component:
    """Reduce a cyclic part at nodal diameters; all keep equally many fixed-interface vectors.

    Static answers to loads at rest are among those of nodal diameter 0.
    """
    problem = shared.problem
    parts, vectors, bands = {}, {}, []
    at_rest = None
    for k in diameters:
        parts[k] = at_diameter(shared, k)
        vectors[k], band = wanted.of(parts[k])
        bands.append(band)
        if k == 0 and loads:
            sector = parts[k].held
            assert isinstance(sector, Sector)
            at_rest = held_loads(shared, loads, sector)
            vectors[k], answers = at_rest.answered(vectors[k], parts[k])
    count = max(found.count for found in vectors.values())
    products = {k: projected(part, vectors[k].filled(part, count)) for k, part in parts.items()}
    return Component(
        masters=problem.masters,
        cyclic=True,
        route="cyclic",
        interface_modes=0,
        fixed_modes=count,
        diameters={k: p.reduced(p.vectors()) for k, p in products.items()},
        boundary_nodes=problem.masters.nodes,
        band=common_band(bands),
        loads=None if at_rest is None else at_rest.reduced(parts[0], products[0], answers),
    )


def at_diameter(shared: Condensed, nodal_diameter: int) -> HeldPart:
    """The sector at a nodal diameter, its masters held."""
    held = shared.held(nodal_diameter)
    masters = shared.answers.at(held.moved())
    W = held.follow.conj().T
    half = sl.solve_triangular(held.factor, W @ masters.reaching, lower=True)
    return HeldPart(
        held,
        M_ss=shared.answers.mass(held.follow),
        K_mm=hermitian(held.stiffness),
        M_mm=hermitian(masters.mass),
        inertia=SectorInertia(W @ masters.on_faces, masters.blocks, masters.coefficients),
        compliance=hermitian(masters.energy + half.conj().T @ half),
    )
