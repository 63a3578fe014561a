"""Rings of mistuned sectors against alike ones, dense matrices, a bound, and the ring in time."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from tests.conftest import FULL
from tests.nonlinear.systems import coefficients, solved_response
from tests.verification.nonlinear.spring_rings import (
    CONTACTS,
    MASSES,
    RINGS,
    FollowedRing,
    assembled,
    spring_ring,
    springs,
    worst_of,
    worst_ring,
)
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Force,
    Mistuning,
    Options,
    SectorModes,
    System,
    ring_response,
    whitehead,
)

SEEDS = range(24) if FULL else (0, 4)
QUANTITIES = ("interference", "mu", "kn", "kt")


def drawn(system, seed, size, names=QUANTITIES):
    """A ring all of whose contacts differ."""
    scatter = Mistuning.scatter(system, {"contact": dict.fromkeys(names, size)}, seed)
    rng = np.random.default_rng(seed)
    slider = 0.05 * rng.normal(size=(system.sectors, CONTACTS, 2))
    return replace(scatter, slider=slider)


def kinds_of(seeds):
    """Rings at the loads at which contacts slip, and at which they open."""
    return [(seed, kind) for seed in seeds for kind in worst_of(seed)]


def test_ring_of_alike_sectors_is_one_sector(record, below):
    worst, count = 0.0, 0
    for seed, kind in kinds_of(SEEDS):
        system, frequency = worst_ring(seed, kind)
        hertz = frequency + np.array([-0.02, -0.01, 0.0, 0.01])
        options = Options(5, tolerance=1e-12)
        one = solved_response(system, hertz, options)
        ring = ring_response(system, hertz, Mistuning(system.sectors), options)
        assert ring.converged.all()
        turn = np.outer(np.arange(6), np.arange(system.sectors)) * system.engine_order
        lag = np.exp(-2j * np.pi * turn / system.sectors)[:, :, None, None]
        for of in ("contact", "force", "output"):
            own = getattr(one, of)[:, :, None]
            apart = np.abs(getattr(ring, of) - lag * own).max() / np.abs(own[:, 1:]).max()
            worst = max(worst, apart)
        count += len(hertz)
    record("points", count)
    below("largest difference", worst, 1e-10)


def held(system):
    """The same with contacts that neither open nor slip."""
    contacts = replace(system.contacts, v0=0 * system.contacts.v0 + 1e2, mu=np.full(CONTACTS, 1e3))
    return replace(system, contacts=contacts)


@pytest.mark.parametrize("seed", SEEDS)
def test_linear_ring_is_that_of_dense_matrices(seed, below):
    system = held(spring_ring(seed, 0.1))
    N, order = RINGS[seed % len(RINGS)]
    K, M, B, stiffness, C = assembled(seed)
    K0, _, M0, _, _, _, load = springs(seed)
    squared, shapes = la.eigh(K0, M0)
    g = shapes[:, :2].T @ M0
    modes = SectorModes(dict.fromkeys(range(N // 2 + 1), g), squared[:2])
    mistuning = drawn(system, seed, 0.1)
    rng = np.random.default_rng(seed + 100)
    mistuning = replace(mistuning, frequency=0.05 * rng.normal(size=(N, 2)), modes=modes)
    hertz = np.linspace(0.1, 0.45, 12)
    found = ring_response(system, hertz, mistuning, Options(1, tolerance=1e-12))
    assert found.converged.all()
    stretched = np.concatenate([mistuning.kn[:, :, None], mistuning.kt], axis=2).reshape(-1)
    springy = stiffness * (1 + stretched)
    whole = K + (B.T * springy) @ B
    for j in range(N):
        own = np.zeros((2, N * MASSES))
        own[:, MASSES * j : MASSES * (j + 1)] = g
        whole += (own.T * (squared[:2] * ((1 + mistuning.frequency[j]) ** 2 - 1))) @ own
    offset = np.concatenate(
        [system.contacts.v0[:, None] + mistuning.interference[:, :, None], -mistuning.slider],
        axis=2,
    ).reshape(-1)
    rest = la.solve(whole, -B.T @ (springy * offset))
    lag = np.exp(-2j * np.pi * order * np.arange(N) / N)
    worst = 0.0
    for i, f in enumerate(hertz):
        omega = 2 * np.pi * f
        x = la.solve(whole - omega**2 * M + 1j * omega * C, np.kron(lag, 0.1 * load))
        for h, one in enumerate((rest, x)):
            apart = np.abs(found.output[i, h].reshape(-1) - one).max() / np.abs(one).max()
            pulled = springy * (B @ one + (offset if h == 0 else 0.0))
            missed = np.abs(found.force[i, h].reshape(-1) - pulled).max() / np.abs(pulled).max()
            worst = max(worst, apart, missed)
    below("largest difference", worst, 1e-10)


def oscillators(sectors, order, coupling, damping):
    """One mass a sector, springs to the next, viscous damping; no contacts.

    The load grows with frequency, so that a mode's resonance is as high wherever it lies.
    """
    diameters = {
        k: Diameter(
            K=np.array([[1 + 2 * coupling * (1 - np.cos(2 * np.pi * k / sectors))]]),
            M=np.eye(1),
            own=np.zeros((0, 3, 1)),
            output=np.array([[[1.0], [0.0], [0.0]]]),
            C=damping * np.eye(1),
        )
        for k in range(sectors // 2 + 1)
    }
    none = Contacts(np.zeros(0), np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    modes = SectorModes({k: np.eye(1) for k in diameters}, np.ones(1))
    return System(sectors, order, diameters, none, {1: Force(np.ones(1), 1)}, ("tip",)), modes


def worst_pattern(sectors, order, coupling):
    """Frequency deviations with which a mode has the shape that Whitehead's bound is reached by."""
    a = np.sqrt((1 + 1 / np.sqrt(sectors)) / 2)
    shape = np.full(sectors, np.sqrt((1 - a**2) / (sectors - 1)))
    shape[0] = a
    shape *= np.cos(2 * np.pi * order * np.arange(sectors) / sectors)
    beside = np.roll(shape, 1) + np.roll(shape, -1)
    squared = 1 + coupling * beside / shape  # all move with ω² = 1 + 2 coupling
    return np.sqrt(squared) - 1


