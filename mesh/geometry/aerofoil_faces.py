"""The faces of a vane segment's surface that belong to each aerofoil."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from vanelock.common.errors import InputError
from vanelock.mesh.cells import solid
from vanelock.mesh.exterior import exterior
from vanelock.mesh.geometry.dimensions import VaneDimensions
from vanelock.mesh.part import Part

ON = 1e-5
"""Nodes lie on a shroud's surface within this, m."""


def aerofoil_faces(part: Part, dimensions: VaneDimensions) -> tuple[NDArray[np.int64], ...]:
    """(f, 6) nodes of the faces of each aerofoil, by ascending angle, root fillets included."""
    inner, outer = dimensions.inner_shroud_outer_radius, dimensions.outer_shroud_inner_radius
    faces = exterior(part.cells, solid(part.cell_type))
    radius = np.hypot(*part.points.T[:2])[faces]
    between = ((radius > inner - ON) & (radius < outer + ON)).all(axis=1)
    shroud = (radius < inner + ON).all(axis=1) | (radius > outer - ON).all(axis=1)
    faces = faces[between & ~shroud]
    rows = np.repeat(np.arange(len(faces)), faces.shape[1])
    shape = len(faces), len(part.points)
    touches = csr_array((np.ones(faces.size), (rows, faces.ravel())), shape=shape)
    count, piece = connected_components(touches @ touches.T, directed=False)
    if count != dimensions.aerofoils:
        raise InputError(f"{part.name}: {count} surfaces between the shrouds, not one an aerofoil")
    middle = [part.points[faces[piece == i, :3]].mean(axis=(0, 1)) for i in range(count)]
    order = np.argsort([np.arctan2(y, x) for x, y, _ in middle])
    return tuple(faces[piece == i] for i in order)
