"""The contact element marched through its three states, sample by sample.

It shares nothing with the law that the solver uses, neither the picture of a slider nor located
events, and serves to check what the solver found. From one sample to the next

    n = max(kn v, 0),      t ← clip(t + kt Δu, -μn, μn),

where Δu counts from the instant of touching down, v being linear in between; an open contact has
n = 0 and thus t = 0. The error falls with the square of the number of samples.

One step is a map clip(t + m, a, b), and so is any chain of steps. Hence a period is cut into blocks
that are marched side by side, first for their maps, then for the forces.

Isotropic friction returns what exceeds μn to the circle along the mean of the old and the new force
(the generalised midpoint rule, Simo & Taylor 1986): with p = t + kt Δu, the new force lies where
the ray from -t through p meets it. These steps go one after the other.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.rom.system.system import Contacts

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]
Bools = NDArray[np.bool_]

TOGETHER = 8  # contacts marched at once, to bound the memory
ROUNDS, REPEATS = 200, 1e-13
"""Of isotropic friction: most rounds, and of the largest force how closely one repeats the last."""


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
    """Forces and friction work of contacts under periodic relative displacements.

    Parameters
    ----------
    contacts : Contacts
    displacement : (H + 1, c, 3) complex
        One-sided coefficients of (v, u1, u2), m.
    samples : int
        Steps of a period, a power of two.
    friction : {"orthogonal", "isotropic"}
        As of `Options`.
    begin : (c, 2) float, optional
        Friction at the first sample, N, cut to its bound. It matters where a contact sticks for
        good, anywhere within the bound; by default that of sliders at zero.
    """
    parts, way = [], _friction if friction == "orthogonal" else _friction_in_plane
    at_zero = contacts.kt * displacement[:, :, 1:].sum(axis=0).real
    start = at_zero if begin is None else begin
    for first in range(0, max(contacts.count, 1), TOGETHER):
        part = slice(first, first + TOGETHER)
        kn, kt, mu = contacts.kn[part], contacts.kt[part], contacts.mu[part]
        parts.append(_march(kn, kt, mu, displacement[:, part], samples, start[part], way))
    force = np.concatenate([part.force for part in parts], axis=1)
    return Marched(force, np.concatenate([part.work for part in parts]))


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


Friction: TypeAlias = Callable[[Floats, Floats, Floats], tuple[Floats, Bools]]


def _march(
    kn: Floats,
    kt: Floats,
    mu: Floats,
    q: Array,
    samples: int,
    start: Floats,
    friction: Friction,
) -> Marched:
    """Some contacts, all at once."""
    u = histories(q, samples)
    v = u[:, :, 0]
    n = kn * np.maximum(v, 0.0)
    bound = np.repeat((mu * n)[:, :, None], 2, axis=2)
    before = np.roll(v, 1, axis=0)
    touching = (before < 0) & (v > 0)
    share = np.where(touching, v / np.where(touching, v - before, 1.0), 1.0)
    moved = kt * np.diff(u[:, :, 1:], axis=0, prepend=u[-1:, :, 1:]) * share[:, :, None]
    t, slipped = friction(start, moved, bound)
    held = np.roll(t, 1, axis=0)
    slid = (moved - (t - held)) / kt
    rounding = 16 * np.finfo(float).eps * np.abs(u[:, :, 1:]).max(axis=0)
    slid = np.where(slipped & (np.abs(slid) > rounding), slid, 0.0)
    work = (0.5 * (t + held) * slid).sum(axis=(0, 2))
    force = np.concatenate([n[:, :, None], t], axis=2)
    return Marched(coefficients(force, len(q) - 1), work)


@kernel
def _round(t: Floats, moved: Floats, bound: Floats, out: Floats, slipped: Bools) -> None:
    """One round of isotropic friction from a force t (2,) at sample 0, replaced by the last."""
    count = bound.size
    for j in range(1, count + 1):
        i = j if j < count else 0
        b, px, py = bound[i], t[0] + moved[i, 0], t[1] + moved[i, 1]
        slips = math.hypot(px, py) > b
        if slips:
            # |s (p + t) - t| = b: the larger root is where the ray leaves the circle.
            x, y = px + t[0], py + t[1]
            square = max(x * x + y * y, 1e-300)
            half = (x * t[0] + y * t[1]) / square
            inside = half * half - (t[0] * t[0] + t[1] * t[1] - b * b) / square
            s = half + math.sqrt(max(inside, 0.0))
            px, py = s * x - t[0], s * y - t[1]
            size = math.hypot(px, py)
            shrink = b / size if size > 0.0 else 0.0
            px, py = shrink * px, shrink * py
        t[0], t[1] = px, py
        out[i, 0], out[i, 1] = px, py
        slipped[i] = slips


def _friction_in_plane(start: Floats, moved: Floats, bound: Floats) -> tuple[Floats, Bools]:
    """Periodic friction forces (s, c, 2), and which steps slip: rounds until they repeat."""
    out, slipped = np.empty_like(moved), np.empty(moved.shape, bool)
    for c in range(moved.shape[1]):
        m, b = np.ascontiguousarray(moved[:, c]), np.ascontiguousarray(bound[:, c, 0])
        path, slips, t = np.empty_like(m), np.empty(len(m), bool), start[c].copy()
        t *= min(1.0, b[0] / max(float(np.hypot(*t)), np.finfo(float).tiny))
        for _ in range(ROUNDS):
            begun = t.copy()
            _round(t, m, b, path, slips)
            if np.abs(t - begun).max() <= REPEATS * np.abs(path).max():
                break
        out[:, c], slipped[:, c] = path, slips[:, None]
    return out, slipped


def _friction(start: Floats, moved: Floats, bound: Floats) -> tuple[Floats, Bools]:
    """Periodic friction forces (s, c, 2), and which steps slip: the second round from sample 0 on.

    Those slip, too, that let go in the last step before lift-off.
    """
    start = np.clip(start, -bound[0], bound[0])
    samples, shape = len(moved), start.shape
    length = 1 << (samples.bit_length() // 2)

    def in_blocks(history: Floats) -> Floats:  # (steps of a block, blocks, ...), from sample 1 on
        ahead = np.roll(history, -1, axis=0).reshape(samples // length, length, *shape)
        return np.ascontiguousarray(ahead.swapaxes(0, 1))

    m, b = in_blocks(moved), in_blocks(bound)
    total, low, high = m[0].copy(), -b[0], b[0].copy()
    for i in range(1, length):
        total += m[i]
        low = np.minimum(np.maximum(low + m[i], -b[i]), b[i])
        high = np.minimum(np.maximum(high + m[i], -b[i]), b[i])
    begin, t = np.empty_like(total), start
    for _ in range(2):
        for j in range(len(begin)):
            begin[j] = t
            t = np.clip(t + total[j], low[j], high[j])
    t, out = begin, np.empty_like(m)
    for i in range(length):
        t = out[i] = np.minimum(np.maximum(t + m[i], -b[i]), b[i])
    t = np.roll(out.swapaxes(0, 1).reshape(samples, *shape), 1, axis=0)
    return t, np.abs(t) >= bound
