"""The balance of all sectors against the matrices of the whole ring."""

import numpy as np
import pytest
import scipy.linalg as la
from numpy.typing import NDArray

from tests.verification.nonlinear.spring_rings import CONTACTS, RINGS, assembled, spring_ring
from vanelock.nonlinear.forced_response.ring.ring_source import ring_source
from vanelock.nonlinear.fourier import to_complex

H = 4


def lag_of(seed: int) -> NDArray[np.complex128]:
    """(H + 1, N) by which harmonics of sectors are later than those of the first."""
    N, order = RINGS[seed % len(RINGS)]
    return np.asarray(np.exp(-2j * np.pi * order * np.outer(np.arange(H + 1), np.arange(N)) / N))


@pytest.mark.parametrize("seed", range(5))
def test_deviations_move_the_ring_as_its_matrices_say(seed: int) -> None:
    system = spring_ring(seed)
    omega, lag = 1.3, lag_of(seed)
    balance = ring_source(system, H, (omega, omega), 1).balance(omega)
    rng = np.random.default_rng(seed)
    w = rng.normal(size=(system.sectors, CONTACTS, 3, 2 * H + 1))
    w[:, 1, 2] = 0.0  # of no unknown
    w = w.reshape(-1, 3, 2 * H + 1)
    K, M, B, stiffness, C = assembled(seed)
    moved, ahead = balance.moved(w), balance.linear
    for h in range(H + 1):
        late = np.repeat(lag[h], 3 * CONTACTS)
        D = K + (B.T * stiffness) @ B - (h * omega) ** 2 * M + 1j * h * omega * C
        u = B @ la.solve(D, B.T @ (stiffness * late * to_complex(w)[h].reshape(-1)))
        got = late * to_complex(moved)[h].reshape(-1)
        np.testing.assert_allclose(got, u, rtol=0, atol=1e-12 * np.abs(u).max())
        one = to_complex(ahead)[h].reshape(system.sectors, -1)
        np.testing.assert_array_equal(one, np.tile(one[:1], (system.sectors, 1)))


def test_fewer_harmonics_are_the_first_of_all() -> None:
    balance = ring_source(spring_ring(2), H, (1.3, 1.3), 1).balance(1.3)
    w = np.random.default_rng(0).normal(size=balance.linear.shape)
    few = balance.with_harmonics(2)
    np.testing.assert_allclose(few.moved(w[:, :, :5]), balance.moved(w)[:, :, :5], atol=1e-14)
    np.testing.assert_array_equal(few.linear, balance.linear[:, :, :5])


def test_motions_change_with_frequency_as_their_slope_says() -> None:
    source = ring_source(spring_ring(1), H, (1.3, 1.3), 1)
    w = np.random.default_rng(1).normal(size=source.balance(1.3).linear.shape)
    above, below = (source.balance(1.3 + s * 1e-5).displacement(w) for s in (1, -1))
    slope = source.slope(1.3, w)
    np.testing.assert_allclose(slope, (above - below) / 2e-5, atol=1e-7 * np.abs(slope).max())
