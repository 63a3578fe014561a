"""Resonances that nothing bounds, where at most friction damps a system.

At the natural frequency of a mode φ whose contacts slide, the harmonic of a friction force, 4/π μ n
at most, is all that can hold the load f. No vibration is steady there where

    |φᴴ f| > 4/π Σ μ n |φ_t|,

if φ moves no contact in its normal direction, and every n that counts stays as it is. Elsewhere
there is no more to see than that a largest amplitude is not found.
"""

import numpy as np

from vanelock.common.arrays import Array, Floats
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Structure
from vanelock.nonlinear.balance.limit_modes import limit_modes
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier.trigonometric import TURN
from vanelock.rom.system.system import System

SMALL = 1e-9
"""Of the largest, what counts as none of loads and motions."""
LEAST = 1e-2
"""Of the load's work, friction's at a top that it holds: there it is all, or nearly."""


def check_bound(
    structure: Structure,
    limits: tuple[float, float],
    output: tuple[int, int] | None,
    what: str,
    lost: float | None = None,
) -> None:
    """Refuse a range, rad/s, in which friction does not bound a resonance of an output, or of any.

    Where a largest amplitude is `lost`, rad/s, refuse that friction alone may bound it, too.
    """
    if unheld := unbound(structure, limits, output):
        omega, why = unheld[0], f"friction holds {unheld[1]:.3g} of its load at most"
    elif lost is not None and not _damped(structure.system):
        omega, why = lost, "friction alone may not bound it"
    else:
        return
    raise InputError(
        f"{what}: near {omega / TURN:.6g} Hz it grows without damping, and {why}; "
        "give damping, less load, or another range"
    )


def check_top(structure: Structure, response: Response, output: tuple[int, int], what: str) -> None:
    """Refuse a largest amplitude inside a range that neither damping nor friction holds.

    At a resonance that is bounded the load's work, π Σ h |f_h x_h| at most, is that of friction; a
    top at which friction does next to none is a point beside a pole.
    """
    sizes = np.where(response.converged, response.amplitude[:, *output], 0.0)
    top, system = int(sizes.argmax()), structure.system
    if _damped(system) or top in (response.frequency.argmin(), response.frequency.argmax()):
        return
    omega = TURN * float(response.frequency[top])
    work = np.pi * sum(
        h * abs(np.vdot(force.at(omega), response.x[h][top]))
        for h, force in system.force.items()
        if h
    )
    if response.dissipation[top].sum() < LEAST * work:
        limits = TURN * response.frequency
        check_bound(structure, (limits.min(), limits.max()), output, what, omega)


def unbound(
    structure: Structure, limits: tuple[float, float], output: tuple[int, int] | None
) -> tuple[float, float] | None:
    """A resonance that friction does not bound, rad/s, and the largest share of f that it holds."""
    if _damped(structure.system):
        return None
    contacts, count = structure.system.contacts, structure.system.contacts.count
    normal = np.stack([abs(modes.rows[::3]).max(axis=1) for modes in structure.modes.values()])
    limit = contacts.mu * contacts.kn * contacts.v0.clip(0)
    limit[normal.any(axis=0) & (contacts.mu > 0)] = np.inf
    for h in filter(None, structure.unit_forces):
        modes, power = structure.at(h), structure.system.force[h].omega_power
        sliding = limit_modes(modes, structure.stiffness, np.tile([True, False, False], count))
        shapes = np.eye(len(modes.static)) if sliding.shapes is None else sliding.shapes
        with np.errstate(divide="ignore", invalid="ignore"):
            omega = np.sqrt(sliding.static / sliding.compliance) / h
        moved = _counted(modes.rows @ shapes).reshape(count, 3, shapes.shape[1])
        friction = np.where(moved[:, 1:] > 0, limit[:, None, None], 0.0) * moved[:, 1:]
        hold = 4 / np.pi * friction.sum(axis=(0, 1))
        push = _counted(shapes.conj().T @ structure.unit_forces[h]) * omega**power
        seen = _counted(structure.output_rows[h] @ shapes)
        seen = seen.max(axis=(0, 1)) if output is None else seen[output]
        within = (omega >= min(limits)) & (omega <= max(limits)) & ~moved[:, 0].any(axis=0)
        for i in np.flatnonzero(within & (seen > 0) & (push > (1 + SMALL) * hold)):
            return float(omega[i]), float(hold[i] / push[i])
    return None


def _counted(moved: Array) -> Floats:
    """Their sizes, but for those that round-off leaves."""
    sizes = np.abs(moved)
    return np.where(sizes < SMALL * sizes.max(initial=0.0), 0.0, sizes)


def _damped(system: System) -> bool:
    """Whether more than friction damps a system."""
    if system.damping_ratio or system.contacts.elements:
        return True
    return any(each.C is not None and bool(np.any(each.C)) for each in system.diameters.values())
