"""A component as matrices, what every row is and where its nodes are, from any units to SI.

A displacement is u = s q with s metres in its unit of length; a rotation is in radians, s = 1.
Energy is the same in both, so K_ij becomes K_ij F L / (s_i s_j), and M_ij becomes
M_ij m L² / (s_i s_j). Time is what makes them consistent, T² = m L / F. A generalised coordinate
has the unit L √m, with s to match: one normalised to unit mass stays so.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.common.quantities import si

GENERALISED = 6
"""Direction of a coordinate that belongs to no node, such as that of a fixed-interface mode."""


@dataclass(frozen=True)
class Matrices(Product):
    """Matrices of a component in SI units, exactly Hermitian.

    Attributes
    ----------
    K : (n, n) sparse
        Stiffness, N/m between displacements, N m between rotations.
    M : (n, n) sparse or None
        Mass, kg and kg m².
    C : (n, n) sparse or None
        Viscous damping, N s/m and N m s.
    node : (n,) int
        The other program's number of each row's node; 0 for generalised coordinates.
    direction : (n,) int
        0, 1, 2: displacement in x, y, z; 3, 4, 5: rotation about them; 6: a generalised coordinate.
    position : (m, 3) float or None
        Where the nodes `position_node` are, m.
    position_node : (m,) int
        Empty where no positions are known.
    """

    K: sp.csc_array
    M: sp.csc_array | None
    C: sp.csc_array | None
    node: Integers
    direction: Integers
    position: Floats | None
    position_node: Integers

    @property
    def size(self) -> int:
        """Number of rows n."""
        return len(self.node)


@dataclass(frozen=True)
class _Units:
    """SI units in one of the program's."""

    length: float = 1.0  # m
    mass: float = 1.0  # kg
    force: float = 1.0  # N

    def scales(self, direction: Integers) -> Floats:
        """(n,) s of each row."""
        of_rotation = np.where(direction < 3, self.length, 1.0)
        return np.where(direction == GENERALISED, self.length * self.mass**0.5, of_rotation)

    def converted(self, matrix: sp.csc_array, what: str, direction: Integers) -> sp.csc_array:
        """The matrix "stiffness", "mass" or "damping" in SI units."""
        if self == _Units():
            return matrix
        energy = {
            "stiffness": self.force * self.length,
            "mass": self.mass * self.length**2,
            "damping": (self.force * self.mass * self.length**3) ** 0.5,
        }[what]
        scale = sp.diags_array(1 / self.scales(direction))
        return (scale @ matrix @ scale * energy).tocsc()


def units(length: str = "m", mass: str = "kg", force: str = "N") -> _Units:
    """Units by name, such as "mm", "t" and "N"."""
    return _Units(
        _in_si("length", length, "m"), _in_si("mass_unit", mass, "kg"), _in_si("force", force, "N")
    )


def _in_si(key: str, name: str, unit: str) -> float:
    try:
        factor = si(f"1 {name}", unit)
    except ValueError:
        factor = None
    if not isinstance(factor, float) or not 1e-12 <= factor <= 1e12:
        raise InputError(f'{key} = "{name}": expected a unit such as "{unit}"')
    return factor
