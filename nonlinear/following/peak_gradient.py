"""How the amplitude of a peak changes with the structure: one linear solution for all changes.

With w = W(u), u = ũ + R̂ w, J = dW/du and P = I - J R̂, an amplitude A that depends on w by g = dA/dw
changes with ũ by

    dA/dũ = Jᵀ y,      Pᵀ y = g.

A stiffness that grows by dK pushes with -dK x against each harmonic's motion x, which moves ũ and
the output at fixed w. Modal damping grows with it, D M⁻¹ D = 4ζ² K, in modes of frequencies ω by

    dD_ij = 2ζ dK_ij / (ω_i + ω_j).

Sliders assembled at s, m, move the mean of ũ by (R̂₀ - I) s. Those that stick for good count as
held, wherever they first slid to: they may be moved back from there, not on. The frequency of a
peak moves along, which changes nothing to first order.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import STUCK
from vanelock.nonlinear.following.parameters import Parameter
from vanelock.nonlinear.following.peak import PeakPoint, Resonance
from vanelock.nonlinear.following.peak_tracking import PeakTrack, named_component
from vanelock.nonlinear.forced_response.frequencies import checked_range
from vanelock.nonlinear.forced_response.options import Options, PreparedSystem
from vanelock.nonlinear.forced_response.response import extremes
from vanelock.nonlinear.forced_response.static_mean import static_part
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN, to_complex
from vanelock.nonlinear.newton.linearised import newton_matrix
from vanelock.nonlinear.newton.newton import Solution, active_rows
from vanelock.rom.system.system import System

Array = NDArray[Any]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PeakGradient:
    """A peak, and what moves its amplitude.

    Attributes
    ----------
    structure : Structure
    peak : PeakPoint
    motion : tuple of (n_h,)
        Modal amplitudes of each harmonic.
    by_motion : tuple of (n_h,)
        A changes by the real part of these times the change of `motion`, at fixed w.
    by_linear : (c, 3, 2H + 1) float
        dA/dũ, by the contacts.
    """

    structure: Structure
    peak: PeakPoint
    motion: tuple[Array, ...]
    by_motion: tuple[Array, ...]
    by_linear: Floats

    @property
    def amplitude(self) -> float:
        """A, half the peak-to-peak of the output, m."""
        return self.peak.amplitude

    @property
    def frequency(self) -> float:
        """Of the peak, Hz."""
        return self.peak.solution.omega / TURN

    def by_stiffness(self, changes: Mapping[int, Array]) -> float:
        """dA, m, by small changes of the stiffness.

        Parameters
        ----------
        changes : dict of int to (n, n)
            Hermitian dK, N/m, by nodal diameter; of N - k the conjugate counts where only k is
            given.
        """
        found, system = 0.0, self.structure.system
        contacts = to_complex(self.by_linear.reshape(-1, self.by_linear.shape[2])).conj()
        for h, k in enumerate(self.structure.nodal_diameters):
            change = changes.get(k)
            if change is None and (mirrored := changes.get(-k % system.sectors)) is not None:
                change = mirrored.conj()
            if change is None:
                continue
            modes, s = self.structure.at(h), h * self.peak.solution.omega
            modal = modes.shapes.conj().T @ change @ modes.shapes
            push = modal @ self.motion[h]
            if h and system.damping_ratio:
                push = push + 1j * s * (
                    _damping(modes, modal, system.damping_ratio) @ self.motion[h]
                )
            moved = modes.solve(s, push if h else push.real)
            found -= float(((self.by_motion[h] + contacts[h] @ modes.rows) @ moved).real)
        return found


@one_thread
def peak_gradient(
    system: System,
    near: tuple[float, float],
    options: Options = Options(),
    output: tuple[str, int] | None = None,
) -> PeakGradient:
    """The highest peak of a range, and what moves its amplitude.

    Parameters
    ----------
    system : System
    near : (float, float)
        Range of frequencies in which the peak is looked for, Hz.
    options : Options
        With one harmonic at least.
    output : (str, int), optional
        Name of the output node and direction, 0 to 2; by default those of the largest amplitude.

    Raises
    ------
    InputError
        As of `frequency_response`, or if no peak lies in the range, or the solutions fold there.
    """
    hertz = checked_range(near, "near")
    if options.harmonics == 0:
        raise InputError("harmonics: given 0: a peak needs at least 1")
    ready = options.prepare(system, hertz, 1000)
    low, high = TURN * hertz
    component = named_component(system.output_names, output)
    unvaried = Parameter("force", np.zeros(system.contacts.count, bool), False)
    track = PeakTrack(lambda _: ready, unvaried, (low, high), component, 1.0)
    swept = track.sweep(1.0)
    track = track.with_component(1.0, swept)
    peak = track.highest(1.0, swept)
    if peak is None or track.component is None:
        raise InputError("near: no peak was found in it")
    family, tolerance = ready.solver.family, ready.options.tolerance
    found = _gradient(ready, Resonance(family, track.component, tolerance), peak)
    if found is None:
        raise InputError("near: the solutions fold at the peak that was found in it")
    return found


def _gradient(ready: PreparedSystem, resonance: Resonance, peak: PeakPoint) -> PeakGradient | None:
    """The gradient at a peak; None where P is singular."""
    prepared, solution, rest = resonance.structure, peak.solution, ready.rest
    by_linear = _by_linear(resonance, solution)
    if by_linear is None:
        return None
    motion = prepared.amplitudes(solution.omega, solution.w)
    if rest is not None:  # what holds the mean depends on ũ at rest
        still = static_part(prepared)
        balance, held = still.balance(0.0), by_linear[:, :, :1]
        form = (balance.columns.all(0).real.T @ held.reshape(-1)).reshape(held.shape)
        moved = _through_law(balance, rest, form)
        if moved is None:
            return None
        by_linear[:, :, :1] += moved
        motion[0] = still.amplitudes(0.0, rest.w)[0]
    return PeakGradient(prepared, peak, tuple(motion), _by_motion(resonance, solution), by_linear)


def slider_gradient(resonance: Resonance, solution: Solution) -> Floats | None:
    """dA/ds of the amplitude at a peak, (c, 3); that of the normal direction is zero.

    None where P is singular.
    """
    by_linear = _by_linear(resonance, solution)
    if by_linear is None:
        return None
    flat = by_linear[:, :, 0].reshape(-1)
    if not flat.any():
        return np.zeros((len(by_linear), 3))
    balance = resonance.family.at(solution.omega)
    found = (balance.columns.all(0).real.T @ flat - flat).reshape(-1, 3)
    found[:, 0] = 0.0
    return np.asarray(found)


def _by_linear(resonance: Resonance, solution: Solution) -> Floats | None:
    """dA/dũ, (c, 3, 2H + 1); None where P is singular."""
    balance = resonance.family.at(solution.omega)
    return _through_law(balance, solution, _by_deviation(resonance, solution))


def _through_law(balance: Balance, solution: Solution, form: Floats) -> Floats | None:
    """Jᵀ y, (c, 3, m), with Pᵀ y = form (c, 3, m); None where P is singular."""
    count, _, m = solution.w.shape
    found = np.zeros((count, 3, m))
    rows = active_rows(solution.w, solution.deviation)
    rows = rows[solution.deviation.state[rows // (3 * m)] != STUCK]
    if not len(rows):
        return found
    try:
        matrix = newton_matrix(balance, solution.deviation, rows)
        y = np.linalg.solve(matrix.T, form.reshape(-1)[rows])
    except np.linalg.LinAlgError:
        return None
    slopes = solution.deviation.jacobian.reshape(-1, 3, m)[rows]
    np.add.at(found, rows // (3 * m), y[:, None, None] * slopes)
    return found


def _by_motion(resonance: Resonance, solution: Solution) -> tuple[Array, ...]:
    """Rows (n_h,) by which A = (q(θ₁) - q(θ₂)) / 2, at the extremes, follows the motion."""
    prepared = resonance.structure
    rows = [each[resonance.component] for each in prepared.output_rows]
    amplitudes = prepared.amplitudes(solution.omega, solution.w)
    q = np.array([row @ amplitude for row, amplitude in zip(rows, amplitudes, strict=True)])
    angles = extremes(q[:, None])[:, 0]
    shares = np.exp(1j * np.outer(np.arange(len(rows)), angles)) @ [0.5, -0.5]
    return tuple(share * row for share, row in zip(shares, rows, strict=True))


def _by_deviation(resonance: Resonance, solution: Solution) -> Floats:
    """dA/dw, (c, 3, 2H + 1)."""
    prepared, omega = resonance.structure, solution.omega
    form = np.zeros((len(prepared.stiffness), solution.w.shape[2]))
    for h, row in enumerate(_by_motion(resonance, solution)):
        if h:  # the mean counts at both extremes
            modes = prepared.at(h)
            by_w = (row @ modes.solve(h * omega, modes.pull)) * prepared.stiffness
            form[:, 2 * h - 1], form[:, 2 * h] = by_w.real, -by_w.imag
    return form.reshape(solution.w.shape)


def _damping(modes: StuckModes, modal: Array, ratio: float) -> Array:
    """What a change of the modal stiffness (n, n) adds to the modal damping."""
    with np.errstate(divide="ignore"):
        omega = np.sqrt(modes.static / modes.compliance)  # without end where there is no mass
    both = omega[:, None] + omega
    return np.asarray(2 * ratio * np.divide(modal, both, out=np.zeros_like(modal), where=both > 0))
