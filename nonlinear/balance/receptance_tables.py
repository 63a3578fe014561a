"""Receptances over a range of frequencies, from tables.

Where the modes are those of the structure with joints open (`stuck_modes`), the springs k of these
act on the far modes alone first, whose receptance F stays smooth. With n the near modes, o the
contacts that open and A = (k⁻¹ + F_oo)⁻¹,

    R̂ K_c⁻¹ = F̃ + B S⁻¹ L,     F̃ = F - F_:o A F_o:,     B = b_n - F_:o A b_no,
    S = p_n + b_noᴴ A b_no,    L = b_nᴴ - b_noᴴ A F_o: = b_nᴴ - b_noᴴ k F̃_o:,

of which F̃, B and S - p_n are tabulated.
"""

from dataclasses import dataclass
from functools import partial
from math import ceil, log, sqrt
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.balance.receptance_columns import HeldColumns, combine
from vanelock.nonlinear.balance.stuck_modes import StuckModes

_COLUMNS = 128  # of receptances that are worked out at a time
_MARGIN = 0.02  # how far, relatively, an arc may leave the range of frequencies


class _FarColumns(HeldColumns):
    """Columns of what the far modes add to R̂ at the nodes of the range; computed when asked for.

    `rows` (3c, n): of the far modes; `pull` (n, 3c): modal forces of unit displacements of the
    springs; `dynamic` (k, n): modal dynamic stiffnesses at the nodes; `opened`, `through` (m,), (k,
    m, 3c): components on which springs act, and what columns are moved by where they move there.
    """

    opened: Integers | None = None
    through: Array

    def __init__(self, rows: Array, pull: Array, dynamic: Array) -> None:
        self._rows, self._pull, self._dynamic = rows, pull, dynamic
        super().__init__(len(rows))
        self._held = np.empty((0, len(dynamic), self.size), complex)

    def at(self, components: Integers) -> tuple[Array, Integers]:
        """Columns held so far, (m, k, 3c), and where among them the wanted ones are."""
        begin, missing = len(self.components), self._admitted(components)
        count = len(self.components)
        if count > len(self._held):
            room = np.empty((min(2 * count, self.size), *self._held.shape[1:]), complex)
            room[:begin] = self._held[:begin]
            self._held = room
        for start in range(0, len(missing), _COLUMNS):
            some = missing[start : start + _COLUMNS]
            fresh = _product(self._pull.T[some, None] / self._dynamic, self._rows.T)
            first = begin + start
            self._held[first : first + len(some)] = self.sprung(fresh)
        return self._held, self.place[components]

    def sprung(self, columns: Array) -> Array:
        """Columns (j, k, 3c) once the springs act."""
        if self.opened is None:
            return columns
        seen = columns[:, :, None, self.opened]  # each by itself: its bits are its own
        return np.asarray(columns - (seen @ self.through)[:, :, 0])

    def spring(self, opened: Integers, stiffness: Floats, near: Array) -> Array:
        """Let springs act from now on at (m,) components; bᴴAb of near modes, (k, low, low)."""
        held, places = self.at(opened)
        count, own = len(self.components), near[opened]
        nodes, low = held.shape[1], near.shape[1]
        self.through = np.empty((nodes, len(opened), held.shape[2]), complex)
        coupled = np.empty((nodes, low, low), complex)
        for i, through in enumerate(self.through):
            flexible = held[places, i] / stiffness[:, None]  # F_:o, by rows
            factors = la.lu_factor(flexible[:, opened].T + np.diag(1 / stiffness))
            through[:] = la.lu_solve(factors, flexible, trans=1)
            coupled[i] = own.conj().T @ la.lu_solve(factors, own.astype(complex))
            held[:count, i] -= held[:count, i][:, opened] @ through
        self.opened = opened
        return coupled


class _FarModes(NamedTuple):
    """What far modes contribute, whatever the excitation.

    `low`: number of modes that are summed at every frequency instead; `dynamic` (k, n): modal
    dynamic stiffnesses of the others at the nodes; `columns`: their R̂; `near` (low, k, 3c), (k,
    low, low): B and S - p_n, where springs act.
    """

    low: int
    dynamic: Array
    columns: _FarColumns
    near: tuple[Array, Array] | None


