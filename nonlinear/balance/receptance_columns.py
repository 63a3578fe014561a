"""Columns of receptances: computed when a contact first deviates, and kept."""

from collections.abc import Callable, Sequence

import numpy as np

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.nonlinear.fourier import kernel


class HeldColumns:
    """Which of a number of columns are held, and where.

    `size`: number of columns; `components` (k,): those held, in the order in which they came;
    `place` (size,): of each among these; -1: not held.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.components: Integers = np.empty(0, np.int64)
        self.place: Integers = np.full(size, -1)

    def _admitted(self, components: Integers) -> Integers:
        """Those wanted that were not held, as if they were now."""
        missing = components[self.place[components] < 0]
        self.place[missing] = len(self.components) + np.arange(len(missing))
        self.components = np.concatenate([self.components, missing])
        return missing


class Columns(HeldColumns):
    """The columns of R̂_h, h = 0 ... H, that have been asked for so far.

    A contact that sticks where it was assembled never needs its own.
    """

    def __init__(self, size: int, compute: tuple[Callable[[Integers], Array], ...]) -> None:
        super().__init__(size)
        self.compute = compute
        self.held: list[Array] = [np.empty((0, size), complex) for _ in compute]
        self._chosen: tuple[Integers, Integers, list[Array]] | None = None

    def hold(self, components: Integers) -> None:
        """Make sure that the columns of these components are held."""
        if not len(missing := self._admitted(components)):
            return
        for h, compute in enumerate(self.compute):
            fresh = compute(missing)
            old = self.held[h]
            self.held[h] = np.concatenate([old, fresh]) if len(old) else np.ascontiguousarray(fresh)

    def part(self, components: Integers, rows: Integers) -> list[Array]:
        """Some rows of some columns, (k, r) for each harmonic; the last choice is kept."""
        last = self._chosen
        if last is None or not (
            np.array_equal(last[0], components) and np.array_equal(last[1], rows)
        ):
            self.hold(components)
            places = self.place[components][:, None]
            held = [each[places, rows] for each in self.held]
            held[0] = np.ascontiguousarray(held[0].real)
            last = self._chosen = (components, rows, held)
        return last[2]

    def all(self, harmonic: int) -> Array:
        """R̂_h itself, (3c, 3c)."""
        every = np.arange(self.size)
        self.hold(every)
        return self.held[harmonic][self.place].T


def passed(w: Floats, columns: Sequence[Array]) -> Floats:
    """R̂ w, (r, m), of deviations (k, m) of the components of columns (k, r) by harmonic."""
    out = np.empty((columns[0].shape[1], w.shape[1]))
    out[:, 0] = w[:, 0].copy() @ columns[0].real
    for h, R in enumerate(columns[1:], 1):
        moved = (w[:, 2 * h - 1] + 1j * w[:, 2 * h]) @ R
        out[:, 2 * h - 1], out[:, 2 * h] = moved.real, moved.imag
    return out


@kernel
def combine(table: Array, shares: Floats, places: Integers, out: Array) -> None:
    """out[j] += Σ_k shares[k] · table[places[j], k], of the columns (3c,) held at some nodes k."""
    for j in range(places.size):
        column = table[places[j]]
        row = out[j]
        for k in range(shares.size):
            share = shares[k]
            node = column[k]
            for i in range(row.size):
                row[i] += share * node[i]
