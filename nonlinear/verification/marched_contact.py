"""The contact element marched through its three states, sample by sample.

It shares nothing with the law that the solver uses, neither the picture of a slider nor located
events, and serves to check what the solver found. From one sample to the next

    n = max(kn v, 0),      t ← clip(t + kt Δu, -μn, μn),

where Δu counts from the instant of touching down, v being linear in between; an open contact has
n = 0 and thus t = 0. The error falls with the square of the number of samples.

Isotropic friction returns what exceeds μn to the circle along the mean of the old and the new force
(the generalised midpoint rule, Simo & Taylor 1986): with p = t + kt Δu, the new force lies where
the ray from -t through p meets it. A round goes through all samples, and rounds follow until one
begins where it ends.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.rom.system.system import Contacts

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]

ROUNDS, REPEATS = 200, 1e-13
"""Most rounds, and of the largest force how closely one repeats the last."""


@dataclass(frozen=True)
class Marched:
    """What contacts do under given displacements.

    Attributes
    ----------
    force : (H + 1, c, 3) complex
        One-sided coefficients of (n, t1, t2), N; real for h = 0.
    work : (c,) float
        Friction work of a period, ∮ t dw over the steps that slip, J.
    """

    force: Array
    work: Floats


def march_contacts(
    contacts: Contacts,
    displacement: Array,
    samples: int,
    friction: str = "orthogonal",
    begin: Floats | None = None,
) -> Marched:
    """Forces and friction work of contacts under periodic relative displacements."""
    at_zero = contacts.kt * displacement[:, :, 1:].sum(axis=0).real
    start = at_zero if begin is None else begin
    force = np.zeros((len(displacement), contacts.count, 3), complex)
    work = np.zeros(contacts.count)
    isotropic, path = friction == "isotropic", np.empty((samples, 3))
    for c in range(contacts.count):
        u, t = np.ascontiguousarray(histories(displacement[:, c], samples)), start[c].astype(float)
        bound = contacts.mu[c] * contacts.kn[c] * max(u[0, 0], 0.0)
        if isotropic:
            t *= min(1.0, bound / max(math.hypot(*t), np.finfo(float).tiny))
        else:
            t = t.clip(-bound, bound)
        for _ in range(ROUNDS):
            begun = t.copy()
            work[c] = _round(u, contacts.kn[c], contacts.kt[c], contacts.mu[c], isotropic, t, path)
            if np.abs(t - begun).max() <= REPEATS * np.abs(path[:, 1:]).max():
                break
        force[:, c] = coefficients(path, len(displacement) - 1)
    return Marched(force, work)


def histories(q: Array, samples: int) -> Floats:
    """(samples, ...) values over a period of one-sided coefficients (H + 1, ...)."""
    spectrum = q * (samples / 2)
    spectrum[0] = q[0].real * samples
    return np.asarray(np.fft.irfft(spectrum, n=samples, axis=0))


def coefficients(history: Floats, harmonics: int) -> Array:
    """One-sided coefficients (H + 1, ...) of values over a period (samples, ...)."""
    q: Array = np.fft.rfft(history, axis=0)[: harmonics + 1] * (2 / len(history))
    q[0] /= 2
    return q


@kernel
def _round(
    u: Floats, kn: float, kt: Floats, mu: float, isotropic: bool, t: Floats, path: Floats
) -> float:
    """Friction work of one round from a force t (2,) at sample 0, which the last one replaces.

    Displacements and forces are (s, 3). A step slips where it ends at the bound, that of lift-off
    too; slips within rounding of the displacement are none.
    """
    work, count = 0.0, len(u)
    rounding = 16 * 2.3e-16 * max(np.abs(u[:, 1]).max(), np.abs(u[:, 2]).max())
    for j in range(1, count + 1):
        i = j if j < count else 0
        v, before = u[i, 0], u[i - 1, 0]
        n = kn * max(v, 0.0)
        bound = mu * n
        share = v / (v - before) if before < 0.0 < v else 1.0
        x = kt[0] * share * (u[i, 1] - u[i - 1, 1])
        y = kt[1] * share * (u[i, 2] - u[i - 1, 2])
        px, py = t[0] + x, t[1] + y
        if not isotropic:
            px, py = min(max(px, -bound), bound), min(max(py, -bound), bound)
            slips_x, slips_y = abs(px) >= bound, abs(py) >= bound
        else:
            slips_x = slips_y = math.hypot(px, py) > bound
            if slips_x:
                # |s (p + t) - t| = bound: the larger root is where the ray leaves the circle.
                ax, ay = px + t[0], py + t[1]
                square = max(ax * ax + ay * ay, 1e-300)
                half = (ax * t[0] + ay * t[1]) / square
                inside = half * half - (t[0] * t[0] + t[1] * t[1] - bound * bound) / square
                s = half + math.sqrt(max(inside, 0.0))
                px, py = s * ax - t[0], s * ay - t[1]
                size = math.hypot(px, py)
                shrink = bound / size if size > 0.0 else 0.0
                px, py = shrink * px, shrink * py
        slid = (x - (px - t[0])) / kt[0]
        if slips_x and abs(slid) > rounding:
            work += 0.5 * (px + t[0]) * slid
        slid = (y - (py - t[1])) / kt[1]
        if slips_y and abs(slid) > rounding:
            work += 0.5 * (py + t[1]) * slid
        t[0], t[1] = px, py
        path[i, 0], path[i, 1], path[i, 2] = n, px, py
    return work
