"""A part as a file in Gmsh's own format, its node sets as physical groups.

Gmsh knows no sets of nodes. Each set becomes a point entity with a one-node element (`vertex`)
for each of its nodes, in the set's order, and a physical group of dimension 0 that bears its name;
the solid is the physical group of dimension 3 that bears the part's.
"""

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vanelock.common.files.files import placed
from vanelock.mesh.part import Part

SOLID = 1
"""Number of the solid's entity and physical group; the sets' follow."""


def write_msh(path: str | os.PathLike[str], part: Part) -> Path:
    """Write a part as a binary file of MSH 4.1, as a whole or not at all, and return the path.

    Node numbers are the part's, counted from 1.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    import meshio

    sets = {name: nodes for name, nodes in part.node_sets.items() if len(nodes)}
    tags = range(SOLID + 1, SOLID + 1 + len(sets))
    blocks = [(part.cell_type, part.cells), *(("vertex", n[:, None]) for n in sets.values())]
    numbers = [np.full(len(cells), i) for i, (_, cells) in enumerate(blocks, start=SOLID)]
    owners = _owners(len(part.points), list(sets.values()))
    mesh = meshio.Mesh(
        part.points,
        blocks,
        point_data={} if owners is None else {"gmsh:dim_tags": owners},
        cell_data={"gmsh:physical": numbers, "gmsh:geometrical": numbers},
        field_data={part.name: [SOLID, 3]} | {n: [t, 0] for n, t in zip(sets, tags, strict=True)},
    )
    target = Path(path)
    with placed(target) as temporary:
        # "gmsh" is version 4.1, which needs an entity for each group and a node for each entity.
        mesh.write(temporary, file_format="gmsh22" if owners is None else "gmsh", binary=True)
    return target


def _owners(count: int, sets: list[NDArray[np.int64]]) -> NDArray[np.int64] | None:
    """Dimension and tag (n, 2) of the entity that each node belongs to.

    A node has one owner though it may be in several sets; each set must own one at least, so the
    smaller sets choose first. None if a set is left with none, since others hold the same nodes.
    """
    owners = np.tile([3, SOLID], (count, 1))
    for place in sorted(range(len(sets)), key=lambda i: len(sets[i])):
        free = sets[place][owners[sets[place], 0] == 3]
        if not len(free):
            return None
        owners[free[0]] = 0, SOLID + 1 + place
    return owners
