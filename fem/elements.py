"""Quadrature of elements, and the stiffness and mass made by it.

The quadrature rule of degree 5 with 14 points on the tetrahedron:
Walkington, Quadrature on simplices of arbitrary dimension, Carnegie Mellon University, 2000. Two
points lie on each line from a corner to the middle of the opposite face, and two on each line that
joins the middles of opposite edges. (scikit-fem's tables of degrees 5 to 8 miss moments by 1e-6 to
2e-5, measured.)

Stiffness and mass are batched matrix products over blocks of elements:

    K_ai,bj = ∫ λ N_a,i N_b,j + μ N_a,j N_b,i + μ δ_ij N_a,k N_b,k      M_ai,bj = δ_ij ∫ ρ N_a N_b

for basis functions a, b and components i, j (any textbook, for instance Hughes, The Finite Element
Method, 2.8 and 7.2). All of K follows from the products ∫ N_a,i N_b,j, which are one matrix
product over the quadrature points of each element. Both matrices are assembled as one half, H,
that holds every pair of an element's nodes once; K = H + Hᵀ is then symmetric to the last bit.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import scipy.sparse as sp
from skfem import quadrature

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.model import Material, Model
from vanelock.mesh import FileMesh, Part
from vanelock.mesh.cells import linear_type, solid
from vanelock.mesh.part import called

_TOWARDS_CORNERS = (  # barycentric coordinate of three corners, share of the volume
    (0.31088591926330060980, 0.11268792571801585080),
    (0.092735250310891226402, 0.073493043116361949544),
)
_TOWARDS_EDGES = (0.045503704125649649492, 0.042546020777081466438)  # that of two corners


def _tetrahedron_rule() -> tuple[Floats, Floats]:
    """Points (14, 3) on the reference tetrahedron and weights (14,), which sum to 1/6."""
    places, shares = [], []
    for coordinate, share in _TOWARDS_CORNERS:
        for corner in range(4):
            place = np.full(4, coordinate)
            place[corner] = 1 - 3 * coordinate
            places.append(place)
            shares.append(share)
    coordinate, share = _TOWARDS_EDGES
    for pair in combinations(range(4), 2):
        place = np.full(4, 0.5 - coordinate)
        place[list(pair)] = coordinate
        places.append(place)
        shares.append(share)
    return np.array(places)[:, 1:], np.array(shares) / 6


_DEGREES = {"tetra": 2, "tetra10": 5, "hexahedron": 3, "hexahedron20": 5, "hexahedron27": 5}
"""That the quadrature integrates exactly. Mass and stiffness of a straight-sided element need no
more, but curved sides do: in tetra10 degree 4 is 2e-3 off the exact integrals in a study's
frequencies on a medium mesh, and degree 5, with 14 points instead of 11, 5e-4."""


@dataclass(frozen=True)
class _ReferenceElement:
    """Basis functions of one element type at its quadrature points, on the reference cell."""

    values: Floats  # (q, k), basis function of each node
    gradients: Floats  # (q, k, 3), its derivatives
    points: Floats  # (q, 3), quadrature points
    weights: Floats  # (q,), quadrature weights; they sum to the cell's volume


def reference_element(cell_type: str) -> _ReferenceElement:
    """Tables of a cell type, by meshio's name."""
    cell = solid(cell_type)
    if cell_type == "tetra10":
        points, weights = _tetrahedron_rule()
    else:
        places, weights = quadrature.get_quadrature(cell.element.refdom, _DEGREES[cell_type])
        points = places.T
    return _ReferenceElement(*cell.functions(points), points, weights)


def sampling(cell_type: str) -> tuple[Floats, Floats]:
    """Where the strains of an element are best, and how they reach its nodes."""
    cell, corners = solid(cell_type), solid(linear_type(cell_type))
    places, _ = quadrature.get_quadrature(
        cell.element.refdom, {"tetra": 1, "tetra10": 2}.get(cell_type, 3)
    )
    points = np.ascontiguousarray(places.T)
    if len(points) == 1:
        return points, np.ones((len(cell.nodes), 1))
    at_points, at_nodes = (corners.functions(at)[0] for at in (points, cell.nodes))
    return points, at_nodes @ np.linalg.inv(at_points)