@pytest.mark.parametrize("sectors", [4, 6, 10, 16, 30] if FULL else [6])
@pytest.mark.parametrize("side", [0, 1])
def test_worst_pattern_reaches_whiteheads_bound(sectors, side, record):
    order, coupling, damping = side * sectors // 2, 0.02, 1e-6
    system, modes = oscillators(sectors, order, coupling, damping)
    pattern = worst_pattern(sectors, order, coupling)
    mistuning = Mistuning(sectors, frequency=pattern[:, None], modes=modes)
    at = 1 + 2 * coupling * (1 - np.cos(2 * np.pi * order / sectors))
    hertz = np.sqrt([1 + 2 * coupling, at]) / (2 * np.pi)
    found = ring_response(system, hertz, mistuning, Options(1))
    assert found.converged.all()
    ratio = found.amplification[:, 0, 0]
    record("amplification over the bound", f"{ratio.max() / whitehead(sectors):.4f}")
    assert ratio.argmax() == 0
    assert 0.99 < ratio.max() / whitehead(sectors) < 1 + 1e-3


def test_no_pattern_exceeds_whiteheads_bound(record):
    rng, closest = np.random.default_rng(7), 0.0
    for _ in range(200 if FULL else 10):
        sectors = int(rng.integers(3, 13))
        order = int(rng.integers(0, sectors))
        system, modes = oscillators(sectors, order, 10.0 ** rng.uniform(-3, -1), 0.004)
        shifts = 10.0 ** rng.uniform(-3, -1) * rng.normal(size=(sectors, 1))
        mistuning = Mistuning(sectors, frequency=shifts, modes=modes)
        squared = system.at(order).K[0, 0].real
        K = la.circulant(np.fft.ifft([system.at(k).K[0, 0] for k in range(sectors)]).real)
        K = K + np.diag((1 + shifts[:, 0]) ** 2 - 1)
        peaks = np.sqrt(np.append(la.eigvalsh(K), squared)) / (2 * np.pi)
        found = ring_response(system, np.sort(peaks), mistuning, Options(1))
        assert found.converged.all()
        closest = max(closest, found.amplification[:, 0, 0].max() / whitehead(sectors))
    record("largest amplification over the bound", f"{closest:.3f}")
    assert closest < 1 + 1e-4


