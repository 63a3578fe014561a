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

from dataclasses import replace

import numpy as np

from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.held_vibration import HeldVibration
from vanelock.nonlinear.contact.law import STUCK
from vanelock.nonlinear.following.modes.damped_mode import DampedMode
from vanelock.nonlinear.following.modes.other_modes import OtherModes, other_modes
from vanelock.nonlinear.following.modes.synthesised_curve import ModalSynthesis
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.fourier.threads import solving
from vanelock.nonlinear.fourier.trigonometric import TURN, to_real
from vanelock.rom.system.system import System


@solving
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
        rest = other_modes(made, friction, held, a, w, shapes @ load.vector, counted)
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


def _collected(mode: DampedMode, found: list[OtherModes], omega_power: int) -> ModalSynthesis:
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
