"""Linear modes of a model, K x = λ M x, by shift-invert block Lanczos: free, clamped or cyclic."""

import math
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.cyclic import phase_factor, turn
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.fem.block_lanczos import krylov_space, lowest_modes
from vanelock.fem.model import Model
from vanelock.fem.solvers.backend import Factor
from vanelock.fem.solvers.factor import factorise
from vanelock.mesh import Part
from vanelock.mesh.part import called

_TOLERANCE = 1e-6  # of the part's size: how far a face node may lie from its mate's image


def cyclic_transform(model: Model, nodal_diameter: int, sectors: int | None = None) -> sp.csc_array:
    """Transformation x = T y of the free dofs of a sector that vibrates at one nodal diameter.

    A wave of nodal diameter k repeats itself from one sector to the next, turned by 2π/N about
    the axis z and delayed by φ = 2π k/N, so that the faces obey

        u_right = R_z(2π/N) u_left e^{-iφ},

    and the sector's matrices become Tᴴ K T, Tᴴ M T. Those of k and N - k are complex conjugates.

    Parameters
    ----------
    model : Model
        One sector, whose part has the sets `left` and `right`.
    nodal_diameter : int
        k, taken modulo N.
    sectors : int, optional
        N, at least 2; by default that of the part.

    Returns
    -------
    (n, n_c) csc_array
        Real for k = 0 and k = N/2, else complex. Its columns are the model's dofs without those
        of the right face, in the same order. A face node whose mate is clamped is held too. A
        node on the axis is its own mate and keeps the motions that the wave allows there; their
        columns come last.

    Raises
    ------
    InputError
        If a face is missing, or the right one is not the left one turned by 2π/N.

    Notes
    -----
    After D. L. Thomas, Dynamics of rotationally periodic structures, Int. J. Numer. Meth. Engng
    14 (1979) 81-102, written in Cartesian components.
    """
    part = model.part
    sectors = part.sectors if sectors is None else sectors
    left, right = cyclic_faces(part, sectors)
    follow = turn(sectors) * phase_factor(nodal_diameter, sectors)
    n = model.K.shape[0]
    on_axis = left == right
    centre = model.dofs[left[on_axis]]
    centre = centre[centre[:, 0] >= 0]
    l_rows, r_rows = model.dofs[left[~on_axis]], model.dofs[right[~on_axis]]
    l_free, r_free = l_rows[:, 0] >= 0, r_rows[:, 0] >= 0
    dependent = [r_rows[r_free], l_rows[l_free & ~r_free], centre]
    kept = np.setdiff1d(np.arange(n), np.concatenate(dependent))
    column = np.full(n, -1)
    column[kept] = np.arange(len(kept))

    mates = l_free & r_free
    rows = np.repeat(r_rows[mates], 3)  # each row of a right node takes three left ones
    columns = column[np.repeat(l_rows[mates], 3, axis=0)].ravel()
    values = np.tile(follow.ravel(), int(mates.sum()))
    allowed = scipy.linalg.null_space(follow - np.eye(3), rcond=1e-9)  # of a node on the axis
    spread = np.arange(centre.shape[0] * allowed.shape[1]).reshape(
        len(centre), allowed.shape[1]
    ) + len(kept)
    T = sp.coo_array(
        (
            np.concatenate([np.ones(len(kept)), values, np.tile(allowed.ravel(), len(centre))]),
            (
                np.concatenate([kept, rows, np.repeat(centre, allowed.shape[1])]),
                np.concatenate(
                    [np.arange(len(kept)), columns, np.repeat(spread, 3, axis=0).ravel()]
                ),
            ),
        ),
        shape=(n, len(kept) + spread.size),
    ).tocsc()
    T.eliminate_zeros()
    return T


def cyclic_faces(part: Part, sectors: int) -> tuple[Integers, Integers]:
    """Node numbers of the sets `left` and `right`, mates at equal places.

    Raises
    ------
    InputError
        If a face is missing, or the right one is not the left one turned by 2π/N.
    """
    if sectors < 2:
        raise InputError(f"{part.name}: sectors = {sectors}: cyclic symmetry needs at least 2")
    for name in ("left", "right"):
        if called(part.node_sets, name) is None:
            raise InputError(f"{part.name}: cyclic symmetry needs a node set {name!r}")
    left, right = part.nodes("left"), part.nodes("right")
    if len(left) != len(right):
        raise InputError(
            f"{part.name}: {len(left)} nodes in `left`, {len(right)} in `right`: they must match"
        )
    gap = np.linalg.norm(part.points[right] - part.points[left] @ turn(sectors).T, axis=1)
    if len(gap) and gap.max() > _TOLERANCE * np.ptp(part.points, axis=0).max():
        raise InputError(
            f"{part.name}: right node {right[gap.argmax()]} lies {gap.max():.3g} m from left node "
            f"{left[gap.argmax()]} turned by 2π/{sectors}: the faces must match node by node"
        )
    return left, right


