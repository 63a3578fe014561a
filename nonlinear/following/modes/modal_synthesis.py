"""Forced response near a resonance drawn from a damped mode, at any level of a load.

Of the motion at Ω the mode takes a φ(a), a force along its shape as large as

    Λ = (ω² - Ω² + 2iDω² + i(Ω - ω) φᴴCφ) a,

C the structure's own damping, since what friction takes in a period does not depend on Ω. The load
f e^{iθ} drives the mode by φᴴf and moves the other modes besides, which the contacts feel
(`other_modes`); to first order in that

    Λ(a, Ω) = (φᴴf - α) e^{iθ} - β e^{-iθ}.

For each amplitude the imaginary part gives two phases θ, the real part a frequency Ω of each: the
sides of the peak. α and β are those at Ω = ω. Without them it is the synthesis of one mode alone
(M. Krack, L. Panning-von Scheidt, J. Wallaschek, A method for nonlinear modal analysis and
synthesis: application to harmonically forced and self-excited mechanical systems, Journal of Sound
and Vibration 332 (2013) 6798-6814). With one harmonic a load along the mode's own shape is exact.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.held_vibration import HeldVibration
from vanelock.nonlinear.contact.law import STUCK
from vanelock.nonlinear.following.modes.damped_mode import DampedMode
from vanelock.nonlinear.following.modes.other_modes import Rest, rest_of
from vanelock.nonlinear.following.modes.synthesised_curve import (
    SynthesisedCurve,
    joined_curves,
    small_parts,
    taken,
)
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN, to_real
from vanelock.rom.system.system import System

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


@one_thread
def modal_synthesis(system: System, mode: DampedMode) -> ModalSynthesis:
    """A damped mode under the load of a system, ready to be drawn at any level.

    Parameters
    ----------
    system : System
        Whose mode it is, with a load of the first harmonic; its nodal diameter is that of the mode.
    mode : DampedMode
        Followed as far as the load drives it, with `self_excitation` as by default.

    Returns
    -------
    ModalSynthesis
        Its `response` draws the curve under a multiple of the load.

    Raises
    ------
    InputError
        If the mode is another nodal diameter's or not of the system, or the load does not drive it
        or acts at other harmonics, too.
    """
    _check(system, mode)
    response, load = mode.response, system.force[1]
    H, k = response.harmonics, mode.nodal_diameter
    wave = list(response.harmonic_diameters) == [h * k % system.sectors for h in range(H + 1)]
    options = Options(H, response.coupling, response.friction, samples=response.samples or None)
    made = structure(
        replace(system, force={h: each for h, each in system.force.items() if h == 0}),
        H,
        "wave" if wave else "sector",
    )
    friction = options.law(system.contacts)(H)
    coupled = response.coupling == "coupled"
    shapes, M = made.at(1).shapes.conj().T, system.at(k).M
    moving = np.any(response.state != STUCK, axis=0)
    counted = moving if moving.any() else np.ones_like(moving)
    found = []
    for i in np.flatnonzero(mode.converged).tolist():
        deviation = response.contact[i] - response.force[i] / response.stiffness
        w = to_real(deviation.reshape(H + 1, -1)).reshape(*deviation.shape[1:], 2 * H + 1)
        mean = None if coupled else response.contact[i, 0].real
        if not coupled:
            w[:, :, 0] = 0.0
        omega, a = TURN * float(mode.frequency[i]), float(mode.amplitude[i])
        shape = shapes @ (M @ mode.shape[i])
        held = HeldVibration(made, shape, omega, 0.0, mean, everywhere=False)
        rest = rest_of(made, friction, held, a, w, shapes @ load.vector, counted)
        found.append(rest)
    return _collected(mode.at(mode.converged), found, load.omega_power)


def _check(system: System, mode: DampedMode) -> None:
    """Refuse what does not fit.

    Raises
    ------
    InputError
    """
    if 1 not in system.force:
        raise InputError("system: has no load of the first harmonic, force/1, that drives a mode")
    if more := sorted(h for h in system.force if h > 1):
        raise InputError(f"system: has force/{more[0]}; a mode is drawn under force/1 alone")
    k = system.nodal_diameter(1)
    if k != mode.nodal_diameter:
        raise InputError(
            f"mode: is of nodal diameter {mode.nodal_diameter}; the load, of engine order "
            f"{system.engine_order}, is of {k}"
        )
    size = len(system.at(k).M)
    if mode.response.x[1].shape[1] != size or len(mode.response.mu) != system.contacts.count:
        raise InputError(
            f"mode: has {mode.response.x[1].shape[1]} coordinates and {len(mode.response.mu)} "
            f"contacts; the system has {size} and {system.contacts.count}"
        )
    driving = np.abs(mode.shape.conj() @ system.force[1].vector)
    if not driving.all():
        raise InputError("system: force/1 does not drive the mode")


def _collected(mode: DampedMode, found: list[Rest], omega_power: int) -> ModalSynthesis:
    """All points, phases counted from that of φᴴf."""
    driving = np.array([each.driving for each in found])
    turned = driving / np.abs(driving)
    pair = np.column_stack([turned.conj(), turned])
    others = np.array([each.output for each in found]) * pair[:, :, None, None]
    force = np.array([each.force for each in found]) * pair
    contact = []
    for each, phase in zip(found, turned, strict=True):
        real, imaginary = phase.real, phase.imag
        turn = np.array([[real, imaginary], [-imaginary, real]])
        (a, b), c = each.contact[:2], each.contact[2]
        square = turn.T @ np.array([[a, c], [c, b]]) @ turn / each.own
        contact.append([square[0, 0], square[1, 1], square[0, 1]])
    return ModalSynthesis(
        amplitude=mode.amplitude,
        frequency=mode.frequency,
        damping_ratio=mode.damping_ratio,
        damping=np.array([each.damping for each in found]),
        driving=np.abs(driving),
        force=force,
        output=mode.response.output[:, 1] * turned[:, None, None],
        others=others * turned[:, None, None, None],
        contact=np.array(contact),
        omega_power=omega_power,
    )
