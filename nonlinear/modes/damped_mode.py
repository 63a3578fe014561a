"""Damped nonlinear modes: frequency and damping ratio against amplitude, from stuck to gross slip.

A mode of a structure with friction is taken as the periodic motion that a self-excitation -ξ M q̇
keeps up (extended periodic motion concept, Krack 2015),

    M q̈ + (C - ξ M) q̇ + K q + f(q, q̇) = 0,      q₁ = a φ,   φᴴMφ = 1,      D = ξ/(2ω),

in all harmonics, coupled with the mean as forced vibration is. The self-excitation may be that of
the fundamental alone: the higher harmonics are then damped as they are in forced vibration.

Where a mode begins: the linear mode about the state at rest, and where contacts leave it.

About rest, contacts that are closed act as springs, those without friction as normal ones alone,
and the others are open. A contact at rest under the normal force n₀ begins to slip where

    a (k_t |u_t| + μ k_n |v|) = μ n₀,      a k_n |v| = n₀

where it opens, u and v its displacements in the mode of modal amplitude 1.
"""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Booleans, Complex, Floats, as_array, as_whole
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.balance import Structure, structure
from vanelock.nonlinear.balance.held_vibration import HeldVibration
from vanelock.nonlinear.balance.limit_modes import limit_modes
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.continuation.globalisation import from_nothing
from vanelock.nonlinear.forced_response.frequency_sweep import Progress
from vanelock.nonlinear.forced_response.options import (
    Options,
    PreparedSystem,
    check_option,
    static_part,
)
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import TURN, one_thread
from vanelock.nonlinear.modes.mode import Mode, ModePath, ModePoint
from vanelock.nonlinear.newton.newton import Solution, refined
from vanelock.rom.system.system import System

_BEGIN = 0.1  # where a mode begins, of the amplitude at which the first contact slips or opens


