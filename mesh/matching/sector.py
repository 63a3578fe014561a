"""Read anyone's part, or sector of a cyclic structure, from a mesh file."""

import os
from pathlib import Path

import numpy as np

from vanelock.common.errors import InputError
from vanelock.mesh.files.read import read_mesh
from vanelock.mesh.matching.pairing import TOLERANCE, follow
from vanelock.mesh.matching.side import OwnPart, Side, check_cut_faces
from vanelock.mesh.part import Part, called

_KNOWN = ("fixed", "left", "right", "force", "output")


def read_sector(
    path: str | os.PathLike[str], sectors: int = 1, unit: str = "m", tolerance: float = TOLERANCE
) -> Part:
    """Read a part with all sets of its file, its cyclic faces matched.

    Parameters
    ----------
    path : path
        Of any format that `read_mesh` reads.
    sectors : int
        Sectors N in the ring, which need the sets `left` and `right`; 1 if the part is whole.
    unit : str
        Of its coordinates, such as "mm".
    tolerance : float
        How far a node of `right` may lie from its mate in `left` turned by 2π/N, m; it is then
        moved there.

    Returns
    -------
    Part
        Called like the file. Sets have the file's names, those that the later stages know also in
        lower case. Without contact frames.

    Raises
    ------
    InputError
        If the file cannot be used, a face or some of its nodes are missing, or the faces do
        not match.

    Examples
    --------
    Two-nodal-diameter modes of a ring of 16 such sectors::

        part = mesh.read_sector("sector.msh", sectors=16)
        modes = fem.modes(fem.assemble(part, fem.Material(E=210e9, nu=0.3, rho=7800)), 10, 2)
    """
    found = read_mesh(path, unit)
    sets = dict(found.node_sets)
    for name in _KNOWN:
        if (alike := called(found.node_sets, name)) is not None:
            sets[name] = found.node_sets[alike]
    side = Side(OwnPart(Path(path).stem, found, sets, {}), sectors)
    if sectors > 1:
        for name in ("left", "right"):
            if not len(sets.get(name, np.empty(0))):
                have = ", ".join(sorted(found.node_sets)) or "none"
                raise InputError(f"{found.source}: no set {name}; it has {have}")
        problems = follow(side, "left", "right", tolerance)
        if problems := problems or check_cut_faces(side, tolerance):
            raise InputError("\n".join(problems))
    return side.part()
