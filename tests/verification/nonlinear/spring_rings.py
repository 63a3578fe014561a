"""Rings of a few masses and contacts a sector, and loads under which friction damps them most."""

import json
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import scipy.linalg as la

from tests.conftest import FULL
from tests.nonlinear.systems import proportional
from vanelock.nonlinear import SLIP, SLIP_OPEN, Options, System, frequency_response, linear_response
from vanelock.rom.system.system import Contacts, Diameter, Force

LOADS = json.loads(Path(__file__).with_name("ring_loads.json").read_text())
"""What `search` finds for rings 0 to 23: where tests load them, not what they should find."""
MASSES, CONTACTS = 3, 2
RINGS = ((5, 1), (6, -1), (7, 2), (8, 3), (8, -2))  # sectors, engine order


def springs(seed):
    """K of a sector and to the next one, M, contact rows on own and on next coordinates, load."""
    rng = np.random.default_rng(seed)
    K0, K1 = np.diag(rng.uniform(0.5, 1, MASSES)), np.zeros((MASSES, MASSES))
    for a in range(MASSES):
        for b in range(a):
            k = rng.uniform(0.1, 0.5)
            K0[[a, b], [a, b]] += k
            K0[[a, b], [b, a]] -= k
        k, b = rng.uniform(0.05, 0.3), int(rng.integers(MASSES))
        K0[a, a] += k
        K0[b, b] += k
        K1[a, b] -= k
    M = np.diag(rng.uniform(0.5, 1.5, MASSES))
    own, beyond = 0.6 * rng.normal(size=(CONTACTS, 3, MASSES)), np.zeros((CONTACTS, 3, MASSES))
    beyond[1] = 0.6 * rng.normal(size=(3, MASSES))  # the second contact lies between two sectors
    contacts = Contacts(
        rng.uniform(0.5, 1, CONTACTS),
        rng.uniform(0.5, 1, (CONTACTS, 2)),
        np.full(CONTACTS, 0.4),
        np.full(CONTACTS, 3.0),
    )
    load = np.asarray(rng.normal(size=(2, MASSES)).T @ [1, 1j], complex)
    return K0, K1, M, own, beyond, contacts, load


def assembled(seed):
    """K, M, B, contact stiffness and C of a spring ring in the coordinates of all its sectors."""
    N, _ = RINGS[seed % len(RINGS)]
    K0, K1, M, own, beyond, contacts, _ = springs(seed)
    following = np.roll(np.eye(N), 1, axis=1)
    K = np.kron(np.eye(N), K0) + np.kron(following, K1) + np.kron(following.T, K1.T)
    M = np.kron(np.eye(N), M)
    B = np.einsum("ij,cem->icejm", np.eye(N), own) + np.einsum("ij,cem->icejm", following, beyond)
    B = B.reshape(-1, N * MASSES)
    stiffness = np.tile(np.column_stack([contacts.kn, contacts.kt]).ravel(), N)
    return K, M, B, stiffness, proportional(K + (B.T * stiffness) @ B, M, 0.015)


def spring_ring(seed, force=1.0):
    """A ring of a few masses and contacts a sector, by nodal diameter."""
    sectors, order = RINGS[seed % len(RINGS)]
    K0, K1, M, own, beyond, contacts, load = springs(seed)
    diameters = {}
    for k in range(sectors // 2 + 1):
        following = K1 * np.exp(-2j * np.pi * k / sectors)
        K = K0 + following + following.conj().T
        real = (2 * k) % sectors == 0
        diameters[k] = Diameter(
            K=K.real if real else K, M=M, own=own, next=beyond, output=np.eye(MASSES)[None]
        )
    return System(sectors, order, diameters, contacts, {1: Force(force * load)}, ("masses",), 0.015)


def loaded(system, factor):
    """A system under so many times its vibrating force."""
    return replace(system, force={1: Force(factor * system.force[1].vector)})


@lru_cache
def worst_of(seed):
    """Of each kind of motion, the force at which friction holds the peak down most.

    Returns {"slip" or "lift": (peak over stuck peak, force, frequency of the peak)}; "slip": every
    contact slips and none opens; "lift": some opens in every period. Searched for at full count.
    """
    known = {kind: tuple(found) for kind, found in LOADS.get(str(seed), {}).items()}
    if known and not FULL:
        return known
    found = search(seed)
    for kind, each in known.items():
        np.testing.assert_allclose(found[kind], each, rtol=1e-6)
    return found


def worst_ring(seed, kind):
    """A ring under such a force, or that of the other kind where one is not found; its peak, Hz."""
    kinds = worst_of(seed)
    _, force, frequency = kinds.get(kind) or next(iter(kinds.values()))
    return spring_ring(seed, force), frequency


def search(seed):
    """The same by twelve sweeps."""
    system = spring_ring(seed)
    stuck = linear_response(system, np.linspace(0.1, 0.45, 1500)).amplitude[:, 0].max()
    found: dict[str, tuple[float, float, float]] = {}
    for force in 0.1 * 1.5 ** np.arange(12):
        hertz, options = np.linspace(0.1, 0.45, 71), Options(1)
        response = frequency_response(loaded(system, force), hertz, options, find_jumps=False)
        size = response.amplitude[:, 0].max(axis=1)
        top = int(np.argmax(size))
        state, ratio = response.state[top], size[top] / (force * stuck)
        kind = "slip" if np.all(state == SLIP) else "lift" if np.any(state == SLIP_OPEN) else ""
        if kind and ratio < found.get(kind, (np.inf,))[0]:
            found[kind] = ratio, force, response.frequency[top]
    return found


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

    def followed(self, z, count, begin=0):
        """States (..., 2n + sliders) after some steps, from a step of the period on."""
        n = len(self.ahead)
        x, before, w = z[..., :n], z[..., n : 2 * n], z[..., 2 * n :]
        w = w.reshape(*z.shape[:-1], -1, 2)
        for i in range(begin, begin + count):
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

    def period(self, z):
        """Displacements (steps, n) of a period, and the state after it."""
        path = np.empty((self.steps, len(self.ahead)))
        for i in range(self.steps):
            path[i] = z[: path.shape[1]]
            z = self.followed(z, 1, i)
        return path, z

    def wave(self, response):
        """Harmonics (H + 1, n) of all sectors' displacements."""
        h = np.arange(response.harmonics + 1)
        lag = np.exp(-2j * np.pi * self.order * np.outer(h, np.arange(self.sectors)) / self.sectors)
        return np.array([np.kron(lag[i], response.x[i][0]) for i in h])

    def start(self, wave):
        """The state of a motion given by its harmonics, and which sliders move."""
        angles = self.angle * np.arange(-2 * self.steps, 1)
        path = (np.exp(1j * np.outer(angles, np.arange(len(wave)))) @ wave).real
        w, places = np.zeros((self.sectors * CONTACTS, 2)), []
        for one, other in pairwise(path):
            w = self.slid(w, self.displaced(one), self.displaced(other))
            places.append(w)
        moves = np.ptp(places[-self.steps :], axis=0) > 1e-12
        return np.concatenate([path[-1], path[-2], w.ravel()]), moves

    def derivative(self, response):
        """The twisted map about its own fixed point, by finite differences."""
        wave = self.wave(response)
        (z, moves), size = self.start(wave), np.abs(wave[1:]).max()
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