@dataclass(frozen=True)
class DampedMode(Product):
    """Frequency and damping ratio of a mode at p amplitudes.

    Attributes
    ----------
    mode : int
        Its number, from 1, of those of the nodal diameter about the state at rest.
    nodal_diameter : int
        Of the fundamental.
    amplitude : (p,) float
        Modal amplitude a = (q₁ᴴ M q₁)^½ of the fundamental, kg^½ m.
    frequency : (p,) float
        Hz.
    damping_ratio : (p,) float
        D = ξ/(2ω): of friction, of modal damping and of a given C together.
    linear : (2,) float
        Frequency, Hz, and damping ratio of the mode about rest that it begins with.
    converged : (p,) bool
        Whether the contacts' balance and the equation of motion are solved.
    residual : (p,) float
        What is left of the fundamental's equation of motion: a force along the mode shape, by a ω².
    ended : str
        Where the path ended and why, in words; empty where it arrived.
    failed : int
        Steps that failed on the way; shorter ones followed.
    response : Response
        The whole motion at each amplitude, its phase arbitrary; at the frequency of the mode and
        without excitation.
    """

    mode: int
    nodal_diameter: int
    amplitude: Floats = field(metadata={"unit": "kg^0.5 m"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    damping_ratio: Floats
    linear: Floats
    converged: Booleans
    residual: Floats
    ended: str
    failed: int
    response: Response

    @property
    def shape(self) -> Complex:
        """(p, n) mode shapes φ, φᴴMφ = 1, in the coordinates of the nodal diameter, kg^-½."""
        return np.asarray(self.response.x[1] / self.amplitude[:, None])

    def at(self, points: Any) -> "DampedMode":
        """Some of the points."""
        by_point = ("amplitude", "frequency", "damping_ratio", "converged", "residual")
        chosen = {name: getattr(self, name)[points] for name in by_point}
        return replace(self, response=self.response.at(points), **chosen)


@one_thread
def damped_mode(
    system: System,
    mode: int,
    amplitudes: ArrayLike | tuple[float, float] | None = None,
    options: Options = Options(),
    nodal_diameter: int | None = None,
    self_excitation: str = "fundamental",
    progress: Progress | None = None,
    modes: Mapping[int, StuckModes] | None = None,
) -> DampedMode:
    """A mode's frequency and damping ratio against its amplitude.

    It is followed from the linear mode about the state at rest. Where amplitudes turn back the path
    goes on through the fold, and the points of a range come in its order.

    Parameters
    ----------
    system : System
        Of its forces the static one alone acts.
    mode : int
        Its number, from 1, by frequency with all contacts stuck that are closed at rest; motions
        that nothing holds do not count.
    amplitudes : (p,) array_like or (float, float), optional
        Modal amplitudes, kg^½ m. An array or list: where the path passes them first. A tuple (low,
        high): a range, sampled as the curve needs it. By default from a tenth of that at which the
        first contact leaves the linear mode to a hundred times that at which the last slips or
        opens of the contacts that the linear limit "free" opens.
    options : Options
        Harmonics, one at least, coupling, friction, samples and tolerance.
    nodal_diameter : int, optional
        Of the travelling wave, 0 to N - 1; by default that of the engine order. The system needs
        matrices of its multiples too, up to that of the highest harmonic.
    self_excitation : {"fundamental", "all"}
        Harmonics on which -ξ M q̇ acts. On the fundamental alone, higher ones keep their damping,
        as under a force of that harmonic. On all, as Krack has it, modes that a higher harmonic
        excites lose theirs, too: where one is near, the path may leave the mode.
    progress : callable, optional
        Called after each point with (points done, points in all, estimated; Hz; modal amplitude).
    modes : dict of int to StuckModes, optional
        As for `frequency_response`.

    Warns
    -----
    RuntimeWarning
        Where the path ended and why, if it did not arrive.

    Raises
    ------
    InputError
        If the mode or nodal diameter is not there, an amplitude or option is not possible, the
        system has elements, or its state at rest is not found.
    """
    wanted = _checked_amplitudes(amplitudes)
    check_option("self_excitation", self_excitation, ("fundamental", "all"))
    system = _turned(system, options, nodal_diameter)
    made = structure(system, options.highest, options.harmonic_diameters, modes)
    ready = PreparedSystem(replace(options, harmonics=options.highest), made)
    rest, linear = _begun(ready, as_whole(mode, "mode"))
    # Where the balance of the mean is apart, it vibrates about that at rest.
    mean = None if options.coupling == "coupled" else rest.u[:, :, 0]
    everywhere = self_excitation == "all"
    held = HeldVibration(made, linear.shape, linear.omega, linear.xi, mean, everywhere)
    starting = Mode(held, ready.law(made.harmonics))
    first = _BEGIN * linear.onset
    floor = first if np.isfinite(first) else 0.0
    if wanted is not None:
        first = min(first, float(wanted[0]))
    elif not np.isfinite(first):
        raise InputError("amplitudes: none given, and no contact can slip or open: needs a range")
    begin = _smallest(starting, rest, first, options.tolerance)
    path = ModePath(begin, options.tolerance, floor)
    points: list[ModePoint] = []
    for point in path.through(wanted, isinstance(amplitudes, tuple), linear.onset):
        points.append(point)
        if progress is not None:
            progress(len(points), len(points) + 1, point.omega / TURN, point.amplitude)
    if not points:
        lowest = 0.0 if wanted is None else wanted[0]
        raise InputError(f"amplitudes: given {lowest:g}: the path ended before, {path.where}")
    ended = "" if path.arrived else f"the path ended {path.where}"
    if ended:
        warnings.warn(f"damped_mode: {ended}", RuntimeWarning, stacklevel=5)
    each = iter(points)

    def motion(omega: float, w: Floats) -> list[Array]:
        """Modal amplitudes of the next point, static mean and all."""
        point = next(each)
        return point.held.motion(point.solution.parameter, w)[0]

    response = ready.response([point.solution for point in points], motion, driven=False)
    return DampedMode(
        mode=mode,
        nodal_diameter=ready.structure.nodal_diameters[1],
        amplitude=np.array([point.amplitude for point in points]),
        frequency=response.frequency,
        damping_ratio=np.array([point.damping_ratio for point in points]),
        linear=np.array([linear.omega / TURN, linear.xi / (2 * linear.omega)]),
        converged=response.converged,
        residual=np.array([point.left for point in points]),
        ended=ended,
        failed=path.failed,
        response=response,
    )


def _turned(system: System, options: Options, nodal_diameter: int | None) -> System:
    """The system as a wave of the nodal diameter sees it, under its static force alone."""
    system.contacts.refuse_elements("a damped mode")
    H = options.highest
    if H == 0:
        raise InputError("harmonics: given 0: a mode needs at least 1")
    for name in ("direction", "static_beyond"):
        if (given := getattr(options, name)) is not None:
            raise InputError(f"{name}: given {given!r}: a damped mode has none: leave it out")
    k = system.nodal_diameter(1)
    if nodal_diameter is not None:
        k = as_whole(nodal_diameter, "nodal_diameter")
    if not 0 <= k < system.sectors:
        raise InputError(f"nodal_diameter: given {k}: allowed: 0 to {system.sectors - 1}")
    have = {folded(each, system.sectors) for each in system.diameters}
    wave = options.harmonic_diameters == "wave"
    for h in range(H + 1):
        needed = k * h if wave else k * min(h, 1)
        if folded(needed % system.sectors, system.sectors) not in have:
            held, of = ", ".join(map(str, sorted(have))), f"harmonic {h} has nodal diameter"
            raise InputError(
                f"nodal_diameter: given {k}: {of} {needed % system.sectors}, "
                f"but the system holds {held}"
            )
    force = {h: each for h, each in system.force.items() if h == 0}
    return replace(system, engine_order=k, force=force)


_HELD = 1e-10
"""Share of stiffness in (stiffness + σ² mass), σ about the lowest frequency, of what is held."""


@dataclass(frozen=True)
class _LinearMode:
    """A linear mode about the state at rest.

    `shape` (n,): VᴴMφ in the fundamental's modes V, φᴴMφ = 1; `omega`: rad/s, without damping;
    `xi`: ξ of its own damping, 1/s; `onset`: modal amplitude at which the first contact slips,
    opens or closes, kg^½ m, by estimate; inf where none does.
    """

    shape: Array
    omega: float
    xi: float
    onset: float


def _linear_mode(structure: Structure, mode: int, rest: Solution) -> _LinearMode:
    """A mode of the first harmonic's nodal diameter about the state at rest."""
    contacts, modes = structure.system.contacts, structure.at(1)
    gap = rest.u[:, 0, 0]
    closed = np.repeat((gap > 0)[:, None], 3, axis=1)
    closed[:, 1:] &= (contacts.mu > 0)[:, None]
    limit = limit_modes(modes, structure.stiffness, closed.reshape(-1))
    with np.errstate(divide="ignore"):
        square = np.where(limit.compliance > 0, limit.static / limit.compliance, np.inf)
    vibrates = np.flatnonzero((limit.static > _HELD) & np.isfinite(square))
    if not 1 <= mode <= len(vibrates):
        raise InputError(f"mode: given {mode}: allowed: 1 to {len(vibrates)}, by frequency")
    chosen = vibrates[np.argsort(square[vibrates], kind="stable")][mode - 1]
    unit = np.zeros(len(square))
    unit[chosen] = 1.0
    shape = unit if limit.shapes is None else limit.shapes[:, chosen]
    mass = float(limit.compliance[chosen])
    damping = limit.damping[chosen] if limit.damping.ndim == 1 else limit.damping[chosen, chosen]
    shape = shape / np.sqrt(mass)
    moved = np.abs(modes.rows @ shape).reshape(-1, 3)
    return _LinearMode(
        shape=np.asarray(modes.compliance * shape, complex),
        omega=float(np.sqrt(square[chosen])),
        xi=float(damping.real / mass),
        onset=_onset(structure, gap, moved),
    )


def _onset(structure: Structure, gap: Floats, moved: Floats) -> float:
    """Amplitude at which the first contact leaves the linear mode, kg^½ m."""
    contacts = structure.system.contacts
    slipping = contacts.kt * moved[:, 1:]
    slipping = slipping + (contacts.mu * contacts.kn * moved[:, 0])[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        slips = (contacts.mu * contacts.kn * gap.clip(0))[:, None] / slipping
        opens = np.abs(gap) / moved[:, 0]
    slips = slips[(gap > 0) & (contacts.mu > 0)]
    each = np.concatenate([slips.reshape(-1), opens])
    return float(np.min(each[each > 0], initial=np.inf))


def _begun(ready: PreparedSystem, mode: int) -> tuple[Solution, _LinearMode]:
    """The state at rest, and the linear mode about it."""
    made, tolerance = ready.structure, ready.options.tolerance

    def found(omega: float) -> tuple[Solution, _LinearMode]:
        rest = ready.rest
        if rest is None:
            rest = from_nothing(static_part(made).balance(omega), ready.law, tolerance)
        if not rest.converged:
            raise InputError("system: its state at rest was not found, about which modes vibrate")
        return rest, _linear_mode(made, mode, rest)

    rest, linear = found(0.0)
    force = made.system.force.get(0)
    if force is not None and force.omega_power:
        rest, linear = found(linear.omega)
    hertz, band = linear.omega / TURN, made.system.band
    if band is not None and hertz > band:
        raise InputError(
            f"mode: given {mode}: its {hertz:.6g} Hz lie beyond the {band:.6g} Hz up to which the "
            "system's reduced parts answer (its band)"
        )
    return rest, linear


def _smallest(mode: Mode, rest: Solution, amplitude: float, tolerance: float) -> ModePoint:
    """The mode's first point."""
    w = np.zeros((*rest.w.shape[:2], 2 * mode.held.structure.harmonics + 1))
    if mode.held.mean is None:
        w[:, :, 0] = rest.w[:, :, 0]
    for smaller in (1.0, 0.1, 0.01, 1e-3):
        found = refined(mode, w, smaller * amplitude, tolerance=tolerance)
        if found.converged:
            return ModePoint(mode, found)
    raise InputError(
        f"mode: no free vibration was found near {mode.held.omega / TURN:g} Hz at the small modal "
        f"amplitude {amplitude:g} to begin with"
    )


def _checked_amplitudes(amplitudes: ArrayLike | tuple[float, float] | None) -> Floats | None:
    """(p,) amplitudes, ascending; those of a range are its ends."""
    if amplitudes is None:
        return None
    given = np.atleast_1d(as_array(amplitudes, "amplitudes"))
    if given.ndim != 1 or not len(given) or not np.all(np.isfinite(given) & (given > 0)):
        raise InputError(f"amplitudes: given {given.tolist()}: must be > 0 and finite")
    if isinstance(amplitudes, tuple) and (len(given) != 2 or given[0] >= given[1]):
        raise InputError(f"amplitudes: given {amplitudes}: a range is (low, high), low < high")
    return np.unique(given)