@dataclass(frozen=True)
class _ReceptanceTable:
    """What one harmonic's far modes contribute, at the nodes of the range.

    `linear` (3c, k): their ũ under the excitation at 1 rad/s; None where it is not excited.
    """

    far: _FarModes
    linear: Array | None


@dataclass(frozen=True)
class Tabulated:
    """Balances by circular frequency, rad/s, in a range: a few modes summed, the others tabulated.

    Those whose poles are further than three times hω from zero, natural frequencies or decays of
    overdamped modes, vary smoothly in the range, and Chebyshev interpolation of their sum is exact
    to rounding; the summation over hundreds of modes is paid at the nodes only.

    `limits`: the range, rad/s; outside it all modes are summed; `nodes` (k,): Chebyshev nodes,
    rad/s; `weights` (k,): barycentric weights; `tables`: for h = 1 ... H.
    """

    structure: Structure
    limits: tuple[float, float]
    nodes: Floats
    weights: Floats
    tables: tuple[_ReceptanceTable, ...]

    def balance(self, omega: float) -> Balance:
        """The balance at a circular frequency."""
        if not self.limits[0] <= omega <= self.limits[1]:
            return self.structure.balance(omega)
        distance = omega - self.nodes
        if np.any(distance == 0):
            shares = (distance == 0).astype(float)
        else:
            shares = self.weights / distance
            shares /= shares.sum()
        vibrating = range(1, self.structure.harmonics + 1)
        return self.structure.assembled(
            omega,
            (self._vibration(h, omega, shares) for h in vibrating),
            tuple(partial(self._columns, h, omega, shares) for h in vibrating),
        )

    def _vibration(self, harmonic: int, omega: float, shares: Floats) -> Array:
        """ũ_h."""
        table, structure = self.tables[harmonic - 1], self.structure
        if table.linear is None:
            return np.zeros(len(structure.stiffness))
        modes = structure.at(harmonic)
        push = structure.modal_force(harmonic, omega)[: table.far.low]
        growth = structure.growth(harmonic, omega)
        if table.far.near is not None:
            far = (table.linear @ shares) * growth
            near = self._near(harmonic, omega, shares, push[None], far[None])[0]
            return np.asarray(far + near)
        near = modes.rows[:, : table.far.low] @ (
            push / modes.dynamic(harmonic * omega)[: table.far.low]
        )
        return np.asarray((table.linear @ shares) * growth + near)

    def _columns(self, harmonic: int, omega: float, shares: Floats, components: Integers) -> Array:
        """Columns of R̂_h."""
        table, modes = self.tables[harmonic - 1], self.structure.at(harmonic)
        near = modes.rows[:, : table.far.low]
        held, places = table.far.columns.at(components)
        if table.far.near is not None:
            out = np.zeros((len(components), len(near)), complex)
            combine(held, shares, places, out)
            push = near[components].conj() * self.structure.stiffness[components, None]
            return out + self._near(harmonic, omega, shares, push, out)
        dynamic = modes.dynamic(harmonic * omega)[: table.far.low]
        out = (near[components].conj() / dynamic) @ near.T
        out *= self.structure.stiffness[components, None]
        combine(held, shares, places, out)
        return out

    def _near(self, harmonic: int, omega: float, shares: Floats, push: Array, far: Array) -> Array:
        """What the near modes (low,) add to far motions (j, 3c) under modal forces (j, low)."""
        table, modes = self.tables[harmonic - 1], self.structure.at(harmonic)
        assert table.far.near is not None
        assert modes.springs is not None
        own = modes.opened
        rows = np.zeros((table.far.low, far.shape[1]), complex)
        combine(table.far.near[0], shares, np.arange(table.far.low), rows)
        S = np.tensordot(shares, table.far.near[1], 1)
        S[np.diag_indices(table.far.low)] += modes.dynamic(harmonic * omega)[: table.far.low]
        seen = (far[:, own] * modes.springs[own]) @ modes.rows[own, : table.far.low].conj()
        return np.asarray(np.linalg.solve(S, (push - seen).T).T @ rows)


