"""Friction under a constant normal load: one problem, its matrices, and an independent reference.

A structure of n real coordinates, the first 2c of which are the tangential displacements of c
contacts with the ground. A contact is a Jenkins element, a spring kt in series with a slider that
slips at μ n, n constant: one in each direction, or one in the plane of both.
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.nonlinear import Contacts, Diameter, Force, System
from vanelock.nonlinear.fourier import kernel

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]

RATIO = 0.003
"""Damping of every mode of the structure with all contacts sticking."""
APART = 1.01
"""The higher natural frequency of a pair over the lower one, without contacts."""
PERIODS = 40
"""Marched at most."""


@dataclass(frozen=True)
class Problem:
    """Matrices of the structure without its contacts, and the contacts.

    Attributes
    ----------
    K, M, C : (n, n) float
        N/m, kg, N s/m; C gives each stuck mode the ratio RATIO.
    force : (n,) complex
        Amplitude of the force that excites the structure, N: a cosine on the last coordinate, a
        sine on the one before.
    kt : (c,) float
        N/m, the same in both directions.
    limit : (c,) float
        μ n, N.
    """

    K: Floats
    M: Floats
    C: Floats
    force: Array
    kt: Floats
    limit: Floats

    @property
    def directions(self) -> int:
        """2c."""
        return 2 * len(self.kt)

    def stuck(self) -> Floats:
        """Stiffness with all contacts sticking."""
        K = self.K.copy()
        rows = np.arange(self.directions)
        K[rows, rows] += np.repeat(self.kt, 2)
        return K

    def dynamic(self, s: float, stuck: bool = False) -> Array:
        """Dynamic stiffness at the circular frequency s, rad/s."""
        K = self.stuck() if stuck else self.K
        return np.asarray(K - s**2 * self.M + 1j * s * self.C)

    def resonance(self) -> float:
        """First natural frequency with all contacts sticking, Hz."""
        values = la.eigh(self.stuck(), self.M, eigvals_only=True, subset_by_index=[0, 0])
        return float(np.sqrt(values[0])) / (2 * np.pi)

    def system(self) -> System:
        """The same for our solver: a normal row of zeros keeps v at v0, n at kn v0.

        C is given by its ratio, which is how a `System` has it without round-off.
        """
        n, c = len(self.K), len(self.kt)
        rows = np.zeros((c, 3, n))
        contact = np.arange(c)
        rows[contact, 1, 2 * contact] = 1.0
        rows[contact, 2, 2 * contact + 1] = 1.0
        mu = 0.3
        return System(
            sectors=1,
            engine_order=1,
            diameters={0: Diameter(K=self.K, M=self.M, own=rows)},
            contacts=Contacts(
                kn=self.kt,
                kt=np.column_stack([self.kt, self.kt]),
                mu=np.full(c, mu),
                v0=self.limit / (mu * self.kt),
            ),
            force={1: Force(self.force)},
            damping_ratio=RATIO,
        )


def problem(size: int, contacts: int, severity: float, seed: int = 0) -> Problem:
    """A structure whose natural frequencies spread like a reduced vane's, turned at random.

    Each shape occurs twice, in two directions at right angles and at frequencies close together,
    and the load goes round, a cosine on the last coordinate and a sine on the one before it: so
    contacts move on ellipses. Contacts raise the first frequency by about a third. `severity` is
    the amplitude of the stuck structure at resonance over the one at which contacts begin to slip,
    on the average. The size is even.
    """
    rng = np.random.default_rng(seed)
    pairs = size // 2
    frequencies = 200.0 * np.outer(np.arange(1, pairs + 1) ** 1.1, [1.0, APART]).reshape(-1)
    shapes, _ = la.qr(rng.normal(size=(pairs, pairs)))
    angle = rng.uniform(0, np.pi, pairs)
    across = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = np.einsum("ij,abj->iajb", shapes, across).reshape(size, size)
    K = (turned * (2 * np.pi * frequencies) ** 2) @ turned.T
    K, M = 0.5 * (K + K.T), np.eye(size)
    directions = 2 * contacts
    share = float((turned[:directions, 0] ** 2).sum())
    kt = 0.8 * (2 * np.pi * 200.0) ** 2 / share * rng.uniform(0.5, 1.5, contacts)
    force = np.zeros(size, complex)
    force[-1], force[-2] = 1.0, -1.0j
    bare = Problem(K, M, np.zeros_like(K), force, kt, np.ones(contacts))
    values, modes = la.eigh(bare.stuck(), M)
    C = (modes * (2 * RATIO * np.sqrt(values))) @ modes.T
    C = 0.5 * (C + C.T)
    damped = Problem(K, M, C, force, kt, np.ones(contacts))
    s = 2 * np.pi * damped.resonance()
    moved = np.abs(np.linalg.solve(damped.dynamic(s, stuck=True), force))[:directions]
    reached = np.sqrt((moved.reshape(contacts, 2) ** 2).mean(axis=1))
    limit = kt * reached / severity * rng.uniform(0.7, 1.3, contacts)
    return Problem(K, M, C, force, kt, limit)


@kernel
def _steps(
    u: Floats, table: Floats, kt: float, limit: float, plane: bool, force: Floats, rate: Floats
) -> None:
    """March one contact until a period repeats the last; fill (s, 2) and (s, 2, 2, 2H + 1)."""
    count, m = table.shape
    t, dt, dp = kt * u[0], np.zeros((2, 2, m)), np.zeros((2, 2, m))
    along, x, old, y = np.zeros((2, m)), np.zeros(2), np.zeros(2), np.zeros((2, m))
    for i in range(2):
        dt[i, i] = kt * table[0]
    for period in range(PERIODS):
        gap = 0.0
        for n in range(count):
            before = n - 1 if n > 0 else count - 1 if period > 0 else 0
            old[:], dp[:] = t, dt
            for i in range(2):
                t[i] += kt * (u[n, i] - u[before, i])
                dp[i, i] += kt * (table[n] - table[before])
            if not plane:
                for i in range(2):
                    if abs(t[i]) > limit:
                        t[i] = math.copysign(limit, t[i])
                        dp[i] = 0.0
                dt[:] = dp
            elif math.hypot(t[0], t[1]) <= limit:
                dt[:] = dp
            else:
                # The new force t' = s x - t, x the sum of t and the trial, has the size of the
                # bound; with it t'.dt' = 0.
                x[:] = t + old
                square = x[0] ** 2 + x[1] ** 2
                half = (x[0] * old[0] + x[1] * old[1]) / square
                inside = half**2 - (old[0] ** 2 + old[1] ** 2 - limit**2) / square
                s = half + math.sqrt(max(inside, 0.0))
                t[:] = s * x - old
                for i in range(2):
                    y = dp[i] + dt[i]
                    along += t[i] * (dt[i] - s * y)
                    dp[i] = s * y - dt[i]
                along /= t[0] * x[0] + t[1] * x[1]
                for i in range(2):
                    dt[i] = dp[i] + x[i] * along
                along[:] = 0.0
            gap = max(gap, abs(t[0] - force[n, 0]), abs(t[1] - force[n, 1]))
            force[n], rate[n] = t, dt
        if gap < 1e-14 * limit:
            break


def marched(
    problem: Problem, q: Array, samples: int, friction: str = "orthogonal"
) -> tuple[Array, Floats]:
    """Friction forces' coefficients and their derivatives, by plain marching.

    In the plane a step that slips is returned to the bound along the mean of the old and the new
    force (Simo & Taylor 1986); both laws are then off by the square of the step.

    Parameters
    ----------
    q : (H + 1, 2c) complex
        Coefficients of the displacements.
    friction : {"orthogonal", "isotropic"}
        As of `Options`.

    Returns
    -------
    (H + 1, 2c) complex
    (c, 2, 2H + 1, 2, 2H + 1) float
        d(force)/d(displacement) of each contact, both as (mean, re, im, ...).
    """
    H, m = len(q) - 1, 2 * len(q) - 1
    angle = 2 * np.pi * np.arange(samples) / samples
    table = np.ones((samples, m))
    for h in range(1, H + 1):
        table[:, 2 * h - 1], table[:, 2 * h] = np.cos(h * angle), -np.sin(h * angle)
    weight = np.full(m, 2.0 / samples)
    weight[0] = 1.0 / samples
    weighted = weight[:, None] * table.T
    contacts = len(problem.kt)
    forces, rates = np.empty((m, contacts, 2)), np.empty((contacts, 2, m, 2, m))
    u = (table @ real(q)).reshape(samples, contacts, 2)
    for c, (kt, limit) in enumerate(zip(problem.kt, problem.limit, strict=True)):
        force, rate = np.zeros((samples, 2)), np.zeros((samples, 2, 2, m))
        path = np.ascontiguousarray(u[:, c])
        _steps(path, table, kt, limit, friction == "isotropic", force, rate)
        forces[:, c] = weighted @ force
        integrated = (weighted @ rate.reshape(samples, -1)).reshape(m, 2, 2, m)
        rates[c] = np.moveaxis(integrated, 0, 1)
    return complex_(forces.reshape(m, 2 * contacts)), rates


def real(q: Array) -> Floats:
    """(2H + 1, ...) real coefficients (mean, re, im, ...) of complex ones (H + 1, ...)."""
    out = np.empty((2 * len(q) - 1, *q.shape[1:]))
    out[0], out[1::2], out[2::2] = q[0].real, q[1:].real, q[1:].imag
    return out


def complex_(a: Floats) -> Array:
    """The reverse of `real`."""
    out = np.empty(((len(a) + 1) // 2, *a.shape[1:]), complex)
    out[0] = a[0]
    out[1:] = a[1::2] + 1j * a[2::2]
    return out


def reference(
    problem: Problem, hertz: float, q: Array, samples: int = 8192, friction: str = "orthogonal"
) -> tuple[Array, float]:
    """Contact displacements from an independent Newton iteration on marched forces.

    Parameters
    ----------
    q : (H + 1, 2c) complex
        Where to start.

    Returns
    -------
    (H + 1, 2c) complex
    float
        Relative change of the last step.
    """
    H, d = len(q) - 1, q.shape[1]
    m, change = 2 * H + 1, np.inf
    compliance, free = [], np.zeros((H + 1, d), complex)
    for h in range(H + 1):
        right = np.column_stack([np.eye(len(problem.K))[:, :d], problem.force])
        solved = np.linalg.solve(problem.dynamic(2 * np.pi * hertz * h), right)
        compliance.append(solved[:d, :d])
        free[h] = solved[:d, d] * (h == 1)
    for _ in range(12):
        force, rate = marched(problem, q, samples, friction)
        gap = real(q - free + np.stack([R @ f for R, f in zip(compliance, force, strict=True)]))
        jacobian = np.zeros((m, d, m, d))
        for h, R in enumerate(compliance):
            moved = complex_(np.moveaxis(rate, 2, 0))[h]  # (c, 2, 2, m)
            part = np.einsum("dca,cabk->dkcb", R.reshape(d, -1, 2), moved).reshape(d, m, d)
            if h == 0:
                jacobian[0] = part.real
            else:
                jacobian[2 * h - 1], jacobian[2 * h] = part.real, part.imag
        matrix = jacobian.reshape(m * d, m * d)
        matrix[np.diag_indices_from(matrix)] += 1.0
        step = np.linalg.solve(matrix, gap.reshape(-1)).reshape(m, d)
        q = q - complex_(step)
        change = float(np.abs(step).max() / np.abs(q).max())
        if change < 1e-12:
            break
    return q, change
