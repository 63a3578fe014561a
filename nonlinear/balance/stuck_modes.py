"""The linear structure with every contact stuck: modes, damping, receptances.

With K̃ = K + BᴴK_cB, regular although a segment hangs in its contacts alone, and modes V normalised
to VᴴK̃V = I, VᴴMV = Λ (the inverse squared frequencies), the dynamic stiffness at s = hω is

    Vᴴ D̃ V = I - s² Λ + i s (2ζ Λ^½ + VᴴCV).

Normalised by stiffness, static and low-frequency receptances keep full accuracy whatever the
highest modes are, and massless coordinates do no harm.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.rom.system import System

Array: TypeAlias = NDArray[Any]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class StuckModes(Product):
    """Modes of one nodal diameter with all contacts stuck.

    Attributes
    ----------
    shapes : (n, n)
        V, one mode a column.
    rows : (3c, n)
        b = B V, relative displacements of the contacts (normal, t1, t2) in each mode.
    compliance : (n,) float
        Λ, s²/rad².
    damping : (n,) float
        Diagonal of the modal damping, s/rad.
    coupled_damping : (n, n) or None
        The whole modal damping where a given C does not leave it diagonal.
    """

    shapes: Array
    rows: Array
    compliance: Floats
    damping: Floats
    coupled_damping: Array | None = None

    @cached_property
    def pull(self) -> Array:
        """(n, 3c) bᴴ, modal forces of forces in the contacts."""
        return np.ascontiguousarray(self.rows.conj().T)

    def conjugate(self) -> "StuckModes":
        """The modes of the nodal diameter N - k."""
        coupled = self.coupled_damping
        return replace(
            self,
            shapes=self.shapes.conj(),
            rows=self.rows.conj(),
            coupled_damping=None if coupled is None else coupled.conj(),
        )

    def dynamic(self, s: float) -> Array:
        """Diagonal of the modal dynamic stiffness at the circular frequency s, rad/s."""
        diagonal: Array = 1 - s**2 * self.compliance + 1j * s * self.damping
        return diagonal

    def poles(self) -> Floats:
        """(n,) smallest |s|, rad/s, at which each mode's complex dynamic stiffness vanishes.

        That is its natural frequency if it can oscillate; of an overdamped mode, the slower decay.
        """
        c, d = self.compliance, np.abs(self.damping)
        stable = np.maximum(2 * np.sqrt(c), d + np.sqrt(np.maximum(d**2 - 4 * c, 0.0)))
        with np.errstate(divide="ignore"):
            return np.asarray(2 / stable)

    def static_beyond(self, s: float) -> "StuckModes":
        """The same modes, those whose poles lie beyond s, rad/s, following at once.

        Raises
        ------
        InputError
            If a given C couples the modes.
        """
        if self.coupled_damping is not None:
            raise InputError("static_beyond: given with a C that couples the modes; leave it out")
        follows = self.poles() < s
        return replace(
            self,
            compliance=np.where(follows, self.compliance, 0.0),
            damping=np.where(follows, self.damping, 0.0),
        )

    def solve(self, s: float, right: Array) -> Array:
        """Modal amplitudes (n,) or (n, k) under the modal forces `right` at s, rad/s."""
        diagonal = self.dynamic(s)
        if self.coupled_damping is None or s == 0:
            solution: Array = right / (diagonal if right.ndim == 1 else diagonal[:, None])
            return solution
        full = 1j * s * self.coupled_damping
        full[np.diag_indices_from(full)] += 1 - s**2 * self.compliance
        return np.asarray(la.solve(full, right))

    def slope(self, s: float, amplitudes: Array) -> Array:
        """(d(VᴴD̃V)/ds) times modal amplitudes."""
        if self.coupled_damping is None:
            damped: Array = self.damping * amplitudes
        else:
            damped = self.coupled_damping @ amplitudes
        product: Array = -2 * s * self.compliance * amplitudes + 1j * damped
        return product


def stuck_modes(system: System, nodal_diameter: int) -> StuckModes:
    """Modes, contact rows and damping of a nodal diameter, all contacts stuck.

    Raises
    ------
    InputError
        If the structure is not held even then, or a static diameter 0 is not real.
    """
    matrices = system.at(nodal_diameter)
    n = len(matrices.K)
    B = system.contact_rows(nodal_diameter).reshape(-1, n)
    k = system.contacts.stiffness.reshape(-1)
    stuck = matrices.K + (B.conj().T * k) @ B
    M, C = matrices.M, matrices.C
    if nodal_diameter == 0:
        stuck, M, B = (_real(value, "nd/0") for value in (stuck, M, B))
    stuck, M = (stuck + stuck.conj().T) / 2, (M + M.conj().T) / 2
    try:
        values, shapes = la.eigh(M, stuck)
    except la.LinAlgError:
        raise InputError(
            f"system: nd/{nodal_diameter}/K is not positive definite with all contacts stuck; "
            "something is not held"
        ) from None
    values, shapes = values[::-1].clip(min=0), np.ascontiguousarray(shapes[:, ::-1])
    damping = 2 * (system.damping_ratio or 0.0) * np.sqrt(values)
    coupled = None
    if C is not None:
        modal = shapes.conj().T @ C @ shapes
        size = np.sqrt(np.abs(np.outer(modal.diagonal(), modal.diagonal())))
        mixed = np.abs(modal - np.diag(modal.diagonal()))
        if np.all(mixed <= 1e-10 * np.maximum(size, np.abs(modal.diagonal()).max())):
            damping = damping + modal.diagonal().real
        else:
            coupled = modal + np.diag(damping)
            damping = coupled.diagonal().real
    return StuckModes(shapes, B @ shapes, values, damping, coupled)


@dataclass(frozen=True)
class HarmonicModes(Product):
    """Stuck modes of all nodal diameters that a number of harmonics has.

    Attributes
    ----------
    diameters : dict of int to StuckModes
        Those that the system has; of N - k where it has k, they are the conjugates.
    """

    diameters: Mapping[int, StuckModes]


@one_thread
def harmonic_modes(system: System, harmonics: int) -> HarmonicModes:
    """Stuck modes for harmonics 0 to `harmonics`; friction, preload and loads do not matter."""
    wanted = {system.nodal_diameter(h) for h in range(harmonics + 1)}
    wanted |= {(system.sectors - k) % system.sectors for k in wanted}
    held = sorted(wanted & set(system.diameters))
    return HarmonicModes({k: stuck_modes(system, k) for k in held})


def _real(value: Array, where: str) -> Array:
    """The real matrix that a static balance needs."""
    if np.iscomplexobj(value):
        if np.abs(value.imag).max(initial=0.0) > 1e-9 * np.abs(value).max(initial=0.0):
            raise InputError(
                f"system: {where} is not real; choose real coordinates at nodal diameter 0"
            )
        value = value.real
    return np.ascontiguousarray(value)
