"""What solved points leave of the balance of all coordinates, seen from a few directions.

Solved is the balance condensed to the contacts, by modes. With the matrices as given, and
one-sided coefficients,

    r_h = D_h x^(h) + B_hᴴ λ^(h) - f^(h)

shows as well what modes and receptances have lost to round-off. Each r_h is weighed with four
motions z, sums of all modes with random signs: zᴴ r_h vanishes for all of them only if r_h does.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Array, Floats, Structure

DIRECTIONS = 4
FINEST = 1e-4
"""The static balance, or the vibrating one, is compared with the other times this if smaller."""


def whole_residual(
    structure: Structure, omegas: Floats, modal: Sequence[Array], force: NDArray[np.complex128]
) -> Floats:
    """Largest zᴴ r_h of each point over the largest of its terms, (p,); at rest and vibrating."""
    left, size = np.zeros((2, structure.harmonics + 1, len(omegas)))
    signs = np.random.default_rng(0)
    for h, amplitudes in enumerate(modal):
        modes, matrices = structure.at(h), structure.system.at(structure.nodal_diameters[h])
        some = signs.choice([-1.0, 1.0], (amplitudes.shape[1], DIRECTIONS))
        z, x = modes.shapes @ some, amplitudes @ modes.shapes.T
        s = h * omegas[:, None]
        rows = structure.system.contact_rows(structure.nodal_diameters[h]).reshape(-1, len(z))
        pull = (rows @ z).conj()
        terms = [x @ (matrices.K @ z).conj(), force[:, h].reshape(len(omegas), -1) @ pull]
        if h and np.isfinite(structure.cutoff):  # modes beyond it have no inertia
            terms.append(-(s**2) * ((modes.compliance * amplitudes) @ some))
        elif h:
            terms.append(-(s**2) * (x @ (matrices.M @ z).conj()))
        if h:
            damped = modes.coupled_damping
            rate = amplitudes * modes.damping if damped is None else amplitudes @ damped.T
            terms.append(1j * s * (rate @ some))
        if h in structure.unit_forces:
            growth = np.array([structure.growth(h, omega) for omega in omegas])
            terms.append(-growth[:, None] * (structure.unit_forces[h] @ some))
        left[h] = np.abs(sum(terms)).max(axis=1, initial=0.0)
        size[h] = np.abs(terms).max(axis=(0, 2), initial=0.0)
        if h == 0:  # interference loads, even where the structure evades it
            offset = structure.stiffness * structure.system.contacts.offset.reshape(-1)
            size[0] = np.maximum(size[0], np.abs(offset @ pull).max(initial=0.0))
    moving = size[1:].max(axis=0, initial=0.0)
    scale = np.stack([np.maximum(size[0], FINEST * moving), np.maximum(moving, FINEST * size[0])])
    scale[scale == 0] = 1.0
    return np.asarray(np.maximum(left[0] / scale[0], left[1:].max(axis=0, initial=0.0) / scale[1]))
