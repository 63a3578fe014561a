"""The stiffness that meshes add to joined parts, taken off along the modes of the joined structure.

A mesh of displacement elements makes a part too stiff. Let X be the modes of the joined structure,
all contacts stuck, and E_p by how much the mesh of part p raises Xᴴ K_p X, as the field itself
tells (`fem.excess_stiffness`). Then

    K_p' = K_p - Q_p E_p Q_pᴴ,      Q_p = K_p X G_p⁻¹,      G_p = Xᴴ K_p X,

takes E_p off the energy of all that X spans, and of other shapes as much as they share its strains:
Q_pᴴ x are the coefficients of the combination of X whose strains are nearest to those of x. A part
that moves without strain, as with contacts open, loses nothing, and K_p' is positive wherever K_p
is, since E_p is less than G_p. E_p is proportional to the part's modulus; Q_p does not change.

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
from vanelock.rom.fixed_interface.held import hermitian
from vanelock.rom.system import Matrix, System

MODES = 16
"""Modes along which the excess is taken off."""
LEAST = 0.5
"""Least share of its strain energy that any combination of modes must keep."""
STRAINED = 1e-8
"""Strain energy of a combination of modes, relative to the largest, below which it is none."""


@dataclass(frozen=True)
class ModalExcess(Product):
    """What meshes add to the modes of one nodal diameter.

    Attributes
    ----------
    frequency : (m,) float
        Of the modes, Hz.
    parts : (p, m, m)
        E_p, J at modes of unit mass.
    coefficients : (p, n, m)
        Q_p in joined coordinates.
    """

    frequency: NDArray[np.float64] = field(metadata={"unit": "Hz"})
    parts: NDArray[Any]
    coefficients: NDArray[Any]

    @property
    def stiffness(self) -> NDArray[Any]:
        """(p, n, n) Q_p E_p Q_pᴴ, N/m."""
        Q = self.coefficients
        return np.asarray(Q @ self.parts @ Q.conj().swapaxes(1, 2))


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
            excess = np.tensordot(factors, self.diameters[k].stiffness, 1)
            excess = excess.real if np.isrealobj(one.K) else excess
            diameters[k] = replace(one, K=one.K - excess)
        return replace(system, diameters=diameters)


def modal_excess(
    shapes: Matrix,
    frequency: NDArray[np.float64],
    parts: Sequence[NDArray[Any]],
    forces: Sequence[NDArray[Any]],
) -> ModalExcess:
    """The excess of modes, if they keep most of their stiffness without it.

    Parameters
    ----------
    shapes : (n, m)
        X.
    frequency : (m,) float
        Hz.
    parts : sequence of (m, m)
        E_p.
    forces : sequence of (n, m)
        K_p X, N.

    Raises
    ------
    InputError
        If the meshes are too coarse for their excess to be small.
    """
    kept, coefficients = [], []
    for E, KX in zip(parts, forces, strict=True):
        energy, V = np.linalg.eigh(hermitian(shapes.conj().T @ KX))
        strained = energy > STRAINED * energy.max()
        W = V[:, strained] / np.sqrt(energy[strained])  # Wᴴ G W = 1
        share = hermitian(W.conj().T @ E @ W)
        most = float(np.linalg.eigvalsh(share).max(initial=0.0))
        if most > 1 - LEAST:
            raise InputError(
                f"mesh.correction: the mesh holds {100 * most:.0f} % of the strain energy of a "
                "combination of modes, too much to be taken off: needs smaller elements"
            )
        onto = W @ W.conj().T  # G⁻¹
        coefficients.append(KX @ onto)
        kept.append(hermitian(E))
    return ModalExcess(frequency, np.array(kept), np.array(coefficients))
