"""The contact element marched through its three states, sample by sample, in plain NumPy.

It shares nothing with the law that the solver uses, neither the picture of a slider nor located
events, and serves to check what the solver found. From one sample to the next

    n = max(kn v, 0),      t ← clip(t + kt Δu, -μn, μn),

where Δu counts from the instant of touching down, v being linear in between; an open contact has
n = 0 and thus t = 0. The error falls with the square of the number of samples.

One step is a map clip(t + m, a, b), and so is any chain of steps. Hence a period is cut into blocks
that are marched side by side, first for their maps, then for the forces.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.rom.system.system import Contacts

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]

TOGETHER = 8  # contacts marched at once, to bound the memory


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


def march_contacts(contacts: Contacts, displacement: Array, samples: int) -> Marched:
    """Forces and friction work of contacts under periodic relative displacements.

    Parameters
    ----------
    contacts : Contacts
    displacement : (H + 1, c, 3) complex
        One-sided coefficients of (v, u1, u2), m.
    samples : int
        Steps of a period, a power of two.
    """
    parts = []
    for first in range(0, max(contacts.count, 1), TOGETHER):
        part = slice(first, first + TOGETHER)
        kn, kt, mu = contacts.kn[part], contacts.kt[part], contacts.mu[part]
        parts.append(_march(kn, kt, mu, displacement[:, part], samples))
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


def _march(kn: Floats, kt: Floats, mu: Floats, q: Array, samples: int) -> Marched:
    """Some contacts, all at once."""
    u = histories(q, samples)
    v = u[:, :, 0]
    n = kn * np.maximum(v, 0.0)
    bound = np.repeat((mu * n)[:, :, None], 2, axis=2)
    before = np.roll(v, 1, axis=0)
    touching = (before < 0) & (v > 0)
    share = np.where(touching, v / np.where(touching, v - before, 1.0), 1.0)
    moved = kt * np.diff(u[:, :, 1:], axis=0, prepend=u[-1:, :, 1:]) * share[:, :, None]
    start = np.clip(kt * u[0, :, 1:], -bound[0], bound[0])
    t = _friction(start, moved, bound)
    slipped = np.abs(t) >= bound  # also where the last step before lift-off lets go
    held = np.roll(t, 1, axis=0)
    slid = (moved - (t - held)) / kt
    rounding = 16 * np.finfo(float).eps * np.abs(u[:, :, 1:]).max(axis=0)
    slid = np.where(slipped & (np.abs(slid) > rounding), slid, 0.0)
    work = (0.5 * (t + held) * slid).sum(axis=(0, 2))
    force = np.concatenate([n[:, :, None], t], axis=2)
    return Marched(coefficients(force, len(q) - 1), work)


def _friction(start: Floats, moved: Floats, bound: Floats) -> Floats:
    """Periodic friction forces (s, c, 2): the second round from `start` at sample 0 on."""
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
    return np.roll(out.swapaxes(0, 1).reshape(samples, *shape), 1, axis=0)
