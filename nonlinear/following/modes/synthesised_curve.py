"""A damped mode under a load, to be drawn at any level of it (`modal_synthesis`)."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.fourier.trigonometric import TURN

Array = NDArray[np.complex128]
Floats = NDArray[np.float64]

FINE = 64
"""Amplitudes between two points of a mode at which a curve is looked for."""
SIDE = 200
"""Points of a curve on each side of a peak."""
SLOWEST = 1e-3
"""Lowest frequency that counts, of the mode's: a load that is static moves it more than that."""
FASTER = 0.1
"""Change of the frequency that counts as much as one of the amplitude by a factor of e."""


@dataclass(frozen=True)
class SynthesisedCurve:
    """Vibration at k points, drawn from one mode.

    Attributes
    ----------
    frequency : (k,) float
        Of the load, Hz.
    amplitude : (k,) float
        Modal amplitude of the mode, kg^½ m.
    output : (k, o, 3) complex
        Displacement of the output nodes in the fundamental, m.
    others : (k,) float
        Vibration of the contacts that comes with the other modes, of the mode's own; at most 1.
    curve : (k,) int
        Which curve each point is of, from 0: those of one number are joined, up the lower side of a
        peak and down the upper one. A second one is a resonance apart from the first.
    """

    frequency: Floats
    amplitude: Floats
    output: NDArray[np.complex128]
    others: Floats
    curve: NDArray[np.int64]


def small_parts(curve: SynthesisedCurve) -> list[SynthesisedCurve]:
    """Stretches that have a frequency, where other modes move the contacts less than the mode."""
    sound = (curve.others <= 1) & np.isfinite(curve.frequency)
    small = np.concatenate([[False], sound, [False]])
    begin, end = (np.flatnonzero(np.diff(small.astype(int)) == sign) for sign in (1, -1))
    return [taken(curve, slice(*each)) for each in zip(begin, end, strict=True)]


def taken(curve: SynthesisedCurve, points: slice) -> SynthesisedCurve:
    """Some of the points."""
    chosen = {each.name: getattr(curve, each.name)[points] for each in fields(curve)}
    return SynthesisedCurve(**chosen)


def joined_curves(curves: Sequence[SynthesisedCurve], number: bool = False) -> SynthesisedCurve:
    """Curves one after another, numbered or taken for one."""
    joined = {
        each.name: np.concatenate([getattr(curve, each.name) for curve in curves])
        for each in fields(SynthesisedCurve)
    }
    if number:
        joined["curve"] = np.repeat(np.arange(len(curves)), [len(each.curve) for each in curves])
    return SynthesisedCurve(**joined)


