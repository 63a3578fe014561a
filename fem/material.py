"""Isotropic linear elastic material."""

import math
from dataclasses import dataclass, field

from vanelock.common.arguments import OfKind
from vanelock.common.errors import InputError
from vanelock.common.product import Product


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
