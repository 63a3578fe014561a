"""What contacts do in a period: energy, damping ratio, wear indicators.

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

Wear indicators of contacts: friction work, slip distance, load and pressure at one response.

The friction spring of a contact ends in a slider at w = u - t/kt. Over a period the slider travels

    s = ∮ |dw|,        E = ∮ t·dw = μ W,        W = ∮ n |dw|,

while the contact is closed (open, it follows without load). E is the friction work. Coulomb's law
bounds |t| in the plane of both directions; of the orthogonal law, which bounds each by itself, W
counts both one by one, |dw₁| + |dw₂|, up to √2 of the path. The volume worn in a cycle by
Archard's law is k W = k E/μ, as `nonlinear.wear_history` has it (J. F. Archard, Contact and rubbing
of flat surfaces, J. Appl. Phys. 24 (1953) 981-988), with a wear coefficient k in m²/N; over the
contact's area it is a depth.
Fretting maps use E per area instead (S. Fouvry, P. Kapsa, L. Vincent, Quantification of fretting
damage, Wear 200 (1996) 186-205). Both surfaces together lose that volume.
"""

from dataclasses import dataclass

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear import ELEMENT, Response, contact_loop
from vanelock.rom import System

_TURN = 2 * np.pi


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
    omega = _TURN * float(response.frequency[point])
    given = stored = 0.0
    for h in range(1, response.harmonics + 1):
        x = response.x[h][point]
        matrices = system.at(int(response.harmonic_diameters[h]))
        stored += 0.5 * (h * omega) ** 2 * float(np.vdot(x, matrices.M @ x).real)
        if h in system.force:
            given += np.pi * h * float(np.vdot(x, system.force[h].at(omega)).imag)
    friction = float(response.dissipation[point].sum())
    return EnergyBalance(given, friction, given - friction, stored)


def _half_power(frequency: Floats, amplitude: Floats) -> tuple[float, float] | None:
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
    ends = _half_power(frequency, amplitude)
    if ends is None:
        return float("nan")
    peak = frequency[int(np.nanargmax(amplitude))]
    return float((ends[1] - ends[0]) / (2 * peak))


_SAMPLES = 2048
"""Steps of a period; an event inside a step misplaces a part of that step's slip."""
HOUR = 3600.0


@dataclass(frozen=True)
class Wear:
    """Indicators of c contacts at one point of a response, of a period each unless stated.

    Attributes
    ----------
    frequency : float
        Of the excitation, Hz.
    energy : (c,) float
        Friction work, J.
    slip : (c,) float
        Distance that the slider travels under load, there and back, m; NaN where the loop is not
        known exactly (orthogonal friction on plain samples).
    work : (c,) float
        Normal load times slip, friction work over the friction coefficient, J.
    mean_load, largest_load : (c,) float
        Normal force, N.
    area : (c,) float
        That belongs to the contact, m²; NaN where it is not known.
    coefficient : (c,) float
        Wear coefficient, m²/N; NaN where none is given.
    """

    frequency: float
    energy: Floats
    slip: Floats
    work: Floats
    mean_load: Floats
    largest_load: Floats
    area: Floats
    coefficient: Floats

    @property
    def energy_per_area(self) -> Floats:
        """(c,) friction work per cycle and area, J/m²."""
        return self.energy / self.area

    @property
    def power(self) -> Floats:
        """(c,) friction power, W."""
        return self.energy * self.frequency

    @property
    def slip_per_hour(self) -> Floats:
        """(c,) slip distance in an hour at this frequency, m."""
        return self.slip * self.frequency * HOUR

    @property
    def mean_pressure(self) -> Floats:
        """(c,) mean normal pressure, Pa."""
        return self.mean_load / self.area

    @property
    def largest_pressure(self) -> Floats:
        """(c,) largest normal pressure, Pa."""
        return self.largest_load / self.area

    @property
    def volume_per_hour(self) -> Floats:
        """(c,) volume worn in an hour by Archard's law, of both surfaces together, m³."""
        return self.coefficient * self.work * self.frequency * HOUR

    @property
    def depth_per_hour(self) -> Floats:
        """(c,) that volume over the area, m."""
        return self.volume_per_hour / self.area


def wear(response: Response, area: Floats, coefficient: Floats) -> Wear:
    """Wear indicators of every contact at the first point of a response, which has converged."""
    slip, touching = np.full(len(response.mu), np.nan), response.state[0] != ELEMENT
    energy = response.dissipation[0].copy()
    work = np.where(touching, 0.0, np.nan)
    np.divide(energy, response.mu, out=work, where=touching & (response.mu > 0))
    mean, largest = _loads(response)
    if exact(response):
        slip[touching] = 0.0
        for i in np.flatnonzero(touching & (energy > 0)):  # the others only round off
            displacement, force = contact_loop(response, 0, i, _SAMPLES)
            slip[i] = _travel(displacement, force, response.stiffness[i])
            mean[i], largest[i] = force[:, 0].mean(), force[:, 0].max()
    frequency = float(response.frequency[0])
    return Wear(frequency, energy, slip, work, mean, largest, area, coefficient)


def exact(response: Response) -> bool:
    """Whether the loops of a response are known: orthogonal friction on plain samples has none."""
    return not (response.samples > 0 and response.friction == "orthogonal")


def _travel(displacement: Floats, force: Floats, stiffness: Floats) -> float:
    """Slip distance ∮ |dw| under load of a contact's loop, m."""
    w = displacement[:, 1:] - force[:, 1:] / stiffness[1:]
    n = force[:, 0]
    moved = np.linalg.norm(np.roll(w, -1, axis=0) - w, axis=1)
    after = np.roll(n, -1)
    return float(moved[(n > 0) & (after > 0)].sum())


def _loads(response: Response) -> tuple[Floats, Floats]:
    """Mean and largest normal force from the balanced coefficients, N."""
    coefficients = response.force[0, :, :, 0]
    H = len(coefficients) - 1
    angle = 2 * np.pi * np.arange(32 * (H + 1)) / (32 * (H + 1))
    history = (np.exp(1j * np.outer(angle, np.arange(H + 1))) @ coefficients).real
    return coefficients[0].real.copy(), history.max(axis=0)