_DENSE = 200  # below this size, or for most of the spectrum, a dense solve is as fast and simpler


def eigenpairs(
    K: sp.csc_array, M: sp.csc_array, count: int, shift: float = 0.0, factor: Factor | None = None
) -> tuple[Floats, Array]:
    """Lowest eigenvalues and mass-normalised vectors of K x = λ M x.

    Parameters
    ----------
    K, M : (n, n) sparse
        Real symmetric or complex Hermitian; M positive definite.
    count : int
        How many.
    shift : float
        K - shift M must be positive definite: 0 for a supported part, negative for a free one.
    factor : Factor, optional
        Of K - shift M, where it exists already.

    Returns
    -------
    omega_squared : (count,) float
        Ascending, rad²/s² for stiffness and mass.
    vectors : (n, count)
        Real if K and M are; xᴴ M x = 1, and the component of largest modulus is real positive.

    Raises
    ------
    InputError
        If count is not between 1 and n, or K - shift M is not positive definite.

    Notes
    -----
    `block_lanczos` runs on (K - shift M)⁻¹ M from a fixed start, so that equal matrices give equal
    bits.
    """
    n = K.shape[0]
    if not 1 <= count <= n:
        raise InputError(f"count = {count}: a model of {n} dofs has 1 to {n} modes")
    if factor is None:
        factor = factorise(K - shift * M if shift else K)
    if n <= _DENSE or count > n // 4:
        values, vectors = scipy.linalg.eigh((K - shift * M).toarray(), M.toarray())
    else:
        mass = M.astype(complex, copy=False) if factor.is_complex else M
        found = lowest_modes(krylov_space(factor.solve, mass), count)
        values, vectors = found.omega_squared, found.vectors
    return shift + values[:count], _oriented(vectors[:, :count])


def _oriented(vectors: Array) -> Array:
    """Vectors turned so that their largest component is real and positive."""
    largest = vectors[np.argmax(abs(vectors), axis=0), np.arange(vectors.shape[1])]
    oriented: Array = vectors * (abs(largest) / largest)
    return oriented


@dataclass(frozen=True)
class Modes(Product):
    """Linear modes of a part.

    Attributes
    ----------
    frequency : (count,) float
        Natural frequencies, ascending, Hz.
    shapes : (nodes, 3, count) float or complex
        Cartesian displacements of the part's nodes, zero where clamped; mass-normalised over the
        part (one sector of a cyclic structure), xᴴ M x = 1, so in kg^-1/2.
    nodal_diameter : int or None
        That of the wave; sector j+1 moves as sector j turned by 2π/N, times e^{-i 2π ND/N}. None
        where the part stands alone.
    """

    frequency: Floats = field(metadata={"unit": "Hz"})
    shapes: Array = field(metadata={"unit": "kg^-0.5"})
    nodal_diameter: int | None = None


def modes(
    model: Model, count: int, nodal_diameter: int | None = None, sectors: int | None = None
) -> Modes:
    """Lowest modes of a part that stands alone, or of a cyclic structure at one nodal diameter.

    Parameters
    ----------
    model : Model
        Clamped or free: the frequencies of rigid-body motions come out as zero to round-off.
    count : int
        How many.
    nodal_diameter : int, optional
        Makes the part one sector of a ring (see `cyclic_transform`).
    sectors : int, optional
        Number of sectors N; by default that of the part.

    Raises
    ------
    InputError
        If there are fewer modes than that, or the cyclic faces do not match.
    """
    K, M, T = model.K, model.M, None
    if nodal_diameter is not None:
        T = cyclic_transform(model, nodal_diameter, sectors)
        adjoint = T.conj().T
        K, M = (adjoint @ K @ T).tocsc(), (adjoint @ M @ T).tocsc()
    values, vectors = eigenpairs(K, M, count, shift=-(_low_frequency(model) ** 2))
    shapes = model.field(vectors if T is None else T @ vectors)
    return Modes(np.sqrt(np.maximum(values, 0)) / (2 * np.pi), shapes, nodal_diameter)


def _low_frequency(model: Model) -> float:
    """A hundredth of a wave speed over the part's size, rad/s: below most elastic modes.

    As a shift it makes the matrix of a free part definite without moving the modes apart.
    """
    size = float(np.linalg.norm(np.ptp(model.part.points, axis=0)))
    return 0.01 * math.sqrt(model.material.E / model.material.rho) / size
