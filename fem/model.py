"""The product of the finite-element stage, stiffness and mass of one part; and its material."""

import math
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp

from vanelock.common.arguments import OfKind
from vanelock.common.arrays import Array, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.mesh import Part


@dataclass(frozen=True)
class Material(OfKind, Product):
    """Isotropic linear elastic material, at the temperature it is used at.

    Attributes
    ----------
    E : float
        Young's modulus, Pa.
    nu : float
        Poisson's ratio.
    rho : float
        Density, kg/m³.

    Raises
    ------
    InputError
        If E or rho is not positive, or nu is outside (-1, 0.5).
    """

    E: float = field(metadata={"unit": "Pa"})
    nu: float
    rho: float = field(metadata={"unit": "kg/m^3"})

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (self.E > 0 and math.isfinite(self.E)):
            raise InputError(f"material.E = {self.E:g}: Young's modulus must be > 0 Pa")
        if not -1 < self.nu < 0.5:
            raise InputError(f"material.nu = {self.nu:g}: Poisson's ratio must be in (-1, 0.5)")
        if not (self.rho > 0 and math.isfinite(self.rho)):
            raise InputError(f"material.rho = {self.rho:g}: density must be > 0 kg/m^3")

    @property
    def lame(self) -> tuple[float, float]:
        """Lamé's parameters λ and μ, Pa."""
        return (
            self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu)),
            self.E / (2 * (1 + self.nu)),
        )


@dataclass(frozen=True)
class Model(Product):
    """Stiffness and mass of a part over its n free degrees of freedom, in Cartesian components.

    Attributes
    ----------
    part : Part
        The mesh.
    material : Material
        Its material.
    K, M : (n, n) csc_array
        Stiffness, N/m, and consistent mass, kg; symmetric to the last bit.
    dofs : (nodes, 3) int
        Row of each node's x, y and z displacement; -1 where the node is clamped.
    """

    part: Part
    material: Material
    K: sp.csc_array = field(metadata={"unit": "N/m"})
    M: sp.csc_array = field(metadata={"unit": "kg"})
    dofs: Integers

    def rows(self, node_set: str) -> Integers:
        """(k, 3) rows of the nodes of a set, -1 where clamped.

        Raises
        ------
        InputError
            If the part has no such set.
        """
        rows: Integers = self.dofs[self.part.nodes(node_set)]
        return rows

    def field(self, x: Array) -> Array:
        """Displacement (nodes, 3) or (nodes, 3, k) of free-dof vectors x, (n,) or (n, k)."""
        padded = np.concatenate([x, np.zeros_like(x[:1])])  # clamped: row -1
        return padded[self.dofs]

    def free(self, field: Array) -> Array:
        """Free-dof vectors, (n,) or (n, k), of nodal fields (nodes, 3) or (nodes, 3, k).

        What clamped nodes have is left out.
        """
        free = self.dofs >= 0
        x = np.zeros((self.K.shape[0], *field.shape[2:]), field.dtype)
        x[self.dofs[free]] = field[free]
        return x
