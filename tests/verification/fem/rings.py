"""A quarter of a ring under loads whose stresses are known, meshed and solved."""

from itertools import pairwise

import numpy as np

from tests.conftest import FULL
from vanelock.fem import factorise

COUNTS = (4, 8, 16) if FULL else (4, 8)
"""Elements along a side."""


def quarter(lattice, counts, walls, length, cell_type, warp=0.0):
    """It lies between two walls; its elements are distorted if asked."""

    def place(p):
        x, y, z = p.T
        r = walls[0] + np.diff(walls) * (x + warp * np.sin(np.pi * x) * np.sin(4 * y))
        t = np.pi / 2 * (y + warp * np.sin(2 * np.pi * y))
        return np.column_stack([r * np.cos(t), r * np.sin(t), length * z])

    return lattice(counts, place, cell_type, curved=True)


def solved(model, load, **held):
    """Displacements (nodes, 3), m, with components of node sets held: x0="x", and so on."""
    free = np.ones(model.dofs.shape, bool)
    for name, axes in held.items():
        free[np.ix_(model.part.node_sets[name], ["xyz".index(axis) for axis in axes])] = False
    rows = np.flatnonzero(free.ravel())
    u = np.zeros(free.size)
    u[rows] = factorise(model.K[rows][:, rows].tocsc()).solve(load[rows])
    return u.reshape(free.shape)


def cylindrical(part, radial, hoop, axial):
    """(nodes, 6) stress from its components along r, θ and z."""
    r = np.hypot(*part.points.T[:2])
    c, s = part.points[:, 0] / r, part.points[:, 1] / r
    xx, yy = radial * c**2 + hoop * s**2, radial * s**2 + hoop * c**2
    return np.column_stack([xx, yy, 0 * r + axial, 0 * r, 0 * r, (radial - hoop) * c * s])


def orders(record, errors):
    """Record errors of meshes, each twice as fine as the one before, and return their orders."""
    for n, error in zip(COUNTS, errors, strict=True):
        record(f"{n} elements", f"{error:.2e}")
    found = [float(np.log2(a / b)) for a, b in pairwise(errors)]
    record("order", ", ".join(f"{order:.2f}" for order in found))
    return found
