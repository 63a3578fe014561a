"""The estimated error of a mesh against the true one, where the exact frequencies are known.

Waves of one displacement component, the others held, obey a scalar equation: in a free box they are
products of cosines, in a membrane that moves out of its plane those of a drum. The L-shaped drum
has a re-entrant edge, where the first mode is singular. Figures are estimated over true errors of
the frequencies, by the mesh's rows of elements along a side.
"""

import numpy as np
import pytest

from vanelock.fem import Material, assemble, eigenpairs, excess_stiffness
from vanelock.mesh import Part

QUADRATIC = ["tetra10", "hexahedron20", "hexahedron27"]
# Of hexahedra the smooth errors of regular meshes are overrated: patches of theirs hold less than
# their elements do.
MOST = {"tetra10": 3.0, "hexahedron20": 20.0, "hexahedron27": 20.0}
# (x, y, z) eigenvalues of -∇²u on the L of three unit squares, u = 0 around: L. N. Trefethen and
# T. Betcke, Computed eigenmodes of planar regions, Contemp. Math. 412 (2006) 297-314; the third
# is that of one square, 2π².
DRUM = [9.6397238440, 15.1972519265, 2 * np.pi**2]


def effectivity(model, component, free, exact, shift):
    """Estimated over true error of each frequency above zero, and the true ones."""
    rows = model.dofs[free, component]
    K, M = (A[rows][:, rows].tocsc() for A in (model.K, model.M))
    squared, shapes = eigenpairs(K, M, len(exact), shift=shift)
    u = np.zeros((len(model.part.points), 3, len(exact)))
    u[free, component] = shapes
    elastic = np.array(exact) > 0
    true = squared[elastic] / np.array(exact)[elastic] - 1
    form = np.diagonal(excess_stiffness(model, u))[elastic]
    return form / squared[elastic] / true, true


def record_mesh(record, n, found, true):
    """Put the figures of a mesh in the page."""
    ratios = ", ".join(f"{e:.2f}" for e in found)
    record(f"{n} rows", f"{ratios} of {true.min() / 2:.2g} to {true.max() / 2:.2g}")


@pytest.mark.parametrize("cell_type", QUADRATIC)
def test_waves_in_a_free_box(lattice, record, cell_type):
    material = Material(E=3.0, nu=0.0, rho=1.0)  # squared speeds: 3 along x, 1.5 across
    sides = np.array([1.0, 0.9, 1.1])
    orders = np.stack(np.meshgrid(*3 * [np.arange(3)], indexing="ij"), -1).reshape(-1, 3)
    exact = np.sort(((np.pi * orders / sides) ** 2) @ [3, 1.5, 1.5])[:7]
    for n in (3, 4, 6):
        model = assemble(lattice((n, n, n), lambda p: p * sides, cell_type), material)
        free = np.arange(len(model.part.points))
        found, true = effectivity(model, 0, free, exact, shift=-1.0)
        record_mesh(record, n, found, true)
        assert found.min() > 0.75
        assert found.max() < MOST[cell_type]


def membrane(lattice, n, cell_type):
    """One layer of elements over the L, and which nodes are not on its boundary."""
    whole = lattice((2 * n, 2 * n, 1), lambda p: p * [2, 2, 1 / n] - [1, 1, 0], cell_type)
    middle = whole.points[whole.cells].mean(axis=1)
    cells = whole.cells[(middle[:, 0] < 0) | (middle[:, 1] < 0)]
    used, cells = np.unique(cells, return_inverse=True)
    points = whole.points[used]
    x, y, _ = points.T
    around = (abs(x) > 1 - 1e-9) | (abs(y) > 1 - 1e-9) | ((x > -1e-9) & (y > -1e-9))
    part = Part("L", points, cells.reshape(-1, whole.cells.shape[1]), cell_type, {}, {}, 1)
    return part, np.flatnonzero(~around)


@pytest.mark.parametrize("cell_type", QUADRATIC)
def test_drum_with_a_re_entrant_edge(lattice, record, cell_type):
    material = Material(E=2.6, nu=0.3, rho=1.0)  # unit shear modulus
    for n in (4, 8):
        part, free = membrane(lattice, n, cell_type)
        found, true = effectivity(assemble(part, material), 2, free, DRUM, shift=0.0)
        record_mesh(record, n, found, true)
        assert found.min() > 0.75
        assert found.max() < MOST[cell_type]
