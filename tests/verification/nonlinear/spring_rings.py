"""Rings of a few masses and contacts a sector, and loads under which friction damps them most."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import scipy.linalg as la

from vanelock.nonlinear import SLIP, SLIP_OPEN, Options, System, frequency_response, linear_response
from vanelock.rom.system import Contacts, Diameter, Force

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
    omega2, V = la.eigh(K + (B.T * stiffness) @ B, M)
    return K, M, B, stiffness, M @ (V * (0.03 * np.sqrt(omega2))) @ V.T @ M


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


def loaded(system, force):
    return replace(system, force={1: Force(force * system.force[1].vector)})


@lru_cache
def worst_of(seed):
    """Of each kind of motion, the force at which friction holds the peak down most.

    Returns {"slip" or "lift": (peak over stuck peak, force, frequency of the peak)}; "slip": every
    contact slips and none opens; "lift": some opens in every period.
    """
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
