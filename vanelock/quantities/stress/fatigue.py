"""High-cycle fatigue: how far mean and alternating stress stay from the Goodman line.

Of the stress tensor over a period, σ(t) = σ_0 + Re Σ_{h≥1} σ_h e^{ihωt}, two numbers are made:

    σ_a = max_t σ_vM(σ(t) - σ_0),      σ_m = tr σ_0 = 3 (hydrostatic mean stress),

√2/3 σ_a being the octahedral shear amplitude: Sines' criterion (G. Sines, Behavior of metals
under complex static and alternating stresses, in: Sines, Waisman (ed.), Metal Fatigue,
McGraw-Hill 1959, 145-169), in which a mean torsion does no harm. It is scaled to the Goodman line
of a bar (J. Goodman, Mechanics Applied to Engineering, 1899) with its fatigue limit S_e at no
mean stress and tensile strength S_u,

    σ_a / S_e + max(σ_m, 0) / S_u = 1 / n;

a mean compression is given no credit. n scales both stresses; by how much vibration alone may
grow is S_e (1 - σ_m/S_u) / σ_a.

σ_a is the largest distance from the mean, so not less than the radius of the smallest sphere
round the path (K. Dang Van, I. V. Papadopoulos (ed.), High-Cycle Metal Fatigue, Springer 1999),
nor than half of the largest difference between two instants, `chord`; for one harmonic the three
agree. With σ_m = ± σ_vM(σ_0), of the sign of the trace, the criterion is the one of handbooks (R.
G. Budynas, J. K. Nisbett, Shigley's Mechanical Engineering Design, section on combinations of
loading modes); both are kept.
"""

from dataclasses import dataclass, field

import numpy as np

from vanelock import fem
from vanelock.common.arrays import Complex, Floats
from vanelock.common.product import Product

_Stress = Complex

_BLOCK = 64
"""Nodes whose pairs of instants are looked at together."""


@dataclass(frozen=True)
class Cycle(Product):
    """Equivalent stresses of a period at n places, Pa.

    Attributes
    ----------
    amplitude : (n,) float
        Largest von Mises stress of what alternates.
    mean : (n,) float
        Trace of the mean stress.
    mean_mises : (n,) float
        Von Mises stress of the mean, with the sign of its trace.
    chord : (n,) float
        Half of the largest von Mises stress of a difference between two instants.
    """

    amplitude: Floats = field(metadata={"unit": "Pa"})
    mean: Floats = field(metadata={"unit": "Pa"})
    mean_mises: Floats = field(metadata={"unit": "Pa"})
    chord: Floats = field(metadata={"unit": "Pa"})


def cycle(harmonics: _Stress) -> Cycle:
    """Equivalent stresses of a period."""
    mean = harmonics[0].real
    alternating = harmonics.copy()
    alternating[0] = 0
    trace = mean[:, :3].sum(axis=1)
    return Cycle(
        amplitude=fem.peak_von_mises(alternating),
        mean=trace,
        mean_mises=np.where(trace < 0, -1.0, 1.0) * fem.von_mises(mean),
        chord=_half_chord(alternating),
    )


def _half_chord(harmonics: _Stress) -> Floats:
    """Half of the largest von Mises stress of σ(t) - σ(s) over all t and s, (n,) Pa.

    Taken from 16 H samples of the period, which miss no more than 2 % of harmonic H.
    """
    count = 16 * max(len(harmonics) - 1, 1)
    found = np.empty(harmonics.shape[1])
    for start in range(0, len(found), _BLOCK):
        block = slice(start, start + _BLOCK)
        s = np.moveaxis(fem.deviators(harmonics[:, block], count), 1, 0)
        square = np.sum(s**2, axis=2, keepdims=True)
        one = np.ones_like(square)  # |s - t|^2 = |s|^2 + |t|^2 - 2 s.t
        apart = np.dstack([s, square, one]) @ np.dstack([-2 * s, one, square]).swapaxes(1, 2)
        found[block] = np.sqrt(apart.max(axis=(1, 2)).clip(0)) / 2
    return found
