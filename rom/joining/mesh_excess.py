"""The stiffness that meshes add to joined parts, taken off along the modes of the joined structure.

A mesh of displacement elements makes a part too stiff. Let X be the modes of the joined structure,
all contacts stuck, and E_p by how much the mesh of part p raises Xᴴ K_p X, as the field itself
shows (`fem.excess_stiffness`). Then

    K_p' = K_p - Q_p E_p Q_pᴴ,      Q_p = K_p X G_p⁻¹,      G_p = Xᴴ K_p X,

takes E_p off the energy of all that X spans, and of other shapes as much as they share its strains:
Q_pᴴ x are the coefficients of the combination of X whose strains are nearest to those of x. A part
that moves without strain, as with contacts open, loses nothing, and K_p' is positive wherever K_p
is, since E_p is less than G_p. E_p is proportional to the part's modulus; Q_p does not change.

The vane's shapes at all nodal diameters lie in a space of some thirty real ones, to 1e-4 of their
strain energy: the ring's stiffness mixes them anew. E of that space, found once, gives E of each
diameter (`spanned`, `SpaceExcess`).

At rest interference pushes where no low mode leads. So at nodal diameter 0, where the state at rest
is, X holds the static answers to each joint's interference too, with contacts that stick and with
contacts without friction (`rest_shapes`), where contacts act on areas.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.linalg as sl

from vanelock.common.arrays import Array, Floats
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.rom.fixed_interface.held import hermitian
from vanelock.rom.system.system import Matrix, System

MODES = 16
"""Modes along which the excess is taken off."""
_MOST = 0.5  # largest share of its strain energy that is taken off any combination of modes
DOUBT = 0.25
"""Of what is taken off, what remains of it at most (docs/theory/mesh_correction.md)."""
_FRICTIONLESS = 1e-6
"""Of the tangential stiffness, what is left to contacts without friction lest parts float."""
_STRAINED = 1e-8
"""Strain energy of a combination of modes, relative to the largest, below which it is none."""
_SPANNED = 1e-6
"""Strain energy of a direction among shapes of unit energy below which it is left out."""


@dataclass(frozen=True)
class SpaceExcess(Product):
    """What a part's mesh adds to the shapes of a space.

    Attributes
    ----------
    forces : (n, r) float
        K Z of a real basis Z of unit strain energy, ½ zᵀ K z = ½, N.
    energy : (r, r) float
        E at Z, J.
    """

    forces: Floats
    energy: Floats

    def at(self, shapes: Matrix) -> Matrix:
        """(m, m) E at shapes (n, m), J; what of them lies outside the space counts as exact."""
        C = self.forces.T @ shapes
        return np.asarray(C.conj().T @ self.energy @ C)


def spanned(shapes: Sequence[Matrix], K: Floats) -> Floats:
    """(n, r) real basis of unit strain energy of shapes (n, m) and their conjugates."""
    if not shapes:
        raise InputError("shapes: given none: needs one or more")
    X = np.hstack([part for x in shapes for part in (x.real, x.imag)])
    energy = np.einsum("ij,ij->j", X, K @ X)
    strained = energy > _STRAINED * energy.max()
    X = X[:, strained] / np.sqrt(energy[strained])
    share, V = np.linalg.eigh(hermitian(X.T @ K @ X))
    kept = share > _SPANNED
    return np.asarray(X @ V[:, kept] / np.sqrt(share[kept]))


@dataclass(frozen=True)
class _ModalExcess(Product):
    """What meshes add to the modes of one nodal diameter."""

    frequency: Floats = field(metadata={"unit": "Hz"})  # (m,), of the modes, Hz
    parts: Array  # (p, m, m), E_p, J at modes of unit mass
    coefficients: Array  # (p, n, m), Q_p in joined coordinates
    share: float

    @property
    def stiffness(self) -> Array:
        """(p, n, n) Q_p E_p Q_pᴴ, N/m."""
        Q = self.coefficients
        return np.asarray(Q @ self.parts @ Q.conj().swapaxes(1, 2))


@dataclass(frozen=True)
class MeshExcess(Product):
    """What the meshes of some parts add to the modes of the joined structure.

    Attributes
    ----------
    diameters : dict of int to ModalExcess
        By nodal diameter.
    """

    diameters: dict[int, _ModalExcess]

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
    shapes: Matrix, frequency: Floats, parts: Sequence[Array], forces: Sequence[Array]
) -> _ModalExcess:
    """The excess of modes, at most half of the strain energy of any combination of them.

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
    """
    if len(parts) != len(forces):
        raise InputError(f"forces: given {len(forces)}: needs one for each of {len(parts)} parts")
    kept, coefficients, most = [], [], 0.0
    for E, KX in zip(parts, forces, strict=True):
        G = hermitian(shapes.conj().T @ KX)
        energy, V = np.linalg.eigh(G)
        strained = energy > _STRAINED * energy.max()
        W = V[:, strained] / np.sqrt(energy[strained])  # Wᴴ G W = 1
        share, U = np.linalg.eigh(hermitian(W.conj().T @ E @ W))
        most = max(most, float(share.max(initial=0.0)))
        back = G @ W @ U
        kept.append(hermitian(back * share.clip(max=_MOST) @ back.conj().T))
        coefficients.append(KX @ W @ W.conj().T)
    return _ModalExcess(frequency, np.array(kept), np.array(coefficients), most)


def rest_shapes(system: System, joints: Sequence[str]) -> Matrix:
    """(n, 2j) static answers to the interference of each of j joints, at nodal diameter 0.

    Contacts stick in the first j of them, and have no friction in the others. Each is of unit mass.

    Parameters
    ----------
    system : System
    joints : sequence of str
        Those whose contacts act on areas: the energy under a point force grows without bound as
        elements shrink, and what meshes add to it means nothing.
    """
    one, contacts = system.at(0), system.contacts
    rows = system.contact_rows(0)
    known = dict.fromkeys(contacts.joints)
    if not joints or not set(joints) <= known.keys():
        raise InputError(f"joints: given {list(joints)}: needs some of {', '.join(known)}")
    found = []
    for share in (1.0, _FRICTIONLESS):
        springs = np.column_stack([contacts.kn, share * contacts.kt])
        held = one.K + np.einsum("cdi,cd,cdj->ij", rows.conj(), springs, rows)
        push = [rows[:, 0].conj().T @ (contacts.kn * contacts.of(joint)) for joint in joints]
        found.append(sl.solve(hermitian(held), np.column_stack(push), assume_a="pos"))
    x = np.hstack(found)
    mass = np.einsum("ij,ij->j", x.conj(), one.M @ x).real
    return np.asarray(x / np.sqrt(mass))