def balances(
    structure: Structure, lowest: float, highest: float, points: int
) -> Structure | Tabulated:
    """What gives the balances of some points in a range of ω, rad/s: tables where cheaper."""
    low, high = (1 - _MARGIN) * lowest, (1 + _MARGIN) * highest
    coupled = any(modes.coupled_damping is not None for modes in structure.modes.values())
    # A pole is at least three times the highest frequency from zero, worst on the real axis;
    # Bernstein's ellipse through it.
    x = (3 * high - 0.5 * (high + low)) / (0.5 * (high - low))
    count = ceil(log(1e16) / log(x + sqrt(x * x - 1))) + 1
    if coupled or structure.harmonics == 0 or points <= count:
        return structure
    limit = np.full(structure.harmonics + 1, 3.0 * high) * np.arange(structure.harmonics + 1)
    if np.isfinite(structure.cutoff):  # what is not summed does not vary at all
        limit, count = np.full(len(limit), np.inf), 1
    summed = []
    for h in range(1, structure.harmonics + 1):
        near = np.flatnonzero(structure.at(h).poles() < limit[h])
        summed.append(int(near.max(initial=-1)) + 1)
    if all(n == len(structure.at(h).compliance) for h, n in enumerate(summed, 1)):
        return structure  # nothing left to tabulate
    k = np.arange(count)
    cosine = np.cos(np.pi * (2 * k + 1) / (2 * count))
    nodes = 0.5 * (low + high) + 0.5 * (high - low) * cosine
    weights = np.asarray((-1.0) ** k * np.sin(np.pi * (2 * k + 1) / (2 * count)), float)
    tables = tuple(_table(structure, h, n, nodes) for h, n in enumerate(summed, 1))
    return Tabulated(structure, (low, high), nodes, weights, tables)


def _table(structure: Structure, harmonic: int, low: int, nodes: Floats) -> _ReceptanceTable:
    """The far modes of a harmonic at the nodes.

    Modes that several systems share keep them: sweeps change the excitation and friction.
    """
    modes, force = structure.at(harmonic), structure.system.force.get(harmonic)
    key, known = (low, (harmonic * nodes).tobytes()), modes.tables.get(harmonic)
    if known is None or known[0] != key:
        known = key, _far_modes(modes, structure.stiffness, low, harmonic * nodes)
        modes.tables[harmonic] = known
    far: _FarModes = known[1]
    linear = None
    if force is not None:
        linear = modes.rows[:, low:] @ (structure.unit_forces[harmonic][low:] / far.dynamic).T
        linear = far.columns.sprung(linear.T[None])[0].T
    return _ReceptanceTable(far, linear)


def _far_modes(modes: StuckModes, stiffness: Floats, low: int, nodes: Floats) -> _FarModes:
    """The modes from `low` on at the nodes, rad/s."""
    dynamic = np.stack([modes.dynamic(s)[low:] for s in nodes])
    columns = _FarColumns(modes.rows[:, low:], modes.pull[low:] * stiffness, dynamic)
    if modes.springs is None:
        return _FarModes(low, dynamic, columns, None)
    own = modes.opened
    near = modes.rows[:, :low]
    coupled = columns.spring(own, modes.springs[own], near)
    rows = columns.sprung(np.broadcast_to(near.T[:, None], (low, len(nodes), len(near))))
    return _FarModes(low, dynamic, columns, (rows, coupled))


def _product(shares: Array, rows: Array) -> Array:
    """(j, k, n) complex times (n, 3c), each of the j by itself; real rows at half the cost."""
    if np.iscomplexobj(rows):
        return np.asarray(shares @ rows)
    k = shares.shape[1]
    both = np.concatenate([shares.real, shares.imag], axis=1) @ rows
    found = np.empty((len(shares), k, rows.shape[1]), complex)
    found.real, found.imag = both[:, :k], both[:, k:]
    return found
