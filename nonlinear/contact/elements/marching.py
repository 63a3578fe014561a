"""An element's force at given instants of a period, round after round until its state repeats."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numba
import numpy as np
from numba import float64, types

from vanelock.common.errors import InputError
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import TURN, Floats, basis
from vanelock.rom.system.element import Element, Force

LAPS = 64
REPEATS = 1e-13
"""Of the largest state: how closely it must return."""
SIGNATURE = types.void(float64[::1], float64[::1], float64[::1], float64[::1], float64[::1])


@lru_cache(maxsize=256)
def compiled(function: Force, name: str) -> Any:
    """The law, compiled."""
    try:
        return numba.cfunc(SIGNATURE)(function)
    except (numba.core.errors.NumbaError, TypeError) as error:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        why = next((line for line in lines if "Error" in line), lines[0])
        raise InputError(f"Element {name!r}: force cannot be compiled: {why}") from None


@dataclass(frozen=True)
class Samples:
    """φ and its derivative at instants of the period, and what projects on the harmonics.

    Attributes
    ----------
    table, slope : (s, m) float
        φ and dφ/dθ.
    project : (m, s) float
        From values at the instants to coefficients.
    """

    table: Floats
    slope: Floats
    project: Floats


def samples_at(harmonics: int, angles: Floats, weights: Floats) -> Samples:
    """Instants by their angles (s,), and what each counts in an integral over θ."""
    table = basis(harmonics, angles)
    slope = np.zeros_like(table)
    h = np.arange(1, harmonics + 1)
    slope[:, 1::2] = h * table[:, 2::2]
    slope[:, 2::2] = -h * table[:, 1::2]
    project = table.T * (weights / np.pi)
    project[0] *= 0.5
    return Samples(table, slope, project)


@lru_cache(maxsize=64)
def uniform(harmonics: int, count: int) -> Samples:
    """Uniform samples of a period."""
    return samples_at(harmonics, TURN * np.arange(count) / count, np.full(count, TURN / count))


@kernel
def _march(
    force: Any, u: Floats, rate: Floats, p: Floats, state: Floats, forces: Floats, before: Floats
) -> None:
    """Forces (s, d) once round the period, and the states (s, n) that each sample began with."""
    for i in range(len(u)):
        before[i] = state
        force(u[i], rate[i], state, p, forces[i])


def laps_of(
    law: Any, element: Element, u: Floats, omega: float, on: Samples
) -> tuple[Floats, Floats, Floats, list[Floats]]:
    """Displacements, velocities and the last lap's forces (s, d); states (s, n) of every lap."""
    moved = np.ascontiguousarray(on.table @ u.T)
    rate = np.ascontiguousarray(omega * (on.slope @ u.T))
    forces, state, laps = np.empty_like(moved), np.zeros(element.memory), []
    while True:
        before = np.empty((len(moved), element.memory))
        _march(law, moved, rate, np.asarray(element.parameters), state, forces, before)
        laps.append(before)
        least = REPEATS * np.abs(before).max(initial=0.0)
        if np.abs(state - before[0]).max(initial=0.0) <= least or len(laps) == LAPS:
            return moved, rate, forces, laps
