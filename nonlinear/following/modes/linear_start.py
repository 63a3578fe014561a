"""Where a mode begins: the linear mode about the state at rest, and where contacts leave it.

About rest, contacts that are closed act as springs, those without friction as normal ones alone,
and the others are open. A contact at rest under the normal force n₀ begins to slip where

    a (k_t |u_t| + μ k_n |v|) = μ n₀,      a k_n |v| = n₀

where it opens, u and v its displacements in the mode of modal amplitude 1.
"""

from dataclasses import dataclass

import numpy as np

from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Structure
from vanelock.nonlinear.balance.held_vibration import Array, Floats
from vanelock.nonlinear.balance.limit_modes import limit_modes
from vanelock.nonlinear.newton.newton import Solution

HELD = 1e-10
"""Share of stiffness in (stiffness + σ² mass), σ about the lowest frequency, of what is held."""


@dataclass(frozen=True)
class LinearMode:
    """A linear mode about the state at rest.

    Attributes
    ----------
    shape : (n,) complex
        VᴴMφ in the fundamental's modes V, φᴴMφ = 1.
    omega : float
        rad/s, without damping.
    xi : float
        ξ of its own damping, 1/s.
    onset : float
        Modal amplitude at which the first contact slips, opens or closes, kg^½ m, by estimate; inf
        where none does.
    """

    shape: Array
    omega: float
    xi: float
    onset: float


def linear_mode(structure: Structure, mode: int, rest: Solution) -> LinearMode:
    """A mode of the first harmonic's nodal diameter about the state at rest."""
    contacts, modes = structure.system.contacts, structure.at(1)
    gap = rest.u[:, 0, 0]
    closed = np.repeat((gap > 0)[:, None], 3, axis=1)
    closed[:, 1:] &= (contacts.mu > 0)[:, None]
    limit = limit_modes(modes, structure.stiffness, closed.reshape(-1))
    with np.errstate(divide="ignore"):
        square = np.where(limit.compliance > 0, limit.static / limit.compliance, np.inf)
    vibrates = np.flatnonzero((limit.static > HELD) & np.isfinite(square))
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
    return LinearMode(
        shape=np.asarray(modes.compliance * shape, complex),
        omega=float(np.sqrt(square[chosen])),
        xi=float(damping.real / mass),
        onset=onset(structure, gap, moved),
    )


def onset(structure: Structure, gap: Floats, moved: Floats) -> float:
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