@dataclass(frozen=True)
class ModalSynthesis(Product):
    """A damped mode under a load, ready to be drawn at any level of it.

    Attributes
    ----------
    amplitude, frequency, damping_ratio : (p,) float
        Of the mode: kg^½ m, Hz, 1.
    damping : (p,) float
        φᴴCφ of the structure's own damping, 1/s.
    driving : (p,) float
        |φᴴf|, N/kg^½; the load's phase is counted from that of φᴴf.
    force : (p, 2) complex
        α and β, N/kg^½.
    output : (p, o, 3) complex
        Displacement of the output nodes in the mode, m.
    others : (p, 2, o, 3) complex
        What the other modes add to it with e^{iθ} and with e^{-iθ}, m.
    contact : (p, 3) float
        |u|² that they add to the contacts' vibration, of the mode's own: with cos² θ, sin² θ and
        2 sin θ cos θ.
    omega_power : int
        Of the load.
    """

    amplitude: Floats = field(metadata={"unit": "kg^0.5 m"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    damping_ratio: Floats
    damping: Floats = field(metadata={"unit": "1/s"})
    driving: Floats = field(metadata={"unit": "N kg^-0.5"})
    force: Array = field(metadata={"unit": "N kg^-0.5"})
    output: Array = field(metadata={"unit": "m"})
    others: Array = field(metadata={"unit": "m"})
    contact: Floats
    omega_power: int = 0

    def response(self, scale: float = 1.0, others: bool = True) -> SynthesisedCurve:
        """The curve under the load times a factor.

        Parameters
        ----------
        scale : float
        others : bool
            Whether other modes count.

        Returns
        -------
        SynthesisedCurve
            Without points at which the other modes move the contacts more than the mode does: there
            their influence is not small. Empty where that leaves none.

        Raises
        ------
        InputError
            If the factor is not positive.
        """
        if not (np.isfinite(scale) and scale > 0):
            raise InputError(f"scale: given {scale!r}: must be > 0 and finite")
        drawn = self if others else self._alone()
        path = drawn._path
        fine = np.concatenate(
            [np.linspace(a, b, FINE, endpoint=False) for a, b in pairwise(path.tolist())]
            + [path[-1:]]
        )
        exists = drawn._margin(fine, scale) >= 0
        edges = np.flatnonzero(np.diff(exists.astype(int)))
        ends = [fine[0], *(drawn._edge(fine[i], fine[i + 1], scale) for i in edges), fine[-1]]
        curves = []
        for low, high in pairwise(ends):
            if drawn._margin(np.array([(low + high) / 2]), scale)[0] < 0:
                continue
            places = low + (high - low) * (1 - np.cos(np.linspace(0, np.pi, SIDE))) / 2
            sides = drawn._side(places, scale, -1), drawn._side(places[::-1], scale, 1)
            meet = high < fine[-1]
            curves += [joined_curves(sides)] if meet else list(sides)
        parts = [each for curve in curves for each in small_parts(curve)]
        nothing = taken(drawn._side(fine[:1], scale, -1), slice(0))
        return joined_curves(parts or [nothing], number=True)

    def _alone(self) -> "ModalSynthesis":
        """The mode without others."""
        none = {name: 0 * getattr(self, name) for name in ("force", "others", "contact")}
        return replace(self, **none)

    @property
    def _path(self) -> Floats:
        """(p,) places of the points along the mode, which may turn back."""
        steps = np.hypot(np.diff(np.log(self.amplitude)), np.diff(np.log(self.frequency)) / FASTER)
        return np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1e-12))])

    def _between(self, name: str, places: Floats) -> NDArray[np.float64]:
        """An attribute between the points of the mode."""
        from scipy.interpolate import PchipInterpolator  # it loads CHOLMOD: when asked for

        values, path = getattr(self, name), self._path
        if not np.iscomplexobj(values):
            return np.asarray(PchipInterpolator(path, values)(places))
        real, imaginary = (
            PchipInterpolator(path, part)(places) for part in (values.real, values.imag)
        )
        return np.asarray(real + 1j * imaginary)

    def _at(self, places: Floats, scale: float, side: int) -> tuple[Floats, Floats, Floats]:
        """Ω, rad/s, θ and what is left for the two sides to be apart, N/kg^½.

        `side` -1: the lower frequency; 1: the upper one; 0: as if both met.
        """
        omega, a = TURN * self._between("frequency", places), self._between("amplitude", places)
        ratio, damping = (self._between(name, places) for name in ("damping_ratio", "damping"))
        along, force = self._between("driving", places), self._between("force", places)
        now = omega
        for _ in range(50):
            grown = scale * now**self.omega_power
            ahead, back = grown * (along - force[:, 0]), grown * force[:, 1]
            lost = (2 * ratio * omega**2 + (now - omega) * damping) * a
            cosine, sine = ahead.imag - back.imag, ahead.real + back.real
            most = np.hypot(cosine, sine)
            turn = np.arccos(np.clip(lost / most, -1, 1)) if side else np.zeros(len(omega))
            middle = np.arctan2(sine, cosine)
            first, second = (
                (theta, (ahead * np.exp(1j * theta) - back * np.exp(-1j * theta)).real)
                for theta in (middle + turn, middle - turn)
            )
            swap = (second[1] > first[1]) if side < 0 else (second[1] < first[1])
            theta, held = (np.where(swap, *pair) for pair in zip(second, first, strict=True))
            following = np.sqrt(np.maximum(omega**2 - held / a, (SLOWEST * omega) ** 2))
            done = np.abs(following - now).max(initial=0.0) < 1e-12 * omega.max()
            now = following
            if done:
                break
        return now, theta, most - lost

    def _margin(self, places: Floats, scale: float) -> Floats:
        """Negative where the load does not reach an amplitude, N/kg^½."""
        return self._at(places, scale, 0)[2]

    def _edge(self, low: float, high: float, scale: float) -> float:
        """Where the load just reaches an amplitude, by bisection."""
        inside = self._margin(np.array([low]), scale)[0] >= 0
        for _ in range(60):
            middle = (low + high) / 2
            if (self._margin(np.array([middle]), scale)[0] >= 0) == inside:
                low = middle
            else:
                high = middle
        return low if inside else high

    def _side(self, places: Floats, scale: float, side: int) -> SynthesisedCurve:
        """One side of a peak, where other modes move the contacts less than the mode."""
        omega, theta, _ = self._at(places, scale, side)
        own = TURN * self._between("frequency", places)
        grown = scale * omega**self.omega_power
        turned = np.exp(1j * theta)
        contact = self._between("contact", places)
        cosine, sine = np.cos(theta), np.sin(theta)
        square = contact[:, 0] * cosine**2 + contact[:, 1] * sine**2
        square = square + 2 * contact[:, 2] * sine * cosine
        aside = grown * np.sqrt(np.maximum(square, 0))
        more = self._between("others", places)
        phase = (grown * turned)[:, None, None], (grown / turned)[:, None, None]
        output = self._between("output", places) + phase[0] * more[:, 0] + phase[1] * more[:, 1]
        return SynthesisedCurve(
            frequency=np.where(omega > 1.01 * SLOWEST * own, omega, np.nan) / TURN,
            amplitude=self._between("amplitude", places),
            output=output / turned[:, None, None],
            others=aside,
            curve=np.zeros(len(omega), np.int64),
        )
