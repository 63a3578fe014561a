"""The balance of a ring whose sectors need not be alike, condensed to all their contacts.

Sector j of a travelling wave does what the first one does, later by jφ, φ = 2π EO/N. Seen from
there, q_j^(h) = q̂_j^(h) e^{-ihjφ}, the law of contact is the same in every sector, as it does not
know the time; and where all are alike, so are all q̂_j. What differs is a sum of waves n,

    q̂_j = Σ_n Q_n e^{-2πijn/N},      n = 0 ... N - 1,

of which harmonic h has the nodal diameter (n + h EO) mod N, so that the structure, which is alike,

    U_n^(h) = R̂_{h,n} W_n^(h),

takes N small receptances and two discrete Fourier transforms.
"""

from dataclasses import dataclass, replace

import numpy as np

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.balance.receptance_columns import Columns, HeldColumns
from vanelock.nonlinear.fourier.trigonometric import to_complex, to_real


class RingColumns(HeldColumns):
    """Columns of the receptances of all waves of a ring that have been asked for so far."""

    def __init__(self, waves: tuple[Columns, ...]) -> None:
        super().__init__(waves[0].size)
        self.waves = waves
        self.held: Array = np.empty((len(waves[0].compute), len(waves), 0, self.size), complex)
        self._chosen: tuple[Integers, Array] | None = None

    def with_harmonics(self, harmonics: int) -> "RingColumns":
        """Those of the first harmonics alone."""
        return RingColumns(
            tuple(Columns(each.size, each.compute[: harmonics + 1]) for each in self.waves)
        )

    def hold(self, wanted: Integers) -> None:
        """Make sure that the columns of these components are held, (H + 1, N, k, 3c)."""
        if not len(missing := self._admitted(wanted)):
            return
        fresh = np.empty((*self.held.shape[:2], len(missing), self.size), complex)
        for n, columns in enumerate(self.waves):
            for h, compute in enumerate(columns.compute):
                fresh[h, n] = compute(missing)
        self.held = np.concatenate([self.held, fresh], axis=2)

    def among(self, chosen: Integers) -> Array:
        """(H + 1, N, k, k) of some components on themselves; the last choice is kept."""
        if self._chosen is None or not np.array_equal(self._chosen[0], chosen):
            self.hold(chosen)
            square = self.held[:, :, self.place[chosen][:, None], chosen]
            self._chosen = chosen, np.ascontiguousarray(square)
        return self._chosen[1]


def passed(receptances: Array, w: Floats) -> Floats:
    """R̂ w, (N, r, m), of deviations (N, k, m) of the columns that (H + 1, N, k, r) are of."""
    waves = np.fft.ifft(to_complex(w), axis=1)
    moved = (waves[:, :, None] @ receptances)[:, :, 0]
    return to_real(np.fft.fft(moved, axis=1))


@dataclass(frozen=True)
class RingBalance(Balance):
    """The balance at one frequency of all N sectors, one behind the other.

    `linear` is (N c, 3, 2H + 1); `columns` are those of the wave n = 0.
    """

    ring: RingColumns

    @property
    def sectors(self) -> int:
        """N."""
        return len(self.ring.waves)

    def with_harmonics(self, harmonics: int) -> "RingBalance":
        """The balance of the first harmonics alone."""
        linear = self.linear[:, :, : 2 * harmonics + 1].copy()
        ring = self.ring.with_harmonics(harmonics)
        return replace(self, linear=linear, columns=ring.waves[0], ring=ring)

    def moved(self, w: Floats) -> Floats:
        """R̂ w, (N c, 3, 2H + 1)."""
        flat = w.reshape(self.sectors, -1, w.shape[2])
        components, ring = np.flatnonzero(flat.any(axis=(0, 2))), self.ring
        if not len(components):
            return np.zeros_like(w)
        ring.hold(components)
        if 2 * len(components) > len(ring.components):
            components, held = ring.components, ring.held
        else:
            held = ring.held[:, :, ring.place[components]]
        return passed(held, flat[:, components]).reshape(w.shape)