_BLOCK = 256  # elements at once: some 5 MB for tetra10, near the processor's cache


def assemble(part: Part | FileMesh, material: Material, fixed: str | None = "fixed") -> Model:
    """Assemble the stiffness and mass of a part.

    Parameters
    ----------
    part : Part or FileMesh
        Mesh of tetra10, tetra, hexahedron, hexahedron20 or hexahedron27; curved sides are allowed.
        One that `read_mesh` gives is taken as a whole part with the file's node sets.
    material : Material
        Its material.
    fixed : str or None
        Set of clamped nodes. The default is ignored where the part has no such set, which is then
        free; `None` clamps nothing.

    Raises
    ------
    InputError
        If the set or the element type does not exist, or an element is turned inside out.

    Examples
    --------
    >>> import numpy as np
    >>> from vanelock.mesh import FileMesh, Part
    >>> corner = np.vstack([np.zeros(3), np.eye(3)])
    >>> part = Part("tetrahedron", corner, np.arange(4)[None], "tetra", {}, {}, 1)
    >>> model = assemble(part, Material(E=210e9, nu=0.3, rho=6000.0))
    >>> print(model.K.shape, round(model.M.sum() / 3, 6))  # a sixth of a cubic metre
    (12, 12) 1000.0
    """
    part = part.part() if isinstance(part, FileMesh) else part
    reference = reference_element(part.cell_type)
    if part.cells.shape[1] != (needed := reference.values.shape[1]):
        raise InputError(
            f"{part.name}: cells have {part.cells.shape[1]} nodes, {part.cell_type} needs {needed}"
        )
    number = _free_numbers(part, fixed)
    stiffness, mass, rows, columns = _halves(part, material, number, reference)
    n = int(number.max()) + 1
    K = _symmetric(sp.bsr_array((stiffness, columns, rows), shape=(3 * n, 3 * n)).tocsr())
    m = _symmetric(sp.csr_array((mass, columns, rows), shape=(n, n)))
    M = sp.kron(m, sp.eye_array(3), format="csc")
    M.sort_indices()
    dofs = np.where(number[:, None] < 0, -1, 3 * number[:, None] + np.arange(3))
    return Model(part, material, K, M, dofs)


def _free_numbers(part: Part, fixed: str | None) -> Integers:
    """Consecutive numbers of the free nodes, -1 for clamped ones."""
    clamped: Integers = np.empty(0, np.int64)
    if fixed is not None and (own := called(part.node_sets, fixed)) is not None:
        clamped = part.node_sets[own]
    elif fixed not in (None, "fixed"):
        have = ", ".join(sorted(part.node_sets)) or "none"
        raise InputError(f"{part.name}: fixed = {fixed!r}: no such node set; it has {have}")
    free = np.ones(len(part.points), bool)
    free[clamped] = False
    if not free.any():
        raise InputError(f"{part.name}: the set {fixed!r} clamps every node")
    return np.where(free, np.cumsum(free) - 1, -1)


