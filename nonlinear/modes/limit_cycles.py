"""Limit cycles of flutter: where what the air puts into a mode is what friction takes.

Modal forces of the air on sector 0 by the motion of sector m, f = Σ_m L_m q_m, are in a travelling
wave of nodal diameter k

    f = A_k q,      A_k = Σ_m L_m e^{-imk 2π/N}

(influence coefficients: Hanamura, Tanaka and Yamaguchi, Bull. JSME 23 (1980) 880-887). In modes of
unit mass their damping ratio is D_a = -Im A_k / (2ω²), negative where the air drives the wave. A
damped mode's D(a) is what structure and friction take of the same motion, so that the ring
vibrates for good, without any force, at the amplitudes where

    D(a) + D_a = 0,      ω² = ω(a)² - Re A_k :

for good, if D grows with the amplitude there and no other wave grows beside it; a kick beyond
where it falls grows without end.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Booleans, Complex, Floats, as_array
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.forced_response.frequency_sweep import Progress
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.fourier import TURN
from vanelock.nonlinear.modes.damped_mode import DampedMode, damped_mode
from vanelock.rom.system.system import System

_BESIDE = 3e-3  # relative distance from a crossing at which the mode is solved again for its place


@dataclass(frozen=True)
class LimitCycles(Product):
    """Free vibration of a travelling wave that the air drives, k of them.

    Attributes
    ----------
    nodal_diameter : int
    aerodynamic_damping : float
        Damping ratio of the air at the linear mode's frequency.
    linear_damping : float
        Of structure and air together at small amplitudes: negative where the wave starts by itself.
    amplitude : (k,) float
        Modal amplitudes, ascending, kg^½ m.
    frequency : (k,) float
        Hz.
    amplitude_stable : (k,) bool
        Whether the wave returns to it after a small change of its amplitude, all else alike; where
        not, it is what a kick must exceed to grow. Waves of other nodal diameters, which the air
        may drive beside it, are not looked at.
    output : (k, o, 3) float
        Half the peak-to-peak of each output, m.
    mode : DampedMode
        The mode without the air, as far as it was followed.
    """

    nodal_diameter: int
    aerodynamic_damping: float
    linear_damping: float
    amplitude: Floats = field(metadata={"unit": "kg^0.5 m"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    amplitude_stable: Booleans
    output: Floats = field(metadata={"unit": "m"})
    mode: DampedMode

    @property
    def critical_kick(self) -> float:
        """Modal amplitude beyond which vibration grows without end, kg^½ m; inf if none was met.

        Zero where it grows from rest and no cycle holds it.
        """
        if len(self.amplitude):
            return float(np.inf if self.amplitude_stable[-1] else self.amplitude[-1])
        return 0.0 if self.linear_damping < 0 else float("inf")


def _coefficients(influence: Mapping[int, complex] | ArrayLike, sectors: int) -> Complex:
    """(N,) A_k of the nodal diameters 0 to N - 1 from influence coefficients."""
    L = np.zeros(sectors, complex)
    if isinstance(influence, Mapping):
        if len({m % sectors for m in influence}) < len(influence):
            raise InputError(f"influence: given sectors {sorted(influence)}: two are the same one")
        for m, value in influence.items():
            L[m % sectors] = value
    else:
        L = np.asarray(influence, complex)
        if L.shape != (sectors,):
            raise InputError(f"influence: given shape {L.shape}: needs ({sectors},), one a sector")
    if not np.isfinite(L).all():
        raise InputError("influence: given a coefficient that is not finite")
    return np.asarray(np.fft.fft(L))


def aerodynamic_damping(
    influence: Mapping[int, complex] | ArrayLike, sectors: int, frequency: ArrayLike
) -> Floats:
    """(N,) damping ratio of the air by nodal diameter, 0 to N - 1.

    Parameters
    ----------
    influence : dict of int to complex, or (N,) array_like
        L_m, 1/s²: modal force on sector 0 by a unit modal amplitude of sector m, of modes of unit
        mass; an array has m = 0 to N - 1. Sectors that are not named do nothing; m counts around
        the ring.
    sectors : int
        N.
    frequency : float or (N,) array_like
        Of the mode, Hz.

    Raises
    ------
    InputError
        If there are not N coefficients in an array, two name one sector, one is not finite, or a
        frequency is not > 0.
    """
    hertz = as_array(frequency, "frequency")
    if hertz.shape not in ((), (sectors,)) or not np.all(hertz > 0):
        raise InputError(f"frequency: given {frequency!r}: needs one > 0, or one a nodal diameter")
    A = _coefficients(influence, sectors)
    return np.asarray(-A.imag / (2 * (TURN * hertz) ** 2))


def limit_cycles(
    system: System,
    mode: int,
    influence: Mapping[int, complex] | ArrayLike,
    amplitudes: tuple[float, float] | None = None,
    options: Options = Options(),
    nodal_diameter: int | None = None,
    modes: Mapping[int, StuckModes] | None = None,
    progress: Progress | None = None,
) -> LimitCycles:
    """Limit cycles of a travelling wave, and whether each holds its amplitude, by the power.

    The air is taken to act on the fundamental of one mode and not to change its shape. The mode is
    followed twice: to find where its damping crosses that of the air, and once more through these
    places.

    Parameters
    ----------
    system : System
        Of its forces the static one alone acts.
    mode : int
        Its number, as of `damped_mode`.
    influence : dict of int to complex, or (N,) array_like
        As of `aerodynamic_damping`.
    amplitudes : (float, float), optional
        Range of modal amplitudes, kg^½ m, in which cycles are looked for; by default from stuck to
        gross slip.
    options, nodal_diameter, modes, progress
        As of `damped_mode`; progress is of both times.

    Raises
    ------
    InputError
        As of `damped_mode` and `aerodynamic_damping`.
    """
    every = _coefficients(influence, system.sectors)
    follow = partial(damped_mode, system, mode, modes=modes, progress=progress)
    found = follow(amplitudes, options, nodal_diameter)
    A = complex(every[found.nodal_diameter])
    guesses = _crossings(found.amplitude, _total(found, A))
    crossed, frequency, stable, output = [], [], [], []
    if guesses:
        asked = np.unique([a * (1 + each * _BESIDE) for a in guesses for each in (-1, 0, 1)])
        near = follow(asked, options, nodal_diameter)
        total = _total(near, A)
        for guess in guesses:
            beside = np.flatnonzero(np.abs(near.amplitude / guess - 1) < 1.5 * _BESIDE)
            if len(beside) < 3:
                continue  # the path ended before
            place = np.log(near.amplitude[beside] / guess)
            curve = np.polyfit(place, total[beside], 2)
            at = _root(curve)
            crossed.append(guess * np.exp(at))
            hertz = np.polyval(np.polyfit(place, near.frequency[beside], 2), at)
            frequency.append(np.sqrt((TURN * hertz) ** 2 - A.real) / TURN)
            stable.append(np.polyval(np.polyder(curve), at) > 0)
            sizes = near.response.amplitude[beside]
            output.append(sizes[1] + (sizes[2] - sizes[0]) * at / (place[2] - place[0]))
    outputs = found.response.amplitude.shape[1:]
    hertz, ratio = found.linear
    air = -A.imag / (2 * (TURN * hertz) ** 2)
    return LimitCycles(
        nodal_diameter=found.nodal_diameter,
        aerodynamic_damping=float(air),
        linear_damping=float(ratio + air),
        amplitude=np.array(crossed),
        frequency=np.array(frequency),
        amplitude_stable=np.array(stable, bool),
        output=np.array(output).reshape(-1, *outputs),
        mode=found,
    )


def _total(mode: DampedMode, A: complex) -> Floats:
    """(p,) damping ratio of structure, friction and air."""
    return np.asarray(mode.damping_ratio - A.imag / (2 * (TURN * mode.frequency) ** 2))


def _crossings(amplitude: Floats, total: Floats) -> list[float]:
    """Amplitudes, ascending, at which a curve of points crosses zero."""
    found = []
    for i in np.flatnonzero(np.diff(np.sign(total)) != 0):
        share = total[i] / (total[i] - total[i + 1])
        found.append(float(amplitude[i] * (amplitude[i + 1] / amplitude[i]) ** share))
    return sorted(found)


def _root(curve: Floats) -> float:
    """The root of a parabola nearest to zero; by its slope there where it has none."""
    _, slope, value = curve
    roots = np.roots(curve)
    real = roots[np.isreal(roots)].real
    if len(real):
        return float(real[np.abs(real).argmin()])
    return float(-value / slope)
