"""An independent contact law and small systems, written without the package's kernels."""

from collections.abc import Callable

import numpy as np
import pytest
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.rom.system.system import Contacts, Diameter, Force, System

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]


def march(contacts: Contacts, q: Array, count: int) -> Floats:
    """Forces (n, t1, t2) of all contacts by the three states of the element, after one period.

    q holds one-sided coefficients (H + 1, ..., c, 3) of (v, u1, u2), several motions at once; the
    result is (count, ..., c, 3).
    """
    angle = 2 * np.pi * np.arange(count) / count
    h = np.arange(len(q))
    wave = np.exp(1j * np.outer(angle, h))
    u = np.einsum("th,h...->t...", wave, q).real
    kt, mu = contacts.kt, contacts.mu[:, None]
    n = np.maximum(contacts.kn * u[..., 0], 0.0)[..., None]
    slip = mu * n
    moved = kt * np.diff(u[..., 1:], axis=0, prepend=u[-1:, ..., 1:])
    open_ = n == 0
    forces = np.concatenate([n, np.zeros_like(u[..., 1:])], axis=-1)
    t = np.clip(kt * u[0, ..., 1:], -slip[0], slip[0])
    for i in range(1, 2 * count):
        s = i % count
        t = np.where(open_[s], 0.0, np.clip(t + moved[s], -slip[s], slip[s]))
        forces[s, ..., 1:] = t
    return forces


def coefficients(history: Floats, harmonics: int) -> Array:
    """One-sided coefficients (H + 1, ...) of sampled histories (s, ...)."""
    q: Array = np.fft.rfft(history, axis=0)[: harmonics + 1] / len(history)
    q[1:] *= 2
    return q


def random_system(
    seed: int,
    *,
    size: int = 20,
    contacts: int = 6,
    mu: float = 0.3,
    preload: float = 1.0,
    amplitude: float = 1.0,
    damping_ratio: float | None = 0.005,
    sectors: int = 5,
    engine_order: int = 1,
    harmonics: int = 5,
) -> System:
    """Hermitian matrices by nodal diameter, contacts within the sector and to the next one."""
    rng = np.random.default_rng(seed)
    own = rng.normal(size=(contacts, 3, size)).astype(complex)
    beyond = rng.normal(size=(contacts, 3, size)) * (rng.random((contacts, 1, 1)) < 0.5) + 0j
    base, coupling = rng.normal(size=(size, size)), 0.2 * rng.normal(size=(size, size))
    diameters = {}
    for k in sorted({(h * engine_order) % sectors for h in range(harmonics + 1)}):
        factor = base + coupling * np.exp(-2j * np.pi * k / sectors)
        K = factor.conj().T @ factor + 0.3 * np.eye(size)
        diameters[k] = Diameter(
            K=K.real if k == 0 else K,
            M=np.diag(np.linspace(0.5, 2, size)),
            own=own,
            next=beyond if sectors > 1 else None,
            output=np.eye(size, dtype=complex)[None, :3],
        )
    push: Array = rng.normal(size=size) + 1j * rng.normal(size=size)
    return System(
        sectors=sectors,
        engine_order=engine_order,
        diameters=diameters,
        contacts=Contacts(
            kn=rng.uniform(0.5, 2, contacts),
            kt=rng.uniform(0.5, 2, (contacts, 2)),
            mu=np.full(contacts, mu),
            v0=preload * rng.uniform(0.3, 1, contacts),
        ),
        force={1: Force(amplitude * push)},
        output_names=("tip",),
        damping_ratio=damping_ratio,
    )


def first_frequency(system: System) -> float:
    """Lowest natural frequency of the first harmonic without contacts, Hz."""
    matrices = system.at(system.nodal_diameter(1))
    return float(np.sqrt(la.eigvalsh(matrices.K, matrices.M)[0]) / (2 * np.pi))


def sliding_system(
    *, sectors: int = 8, amplitude: float = 1.0, preload: float = 1.0, mu: float = 0.3
) -> System:
    """Two coordinates a sector and a contact to the next, which slips at the lowest, near 0.18 Hz.

    Its harmonics fall quickly.
    """
    push: Array = np.array([0.03 * amplitude, 0.01 * amplitude], complex)
    own = np.zeros((1, 3, 2))
    own[0, :, 1], own[0, 1, 0], own[0, 1, 1] = (1, 0, 0.3), 1, 0
    diameters = {}
    for k in range(sectors // 2 + 1):
        beside = 1 - np.cos(2 * np.pi * k / sectors)
        diameters[k] = Diameter(
            K=np.array([[1 + 0.3 * beside, 0.2], [0.2, 3 + 0.4 * beside]]),
            M=np.diag([1.0, 0.8]),
            own=own,
            next=-0.5 * own,
            output=np.array([[[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]]),
        )
    return System(
        sectors=sectors,
        engine_order=1,
        diameters=diameters,
        contacts=Contacts(
            np.full(1, 0.5), np.full((1, 2), 0.5), np.full(1, mu), np.full(1, preload)
        ),
        force={1: Force(push)},
        output_names=("tip",),
        damping_ratio=0.01,
    )


@pytest.fixture(scope="session", name="march")
def march_fixture() -> Callable[[Contacts, Array, int], Floats]:
    return march


@pytest.fixture(scope="session", name="coefficients")
def coefficients_fixture() -> Callable[[Floats, int], Array]:
    return coefficients


@pytest.fixture(scope="session", name="random_system")
def random_system_fixture() -> Callable[..., System]:
    return random_system


@pytest.fixture(scope="session", name="first_frequency")
def first_frequency_fixture() -> Callable[[System], float]:
    return first_frequency


@pytest.fixture(scope="session", name="sliding_system")
def sliding_system_fixture() -> Callable[..., System]:
    return sliding_system
