"""Linear modes of a model, K x = λ M x, by shift-invert block Lanczos: free, clamped or cyclic."""

import math
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.fem.model import Model
from vanelock.fem.solvers.factor import Factor, factorise
from vanelock.fem.vibration.block_lanczos import krylov_space, lowest_modes
from vanelock.fem.vibration.cyclic_symmetry import cyclic_transform

DENSE = 200  # below this size, or for most of the spectrum, a dense solve is as fast and simpler


def eigenpairs(
    K: sp.csc_array,
    M: sp.csc_array,
    count: int,
    shift: float = 0.0,
    factor: Factor | None = None,
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
    if n <= DENSE or count > n // 4:
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
