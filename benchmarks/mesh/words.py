"""What the page of the mesh study says around its tables."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.mesh.families import CURVED, STRAIGHT, Row

Floats = NDArray[np.float64]

INTRODUCTION = """\
The first ten elastic modes of the free vane segment of the default dimensions. `tetra10` are the
program's curved quadratic tetrahedra; "straight" are the same with mid-side nodes on their chords;
`tetra` keeps the corners alone. Hexahedra come from blocks (vane_blocks.py): rows of quadrilaterals
between axial stations, swept radially, all curved walls met by the nodes; 27 nodes, 20, or 8.
"Size" is the largest edge of a tetrahedron and about the edge of a hexahedron along the walls, one
element through shrouds, legs and aerofoils unless the size is smaller than these.

Errors are relative to the limit of refined hexahedra (below). Costs are CPU times on one thread, in
units of assembly, factorisation and modes of tetra10 at {base}, {dofs} dofs ({unit:.2f} s).
Order: of the mean error, against the size."""
RATES = """\
Dofs and CPU time, without meshing, that a mean error takes, interpolated between the meshes; in
brackets as multiples of tetra10's."""
REFERENCE = """\
Aerofoils meet shrouds, and legs meet shroud and feet, at sharp re-entrant edges, where
displacements grow as r^0.54 and every uniform mesh converges at an order near one, quadratic or
not. The reference halves hexahedra everywhere, those at re-entrant edges being six times smaller,
and extrapolates with the order {order:.2f} of such edges. With the orders seen, which are those of
meshes that do not resolve them fully yet, it would lie {doubt:.2%} lower on average and {worst:.2%}
at most: differences of errors below that mean nothing. tetra10, from another program, come down to
{above:.2%} above the reference on average at their smallest size and do not pass it."""
NAMED = """\
Curved against straight sides, the same elements. Straightened: elements of which a side had to be
drawn back towards its chord to keep the Jacobian. Long band elements: as long along the hooks'
bands and the interlock's rows as two contact nodes are apart, whatever the size. The vane is free,
its errors relative to the limit above; the casing is clamped, at nodal diameter 1, its errors
relative to the limit of two meshes refined towards its corners."""
JOINED = """\
The second frequency at nodal diameter 1, the hooks as springs and the interlock free or stuck, all
contacts on area patches, without reduction. Differences are those from the last row, which is
itself not converged: what the vane is off by above remains."""


def conclusion(
    groups: dict[str, list[Row]],
    exact: Floats,
    needed: Callable[..., Any],
    mean: Callable[[Row, Floats], float],
) -> list[str]:
    """What follows, in sentences."""
    target = 0.03
    usual = needed(groups[CURVED], exact, target)
    lines = [
        "**Chosen: curved quadratic tetrahedra.** Any shape meshes by itself: fillets, twist,",
        "bosses, other counts of aerofoils. Blocks of hexahedra suit one topology without these.",
        "",
    ]
    for name in ("hexahedron20", "hexahedron27"):
        own = needed(groups[name], exact, target)
        if own and usual:
            lines.append(
                f"- For a mean error of {target:.0%} {name} takes {own[0] / usual[0]:.2f} times "
                f"the dofs and {own[1] / usual[1]:.2f} times the CPU time of tetra10: the price of "
                "the choice."
            )
    local = groups["hexahedron20, local"][-2]
    even = min(groups["hexahedron20"], key=lambda row: abs(np.log(row.dofs / local.dofs)))
    lines.append(
        "- All families converge at an order near one, since sharp re-entrant edges limit them "
        "all: halving the elements halves the error. Smaller elements at those edges gain little "
        f"({mean(local, exact):.2%} with {local.dofs} dofs, against {mean(even, exact):.2%} with "
        f"{even.dofs} evenly spread). All errors of curved elements are positive: too stiff. "
        "Linear elements of either shape are out of the question."
    )
    chords = [row.frequency[0] / exact[0] - 1 for row in groups[STRAIGHT]]
    lines.append(
        "- Straight sides come out closer at these sizes because two errors cancel: chords cut off "
        "parts of the aerofoils' rounded edges, which softens what the elements stiffen. The first "
        f"frequency is off by {', '.join(f'{c:+.1%}' for c in chords)} as "
        "they are refined, so that a change from mesh to mesh is no measure of the error; with "
        "curved sides frequencies fall towards the limit, and bands and walls are in place."
    )
    return lines
