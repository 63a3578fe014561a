"""The stiffness that meshes add to joined parts, taken off in the modes of the joined structure.

A mesh of displacement elements makes a part too stiff. With the modes X of the joined structure,
all contacts stuck and Xᴴ M X = 1, let E = Σ E_p be by how much the mesh of each part p raises
Xᴴ K X, as the field itself tells (`fem.excess_stiffness`). Then

    K' = K - P E Pᴴ,      P = M X,

has the frequencies of much finer meshes to first order, whether contacts stick, slip or
open: the modes span what moves at low frequency, and their excess is in the parts. E_p is
proportional to the modulus of its part.

At rest interference and static loads push where no low mode leads; what the modes tell there is
wrong, in sign too. So nodal diameter 0, at which the state at rest is, stays as it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.rom.system import Matrix, System

MODES = 16
"""Modes in which the excess is taken off; with fewer the amplitude of a friction peak depends on
their number by more than 0.1 %."""
LEAST = 0.5
"""Least share of its stiffness that any combination of modes must keep."""


@dataclass(frozen=True)
class ModalExcess(Product):
    """What meshes add to the modes of one nodal diameter.

    Attributes
    ----------
    shapes : (n, m)
        X in joined coordinates.
    frequency : (m,) float
        Of the modes, Hz.
    parts : (p, m, m)
        E_p, rad²/s².
    """

    shapes: Matrix
    frequency: NDArray[np.float64] = field(metadata={"unit": "Hz"})
    parts: NDArray[Any]

    @property
    def raised(self) -> NDArray[np.float64]:
        """(m,) relative amounts by which the meshes raise the frequencies."""
        omega2 = (2 * np.pi * self.frequency) ** 2
        total = np.einsum("pjj->j", self.parts).real
        return np.asarray(np.divide(total, 2 * omega2, where=omega2 > 0, out=0 * omega2))

    def stiffness(self, M: Matrix) -> NDArray[Any]:
        """(p, n, n) P E_p Pᴴ, by the mass (n, n)."""
        P = M @ self.shapes
        found = P @ self.parts @ P.conj().T
        return np.asarray(found.real if np.isrealobj(M) and np.isrealobj(self.shapes) else found)


@dataclass(frozen=True)
class MeshExcess(Product):
    """What the meshes of some parts add to the modes of the joined structure.

    Attributes
    ----------
    diameters : dict of int to ModalExcess
        By nodal diameter, 0 not among them.
    """

    diameters: dict[int, ModalExcess]

    def taken_off(self, system: System, factors: Sequence[float] = (1.0, 1.0)) -> System:
        """The system without it, at the nodal diameters that both have.

        Parameters
        ----------
        system : System
            Of the same parts, whatever their joints.
        factors : (p,) sequence of float
            Moduli of the parts over those with which the excess was found.
        """
        diameters = dict(system.diameters)
        for k in diameters.keys() & self.diameters.keys():
            one = diameters[k]
            excess = np.tensordot(factors, self.diameters[k].stiffness(one.M), 1)
            diameters[k] = replace(one, K=one.K - excess)
        return replace(system, diameters=diameters)


def modal_excess(
    shapes: Matrix, frequency: NDArray[np.float64], parts: Sequence[NDArray[Any]]
) -> ModalExcess:
    """The excess of modes, if they keep most of their stiffness without it.

    Parameters
    ----------
    shapes : (n, m)
        X, Xᴴ M X = 1.
    frequency : (m,) float
        Hz.
    parts : sequence of (m, m)
        E_p, rad²/s².

    Raises
    ------
    InputError
        If the meshes are too coarse for their excess to be small.
    """
    found = ModalExcess(shapes, frequency, np.array(parts))
    omega = 2 * np.pi * frequency
    moving = omega > 1e-6 * omega.max()
    scaled = found.parts.sum(axis=0)[np.ix_(moving, moving)] / np.outer(
        omega[moving], omega[moving]
    )
    most = float(np.linalg.eigvalsh(scaled).max(initial=0.0))
    if most > 1 - LEAST:
        raise InputError(
            f"mesh.correction: the mesh holds {100 * most:.0f} % of the stiffness of a combination "
            "of modes, too much to be taken off: needs smaller elements"
        )
    return found
