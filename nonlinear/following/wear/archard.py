"""Archard's law: what a contact loses in a period of its vibration.

    dv0/dN = -(k / A) ∮ n |dw|,

v0 the interference, n the normal force, w the path of the friction slider, A the contact's area, k
the wear coefficient of both surfaces together (J. F. Archard, J. Appl. Phys. 24 (1953) 981-988).
The friction work of the contact law is μ ∮ n |dw|: of the path in the tangential plane where
friction is isotropic; where it is orthogonal, of both directions one by one, |dw| = |dw₁| + |dw₂|,
which is up to √2 of the path in the plane.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock.common.arrays import as_array
from vanelock.common.errors import InputError
from vanelock.nonlinear.contact.law import Deviation
from vanelock.rom.system.system import Contacts

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Archard:
    """The law of wear of c contacts.

    Attributes
    ----------
    depth : (c,) float
        k / A, 1/N: depth per normal load and slip distance; 0 for what does not wear.
    mu : (c,) float
        Friction coefficients.
    """

    depth: Floats
    mu: Floats

    def rate(self, deviation: Deviation) -> Floats:
        """(c,) depth worn in a period, both surfaces together, m."""
        worn = self.depth > 0
        slid = np.zeros(len(worn))
        np.divide(deviation.dissipation, self.mu, out=slid, where=worn)
        return np.where(worn, self.depth * np.maximum(slid, 0.0), 0.0)


def checked_archard(contacts: Contacts, coefficient: ArrayLike, area: ArrayLike) -> Archard:
    """The law of wear of these contacts."""
    k = _of_contacts(coefficient, "coefficient", "m²/N", contacts.count)
    A = _of_contacts(area, "area", "m²", contacts.count)
    if (k < 0).any():
        raise InputError(f"coefficient: given {k.min():g} m²/N: must be >= 0")
    if not (A > 0).all():
        raise InputError(f"area: given {A.min():g} m²: must be > 0")
    k = np.where(contacts.springs, k, 0.0)
    if (smooth := (k > 0) & (contacts.mu == 0)).any():
        i = int(np.argmax(smooth))
        raise InputError(
            f"coefficient: given {k[i]:g} m²/N of contact {i}, whose mu is 0: "
            "wear follows from friction work; needs mu > 0 or a coefficient of 0"
        )
    return Archard(k / A, contacts.mu)


def _of_contacts(given: ArrayLike, name: str, unit: str, count: int) -> Floats:
    """A finite number of each contact."""
    found = as_array(given, name)
    if found.shape not in ((), (count,)):
        raise InputError(
            f"{name}: given shape {found.shape}: needs a number in {unit}, or one of each of the "
            f"{count} contacts"
        )
    if not np.isfinite(found).all():
        raise InputError(f"{name}: given {found[~np.isfinite(found)][0]}: must be finite")
    return np.broadcast_to(found, count).astype(float)
