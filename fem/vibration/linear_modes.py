"""Linear modes of a model: free, clamped or cyclic."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.common.product import Product
from vanelock.fem.model import Model
from vanelock.fem.vibration.cyclic_symmetry import cyclic_transform
from vanelock.fem.vibration.eigen import eigenpairs


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

    frequency: NDArray[np.float64] = field(metadata={"unit": "Hz"})
    shapes: NDArray[Any] = field(metadata={"unit": "kg^-0.5"})
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
