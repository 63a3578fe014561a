"""From a program's units to SI.

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
from vanelock.common.quantities import si
from vanelock.fem.matrix_files.model import GENERALISED


@dataclass(frozen=True)
class Units:
    """SI units in one of the program's.

    Attributes
    ----------
    length, mass, force : float
        m, kg, N.
    """

    length: float = 1.0
    mass: float = 1.0
    force: float = 1.0

    def scales(self, direction: Integers) -> Floats:
        """(n,) s of each row."""
        of_rotation = np.where(direction < 3, self.length, 1.0)
        return np.where(direction == GENERALISED, self.length * self.mass**0.5, of_rotation)

    def converted(self, matrix: sp.csc_array, what: str, direction: Integers) -> sp.csc_array:
        """The matrix "stiffness", "mass" or "damping" in SI units."""
        if self == Units():
            return matrix
        energy = {
            "stiffness": self.force * self.length,
            "mass": self.mass * self.length**2,
            "damping": (self.force * self.mass * self.length**3) ** 0.5,
        }[what]
        scale = sp.diags_array(1 / self.scales(direction))
        return (scale @ matrix @ scale * energy).tocsc()


def units(length: str = "m", mass: str = "kg", force: str = "N") -> Units:
    """Units by name, such as "mm", "t" and "N"."""
    return Units(
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
