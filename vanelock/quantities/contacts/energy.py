"""Where the energy of a vibration goes in a period, and the damping ratio that this amounts to.

Work of the excitation and of viscous damping, and the vibration's energy, of one sector:

    W_in = Σ_h π h Im(x_hᴴ f_h),      W_viscous = W_in - Σ_c E_c,      U = Σ_h ½ (hω)² x_hᴴ M x_h,

with x_h the one-sided coefficient of harmonic h, E_c the friction work of contact c, found by
marching its loop. U is the largest kinetic energy where all points move in phase; of a travelling
wave, whose kinetic and strain energy do not change in time and are equal at resonance, it is the
sum of both. At resonance the equivalent viscous damping ratio is (L. S. Jacobsen, Steady forced
vibration as influenced by damping, Trans. ASME 52 (1930) 169-181; A. K. Chopra, Dynamics of
Structures, section 3.9)

    ζ_energy = W_in / (4 π U),

exact for a linear mode at its natural frequency. From the curve alone it is, of a linear mode, the
half-power bandwidth: with f_1 and f_2 on either side of the peak at 1/√2 of its height,

    ζ_bandwidth = (f_2 - f_1) / (2 f_peak).

Where the two differ the peak is not that of a linear mode: friction damps less below it.
"""

from dataclasses import dataclass

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear import Response
from vanelock.rom import System

TURN = 2 * np.pi


@dataclass(frozen=True)
class EnergyBalance:
    """Energies of one sector in a period, J, and the damping they amount to.

    Attributes
    ----------
    input, friction, viscous : float
        Work of the excitation, of all contacts, and the rest.
    stored : float
        Energy of the vibration.
    """

    input: float
    friction: float
    viscous: float
    stored: float

    @property
    def damping_ratio(self) -> float:
        """Equivalent viscous damping ratio by energy; NaN without vibration."""
        return self.input / (4 * np.pi * self.stored) if self.stored > 0 else float("nan")

    @property
    def friction_share(self) -> float:
        """Share of the work that friction takes; NaN where no work is done."""
        return self.friction / self.input if self.input > 0 else float("nan")


def balance(system: System, response: Response, point: int = 0) -> EnergyBalance:
    """Energies in a period at a point of a response of a system."""
    omega = TURN * float(response.frequency[point])
    given = stored = 0.0
    for h in range(1, response.harmonics + 1):
        x = response.x[h][point]
        matrices = system.at(int(response.harmonic_diameters[h]))
        stored += 0.5 * (h * omega) ** 2 * float(np.vdot(x, matrices.M @ x).real)
        if h in system.force:
            given += np.pi * h * float(np.vdot(x, system.force[h].at(omega)).imag)
    friction = float(response.dissipation[point].sum())
    return EnergyBalance(given, friction, given - friction, stored)


def half_power(frequency: Floats, amplitude: Floats) -> tuple[float, float] | None:
    """Frequencies on either side of the largest point at 1/√2 of it, Hz, or None."""
    known = np.isfinite(amplitude) & np.isfinite(frequency)
    order = np.argsort(frequency[known], kind="stable")
    f, a = frequency[known][order], amplitude[known][order]
    if len(f) < 3:
        return None
    top = int(a.argmax())
    level = a[top] / np.sqrt(2)
    below, above = np.flatnonzero(a[:top] < level), np.flatnonzero(a[top:] < level)
    if not len(below) or not len(above):
        return None
    i, j = int(below[-1]), top + int(above[0])
    low = f[i] + (level - a[i]) / (a[i + 1] - a[i]) * (f[i + 1] - f[i])
    high = f[j - 1] + (a[j - 1] - level) / (a[j - 1] - a[j]) * (f[j] - f[j - 1])
    lost = frequency[~np.isfinite(amplitude)]
    if np.any((lost > f[i]) & (lost < f[j])):
        return None
    return float(low), float(high)


def bandwidth_ratio(frequency: Floats, amplitude: Floats) -> float:
    """Damping ratio by the half-power bandwidth; NaN where the curve is too short."""
    ends = half_power(frequency, amplitude)
    if ends is None:
        return float("nan")
    peak = frequency[int(np.nanargmax(amplitude))]
    return float((ends[1] - ends[0]) / (2 * peak))
