"""Cyclic systems of any size whose modes, stiffness and loads are like a vane segment's.

Modes spread as those of a reduced vane do (the first near 200 Hz, then about proportional to their
number), neighbours are coupled by a few springs, and contacts lie within a sector and between
sectors in equal parts. All of a mode's shape is drawn at random.
"""

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.common.cyclic import folded
from vanelock.nonlinear import Contacts, Diameter, Force, System

FIRST = 200.0
"""Lowest natural frequency of a sector by itself, Hz."""


def natural(system: System) -> float:
    """First natural frequency of the excited diameter with all contacts stuck, Hz."""
    k = system.nodal_diameter(1)
    matrices = system.at(k)
    B = system.contact_rows(k).reshape(-1, len(matrices.K))
    stuck = matrices.K + (B.conj().T * system.contacts.stiffness.reshape(-1)) @ B
    values = la.eigh(stuck, matrices.M, eigvals_only=True, subset_by_index=[0, 0])
    return float(np.sqrt(values[0])) / (2 * np.pi)


def ring(
    size: int,
    contacts: int,
    harmonics: int,
    mu: float = 0.3,
    severity: float = 1.0,
    sectors: int = 16,
    ratio: float = 0.003,
    seed: int = 0,
) -> System:
    """A ring with a travelling excitation of engine order 1.

    Parameters
    ----------
    size : int
        Coordinates of a sector.
    contacts : int
    harmonics : int
        H that its nodal diameters must serve.
    mu : float
    severity : float
        Tangential force of the stuck contacts at resonance over the one at which they slip, on
        the average.
    """
    rng = np.random.default_rng(seed)
    turned, _ = la.qr(rng.normal(size=(size, size)))
    squared = (2 * np.pi * FIRST) ** 2 * np.arange(1, size + 1) ** 2.2
    sector = (turned * squared) @ turned.T
    links = unit(rng.normal(size=(10, size)))
    beyond_links = unit(rng.normal(size=(10, size)))
    own = unit(rng.normal(size=(contacts, 3, size)))
    beyond = unit(rng.normal(size=(contacts, 3, size))) * (np.arange(contacts) % 2)[:, None, None]
    soft = squared[0] * size
    kept = sorted({folded(h, sectors) for h in range(harmonics + 1)})
    diameters = {}
    for k in kept:
        link = links - beyond_links * np.exp(-2j * np.pi * k / sectors)
        K = sector + 0.02 * soft * link.conj().T @ link
        K = 0.5 * (K + K.conj().T)
        diameters[k] = Diameter(
            K=K.real if k in (0, sectors / 2) else K,
            M=np.eye(size),
            own=own,
            next=-beyond,
        )
    stiffness = 0.3 * soft / contacts * rng.uniform(0.5, 1.5, (contacts, 3))
    v0 = rng.uniform(0.3, 1.0, contacts) * 1e-5
    push = unit(rng.normal(size=size) + 1j * rng.normal(size=size))
    system = System(
        sectors=sectors,
        engine_order=1,
        diameters=diameters,
        contacts=Contacts(stiffness[:, 0], stiffness[:, 1:], np.full(contacts, mu), v0),
        force={1: Force(push)},
        damping_ratio=ratio,
    )
    amplitude = severity * mu * v0.mean() * stiffness[:, 0].mean() / _stuck_force(system, ratio)
    return System(**{**vars(system), "force": {1: Force(amplitude * push)}})


def unit(rows: NDArray[np.generic]) -> NDArray[np.generic]:
    """Rows scaled to length 1."""
    return np.asarray(rows / np.linalg.norm(rows, axis=-1, keepdims=True))


def _stuck_force(system: System, ratio: float) -> float:
    """Root mean square of the tangential forces at the stuck resonance under the present load."""
    matrices = system.at(1)
    B = system.contact_rows(1).reshape(-1, len(matrices.K))
    k = system.contacts.stiffness.reshape(-1)
    stuck = matrices.K + (B.conj().T * k) @ B
    values, modes = la.eigh(stuck, matrices.M)
    modal = values - values[0] + 2j * ratio * np.sqrt(values * values[0])
    u = B @ (modes @ ((modes.conj().T @ system.force[1].vector) / modal))
    pulled = (np.abs(u) * k).reshape(-1, 3)[:, 1:]
    return float(np.sqrt((pulled**2).mean()))