def followed(seed, force, frequency, mistuning, steps):
    """An mistuning spring ring in time: its own offsets, springs and bounds."""
    ring = FollowedRing(seed, force, frequency, steps)
    contacts = springs(seed)[-2]
    shares = np.concatenate([mistuning.kn[:, :, None], mistuning.kt], axis=2)
    ring.pull = (ring.pull.T * (1 + shares.reshape(-1))).T
    own = np.concatenate([mistuning.interference[:, :, None], -mistuning.slider], axis=2)
    ring.offset = ring.offset + own.reshape(-1)
    kn, mu = contacts.kn * (1 + mistuning.kn), contacts.mu * (1 + mistuning.mu)
    ring.alpha = ((mu * kn)[:, :, None] / (contacts.kt * (1 + mistuning.kt))).reshape(-1, 2)
    return ring


def settled(ring, output, periods, harmonics):
    """Harmonics of all masses in the last of some periods, from a motion (H + 1, N n)."""
    z = ring.followed(ring.start(output)[0], periods * ring.steps)
    history, z = ring.period(z)
    return coefficients(history, harmonics), np.abs(z[: history.shape[1]] - history[0]).max()


@pytest.mark.parametrize("kind", ["slip", "lift"])
def test_ring_in_time_settles_on_the_unlike_answer(kind, record):
    seeds = range(12) if FULL else {"slip": (0,), "lift": (4,)}[kind]
    apart: dict[int, list[float]] = {256: [], 512: []} if FULL else {512: []}
    left = rings = 0
    for seed in seeds:
        if kind not in worst_of(seed):
            continue
        rings += 1
        _, force, frequency = worst_of(seed)[kind]
        system = spring_ring(seed, force)
        mistuning = drawn(system, seed, 0.1)
        found = ring_response(system, [frequency], mistuning, Options(9))
        assert found.converged.all()
        alike = solved_response(system, [frequency], Options(9))
        differs = np.abs(found.amplitude[0] / alike.amplitude[0] - 1).max()
        assert differs > 0.01
        output = found.output[0].reshape(10, -1)
        size = np.abs(output[1:]).max()
        errors = []
        for steps in apart:
            ring = followed(seed, force, frequency, mistuning, steps)
            q, unsteady = settled(ring, output, 80, 9)
            errors.append(np.abs(q - output).max() / size)
        if unsteady > 1e-4 * size:
            left += 1
            continue
        for steps, error in zip(apart, errors, strict=True):
            apart[steps].append(error)
    record("rings", rings)
    record("not steady in time", left)
    for steps, each in apart.items():
        record(f"largest difference, {steps} steps a period", f"{max(each):.1e}")
    assert left <= 0.25 * rings
    assert max(apart[512]) < 2e-3


def test_turned_pattern_turns_the_answer(below):
    worst = 0.0
    for seed, kind in kinds_of(SEEDS):
        system, frequency = worst_ring(seed, kind)
        mistuning = drawn(system, seed, 0.05)
        found = ring_response(system, [frequency], mistuning, Options(3))
        names = ("interference", "slider", "mu", "kn", "kt", "frequency")
        other = replace(mistuning, **{n: np.roll(getattr(mistuning, n), 2, axis=0) for n in names})
        turned = ring_response(system, [frequency], other, Options(3))
        assert found.converged.all()
        lag = np.exp(-4j * np.pi * np.arange(4) * system.engine_order / system.sectors)
        expected = lag[:, None, None, None] * np.roll(found.output[0], 2, axis=1)
        worst = max(worst, np.abs(turned.output[0] - expected).max() / np.abs(expected[1:]).max())
    below("largest difference", worst, 1e-9)
