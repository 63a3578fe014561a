"""Friction under a constant normal load: one problem, its matrices, and an independent reference.

A structure of n real coordinates, the first 2c of which are the tangential displacements of c
contacts with the ground. Each direction is a Jenkins element: a spring kt in series with a slider
that slips at μ n, n constant.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.nonlinear import Contacts, Diameter, Force, System

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]

RATIO = 0.003
"""Damping of every mode of the structure with all contacts sticking."""


@dataclass(frozen=True)
class Problem:
    """Matrices of the structure without its contacts, and the contacts.

    Attributes
    ----------
    K, M, C : (n, n) float
        N/m, kg, N s/m; C gives each stuck mode the ratio RATIO.
    force : (n,) float
        Amplitude of the cosine that excites the structure, N; on the last coordinate only.
    kt : (c,) float
        N/m, the same in both directions.
    limit : (c,) float
        μ n, N.
    """

    K: Floats
    M: Floats
    C: Floats
    force: Floats
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
            force={1: Force(self.force.astype(complex))},
            damping_ratio=RATIO,
        )


def problem(size: int, contacts: int, severity: float, seed: int = 0) -> Problem:
    """A structure whose natural frequencies spread like a reduced vane's, turned at random.

    Contacts raise the first one by about a third. `severity` is the amplitude of the stuck
    structure at resonance over the one at which contacts begin to slip, on the average.
    """
    rng = np.random.default_rng(seed)
    frequencies = 200.0 * np.arange(1, size + 1) ** 1.1
    turned, _ = la.qr(rng.normal(size=(size, size)))
    K = (turned * (2 * np.pi * frequencies) ** 2) @ turned.T
    K, M = 0.5 * (K + K.T), np.eye(size)
    directions = 2 * contacts
    share = float((turned[:directions, 0] ** 2).sum())
    kt = 0.8 * (2 * np.pi * 200.0) ** 2 / share * rng.uniform(0.5, 1.5, contacts)
    force = np.zeros(size)
    force[-1] = 1.0
    bare = Problem(K, M, np.zeros_like(K), force, kt, np.ones(contacts))
    values, modes = la.eigh(bare.stuck(), M)
    C = (modes * (2 * RATIO * np.sqrt(values))) @ modes.T
    C = 0.5 * (C + C.T)
    damped = Problem(K, M, C, force, kt, np.ones(contacts))
    s = 2 * np.pi * damped.resonance()
    moved = np.abs(np.linalg.solve(damped.dynamic(s, stuck=True), force))[:directions]
    reached = np.sqrt((moved.reshape(contacts, 2) ** 2).mean(axis=1))
    limit = kt * reached.mean() / severity * rng.uniform(0.7, 1.3, contacts)
    return Problem(K, M, C, force, kt, limit)


def marched(problem: Problem, q: Array, samples: int) -> tuple[Array, NDArray[np.float64]]:
    """Friction forces' coefficients and their derivatives, by plain marching over two periods.

    Parameters
    ----------
    q : (H + 1, 2c) complex
        Coefficients of the displacements.

    Returns
    -------
    (H + 1, 2c) complex
    (2c, 2H + 1, 2H + 1) float
        d(force)/d(displacement), both as (mean, re, im, ...).
    """
    H, d = len(q) - 1, q.shape[1]
    angle = 2 * np.pi * np.arange(samples) / samples
    table = np.ones((samples, 2 * H + 1))
    for h in range(1, H + 1):
        table[:, 2 * h - 1], table[:, 2 * h] = np.cos(h * angle), -np.sin(h * angle)
    kt, limit = np.repeat(problem.kt, 2), np.repeat(problem.limit, 2)
    u = table @ real(q)
    slider, slope = np.zeros(d), np.zeros((d, 2 * H + 1))
    force, rate = np.zeros((samples, d)), np.zeros((d, 2 * H + 1, 2 * H + 1))
    reach = limit / kt
    for period in range(2):
        for i in range(samples):
            slips = np.abs(u[i] - slider) > reach
            if slips.any():
                slider[slips] = (u[i] - np.sign(u[i] - slider) * reach)[slips]
                slope[slips] = table[i]
            if period:
                force[i] = kt * (u[i] - slider)
                rate += (kt[:, None] * (table[i] - slope))[:, None, :] * table[i][:, None]
    weight = np.full(2 * H + 1, 2.0 / samples)
    weight[0] = 1.0 / samples
    return complex_(weight[:, None] * (table.T @ force)), weight[:, None] * rate


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


def reference(problem: Problem, hertz: float, q: Array, samples: int = 8192) -> tuple[Array, float]:
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
        force, rate = marched(problem, q, samples)
        gap = real(q - free + np.stack([R @ f for R, f in zip(compliance, force, strict=True)]))
        jacobian = np.zeros((m, d, m, d))
        for h, R in enumerate(compliance):
            moved = complex_(np.moveaxis(rate, 0, 1))[h]  # (2c, m)
            part = R[:, :, None] * moved[None]  # (row, direction, m)
            if h == 0:
                jacobian[0] = np.moveaxis(part.real, 2, 1)
            else:
                jacobian[2 * h - 1] = np.moveaxis(part.real, 2, 1)
                jacobian[2 * h] = np.moveaxis(part.imag, 2, 1)
        matrix = jacobian.reshape(m * d, m * d)
        matrix[np.diag_indices_from(matrix)] += 1.0
        step = np.linalg.solve(matrix, gap.reshape(-1)).reshape(m, d)
        q = q - complex_(step)
        change = float(np.abs(step).max() / np.abs(q).max())
        if change < 1e-12:
            break
    return q, change
