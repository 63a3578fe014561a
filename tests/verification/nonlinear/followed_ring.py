"""Spring rings followed in time by central differences: a second integrator, and its derivative."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg as la

from tests.verification.nonlinear.spring_rings import CONTACTS, RINGS, assembled, springs


@dataclass
class FollowedRing:
    """A spring ring followed in time by central differences, many motions at once.

    Between two steps displacements are taken as straight: a slider sets out from where they cross
    v = 0, and ends up within its bounds. What a step does so changes with its state continuously.
    """

    seed: int
    force: float
    frequency: float
    steps: int  # a period

    def __post_init__(self):
        self.sectors, self.order = RINGS[self.seed % len(RINGS)]
        K, M, B, stiffness, C = assembled(self.seed)
        contacts, load = springs(self.seed)[-2:]
        tau = 1 / self.frequency / self.steps
        left = la.inv(M / tau**2 + C / (2 * tau))
        self.angle = 2 * np.pi / self.steps
        self.ahead = (left @ (2 * M / tau**2 - K)).T
        self.back = (left @ (M / tau**2 - C / (2 * tau))).T
        self.pull, self.B = (left @ (B.T * stiffness)).T, B.T
        lag = np.exp(-2j * np.pi * self.order * np.arange(self.sectors) / self.sectors)
        self.push = left @ np.kron(lag, self.force * load)
        offset = np.column_stack([contacts.v0, 0 * contacts.kt]).ravel()
        self.offset = np.tile(offset, self.sectors)
        alpha = (contacts.mu * contacts.kn)[:, None] / contacts.kt
        self.alpha = np.tile(alpha, (self.sectors, 1))

    def displaced(self, x):
        """Relative displacements of all contacts, normal and tangential."""
        u = (x @ self.B + self.offset).reshape(*x.shape[:-1], -1, 3)
        return u[..., 0], u[..., 1:]

    def slid(self, w, before, after):
        """Sliders after a step."""
        (v0, u0), (v, u) = before, after
        down = ((v0 < 0) & (v >= 0))[..., None]
        share = np.where(down, (-v0 / np.where(v == v0, 1, v - v0))[..., None], 0)
        w = np.where(down, u0 + share * (u - u0), w)
        reach = self.alpha * np.maximum(v, 1e-300)[..., None]
        return np.where((v < 0)[..., None], u, np.clip(w, u - reach, u + reach))

    def followed(self, z, count):
        """States (..., 2n + sliders) after some steps from the beginning of the period."""
        n = len(self.ahead)
        x, before, w = z[..., :n], z[..., n : 2 * n], z[..., 2 * n :]
        w = w.reshape(*z.shape[:-1], -1, 2)
        for i in range(count):
            v, u = self.displaced(x)
            held = np.concatenate([np.maximum(v, 0)[..., None], u - w], axis=-1)
            push = (self.push * np.exp(1j * self.angle * i)).real
            pulled = held.reshape(*z.shape[:-1], -1) @ self.pull
            x, before = x @ self.ahead - before @ self.back + push - pulled, x
            w = self.slid(w, (v, u), self.displaced(x))
        return np.concatenate([x, before, w.reshape(*z.shape[:-1], -1)], axis=-1)

    def twisted(self, z):
        """What the neighbours do when the wave has come to them: on the wave, the state itself."""
        n = len(self.ahead)
        z = self.followed(z, self.steps * (self.order % self.sectors) // self.sectors)
        parts = (z[..., :n], z[..., n : 2 * n], z[..., 2 * n :])
        split = (part.reshape(*z.shape[:-1], self.sectors, -1) for part in parts)
        return np.concatenate(
            [np.roll(part, -1, axis=-2).reshape(*z.shape[:-1], -1) for part in split], axis=-1
        )

    def start(self, response):
        """The state of a response, which sliders move, and how large its vibration is."""
        h = np.arange(response.harmonics + 1)
        lag = np.exp(-2j * np.pi * self.order * np.outer(h, np.arange(self.sectors)) / self.sectors)
        wave = np.array([np.kron(lag[i], response.x[i][0]) for i in h])
        angles = self.angle * np.arange(-2 * self.steps, 1)
        path = (np.exp(1j * np.outer(angles, h)) @ wave).real
        w, places = np.zeros((self.sectors * CONTACTS, 2)), []
        for one, other in pairwise(path):
            w = self.slid(w, self.displaced(one), self.displaced(other))
            places.append(w)
        moves = np.ptp(places[-self.steps :], axis=0) > 1e-12
        return np.concatenate([path[-1], path[-2], w.ravel()]), moves, np.abs(wave[1:]).max()

    def derivative(self, response):
        """The twisted map about its own fixed point, by finite differences."""
        z, moves, size = self.start(response)
        self.alpha = np.where(moves, self.alpha, np.inf)  # a slider that rests stays there
        free = np.concatenate([np.ones(2 * len(self.ahead), bool), moves.ravel()])
        step = 1e-6 * size * np.eye(len(z))[free]
        for _ in range(3):
            change = (self.twisted(z + step) - self.twisted(z - step)) / (2e-6 * size)
            J = change[:, free].T
            gap = (self.twisted(z) - z)[free]
            z[free] += la.solve(np.eye(len(J)) - J, gap)
        assert np.abs(gap).max() < 1e-9 * size
        return J