def _halves(
    part: Part, material: Material, number: Integers, reference: _ReferenceElement
) -> tuple[Floats, Floats, Array, Array]:
    """Half of the stiffness (p, 3, 3) and mass (p,) on node pairs in CSR order, and that order.

    Returns the values, the row pointers (nodes + 1) and the columns (p,).
    """
    first, second = np.triu_indices(part.cells.shape[1])
    once = np.where(first == second, 0.5, 1.0)
    n = int(number.max()) + 1
    nodes = number[part.cells]
    a, b = nodes[:, first], nodes[:, second]
    keys = np.where((a < 0) | (b < 0), n * n, a * n + b)  # what touches a clamped node goes last
    pairs, slot = np.unique(keys, return_inverse=True)
    slot = slot.reshape(keys.shape).astype(np.int32)
    stiffness = np.zeros((len(pairs), 9))
    mass = np.zeros(len(pairs))
    for start in range(0, len(slot), _BLOCK):
        block = slice(start, start + _BLOCK)
        k, m = _element_matrices(part, block, material, reference)
        here, values = _sum_by_slot(
            slot[block].ravel(),
            (k[:, :, first, :, second] * once[:, None, None, None]).transpose(1, 0, 2, 3),
            m[:, first, second] * once,
        )
        stiffness[here] += values[:, :9]
        mass[here] += values[:, 9]
    kept = int(np.searchsorted(pairs, n * n))
    row, column = np.divmod(pairs[:kept], n)
    pointers = np.searchsorted(row, np.arange(n + 1)).astype(np.int32)
    return stiffness[:kept].reshape(-1, 3, 3), mass[:kept], pointers, column.astype(np.int32)


def _sum_by_slot(slot: Integers, k: Floats, m: Floats) -> tuple[Integers, Floats]:
    """Distinct slots of a block and the sums (s, 10) of what goes there: nine of K, one of M."""
    order = np.argsort(slot, kind="stable")
    ordered = slot[order]
    starts = np.flatnonzero(np.diff(ordered, prepend=-1))
    gather = sp.csr_array(
        (np.ones(len(order)), order, np.append(starts, len(order))), shape=(len(starts), len(order))
    )
    values = np.empty((len(order), 10))
    values[:, :9] = k.reshape(-1, 9)
    values[:, 9] = m.ravel()
    return ordered[starts], gather @ values


def _element_matrices(
    part: Part, block: slice, material: Material, reference: _ReferenceElement
) -> tuple[Floats, Floats]:
    """Stiffness (e, 3, k, 3, k) and scalar mass (e, k, k) of a block of elements."""
    points = part.points[part.cells[block]].transpose(2, 0, 1)  # (3, e, k)
    slopes = reference.gradients.transpose(2, 1, 0)  # (3, k, q)
    cofactor, determinant = _cofactors(points[:, None] @ slopes)
    if not determinant.min() > 0:  # catches what is not a number, too
        bad = block.start + int(np.argmin(determinant.min(axis=1)))
        raise InputError(f"{part.name}: element {bad} is turned inside out or has no volume")
    weights = determinant * reference.weights
    e, k, q = points.shape[1], *slopes.shape[1:]
    gradient = np.einsum("jaq,ijeq->eiaq", slopes, cofactor / determinant).reshape(e, 3 * k, q)
    weighted = gradient * weights[:, None]
    product = (weighted @ gradient.transpose(0, 2, 1)).reshape(e, 3, k, 3, k)
    lame, shear = material.lame
    stiffness = lame * product + shear * product.transpose(0, 3, 2, 1, 4)
    laplace = shear * np.einsum("eiaib->eab", product)
    for i in range(3):
        stiffness[:, i, :, i] += laplace
    values = reference.values
    pair = (values[:, :, None] * values[:, None]).reshape(q, k * k)
    mass = material.rho * (weights @ pair).reshape(e, k, k)
    return stiffness, mass


def _cofactors(jacobian: Floats) -> tuple[Floats, Floats]:
    """Cofactors and determinant of 3 x 3 matrices in the first two axes; J⁻ᵀ is their ratio."""
    after, before = [1, 2, 0], [2, 0, 1]
    cofactor = jacobian[after][:, after] * jacobian[before][:, before]
    cofactor -= jacobian[after][:, before] * jacobian[before][:, after]
    return cofactor, np.sum(jacobian[0] * cofactor[0], axis=0)


def _symmetric(half: sp.csr_array) -> sp.csc_array:
    """H + Hᵀ in compressed columns; equal to its rows, as it is symmetric."""
    whole = (half + half.T).tocsr()
    whole.sort_indices()
    return sp.csc_array((whole.data, whole.indices, whole.indptr), shape=whole.shape)
