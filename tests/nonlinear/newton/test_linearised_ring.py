"""Linearised balances of rings solved by those of alike ones, against their dense matrices."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.verification.nonlinear.spring_rings import RINGS, spring_ring
from vanelock.nonlinear.contact.law import Deviation
from vanelock.nonlinear.forced_response.ring.ring_source import ring_contacts, ring_source
from vanelock.nonlinear.forced_response.ring.unlike import Unlike
from vanelock.nonlinear.newton.linearised import Border, linearise
from vanelock.nonlinear.newton.linearised_ring import LinearisedRing, RingBalance, _KeptRing
from vanelock.nonlinear.newton.newton import active_rows

H = 2
OMEGA = 1.1


@dataclass(frozen=True)
class RingState:
    """A state of a ring's balance that is no solution, and its Newton matrix."""

    balance: RingBalance
    deviation: Deviation
    rows: NDArray[np.int64]
    matrix: NDArray[np.float64]


def random_state(seed: int, size: float, apart: float, sticks: bool = False) -> RingState:
    """A state in which contacts slip and open, every sector's a little of its own.

    Or of which the first sticks on springs that differ by sector.
    """
    system = spring_ring(seed)
    unlike = Unlike(system.sectors)
    if sticks:
        held = replace(system.contacts, v0=np.array([1e3, 3.0]), mu=np.array([1e3, 0.4]))
        system = replace(system, contacts=held)
        unlike = Unlike.scatter(system, {"contact": {"kn": 0.05, "kt": 0.05}}, seed)
    balance = ring_source(system, H, (OMEGA, OMEGA), 1).balance(OMEGA)
    contacts = ring_contacts(system.contacts, unlike.of(system))
    rng, N = np.random.default_rng(seed + 50), system.sectors
    one = size * rng.normal(size=(1, system.contacts.count, 3, 2 * H + 1))
    each = one + apart * size * rng.normal(size=(N, *one.shape[1:]))
    w = each.reshape(balance.linear.shape)
    found = contacts.law(H, None, "orthogonal")(balance.displacement(w))
    rows = np.arange(w.size)
    slope = found.jacobian.reshape(len(w), 3 * (2 * H + 1), -1)
    columns = []
    for unit in np.eye(w.size):
        moved = balance.moved(unit.reshape(w.shape)).reshape(len(w), -1, 1)
        columns.append(unit - (slope @ moved).reshape(-1))
    assert len(active_rows(w, found)) == w.size
    return RingState(balance, found, rows, np.array(columns).T)


def solver(state: RingState, border: Border | None = None) -> LinearisedRing:
    """What solves it."""
    count = len(state.rows) + (border.count if border else 0)
    made = linearise(
        state.balance, state.deviation, state.rows, np.ones(count), border, None, np.ones(1)
    )
    assert isinstance(made, LinearisedRing)
    return made


@pytest.mark.parametrize("bordered", [0, 1, 3])
@pytest.mark.parametrize("seed", range(5))
def test_solution_is_that_of_the_dense_matrix(seed: int, bordered: int) -> None:
    state = random_state(seed, 3.0, 0.3)
    n, rng = len(state.rows), np.random.default_rng(seed)
    matrix, border = state.matrix, None
    if bordered:
        rate, normal = rng.normal(size=(2, bordered, n))
        border = Border(rate, normal, rng.normal(size=(bordered, bordered)))
        matrix = np.block([[matrix, -rate.T], [normal, border.corner]])
    gap = rng.normal(size=len(matrix))
    expected = np.linalg.solve(matrix, gap)
    step = solver(state, border).solve(gap, 1e-11)
    assert step is not None
    np.testing.assert_allclose(step, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("seed", range(5))
def test_alike_sectors_take_one_step_of_gmres(seed: int) -> None:
    state = random_state(seed, 3.0, 0.0)
    problem = solver(state)
    gap = np.random.default_rng(seed).normal(size=len(state.rows))
    step = problem.solve(gap, 1e-10)
    expected = np.linalg.solve(state.matrix, gap)
    assert step is not None
    assert problem.hessenberg.shape == (1, 1)
    np.testing.assert_allclose(step, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("seed", range(5))
def test_what_sticks_on_springs_of_its_own_is_left_to_the_iteration(seed: int) -> None:
    state = random_state(seed, 3.0, 0.3, sticks=True)
    problem = solver(state)
    gap = np.random.default_rng(seed).normal(size=len(state.rows))
    step = problem.solve(gap, 1e-11)
    expected = np.linalg.solve(state.matrix, gap)
    assert step is not None
    np.testing.assert_allclose(step, expected, rtol=0, atol=1e-8 * np.abs(expected).max())
    assert problem.reuse is not None
    np.testing.assert_array_equal(problem.reuse.contacts, [1])
    assert problem.orientation() == np.linalg.slogdet(state.matrix)[0]


def test_orientation_is_the_sign_of_the_dense_determinant() -> None:
    signs = []
    for seed in range(60):
        state = random_state(seed, 2.0, 0.3)
        problem = solver(state)
        gap = np.random.default_rng(seed).normal(size=len(state.rows))
        assert problem.solve(gap, 1e-9) is not None
        signs.append((problem.orientation(), np.linalg.slogdet(state.matrix)[0]))
    found, expected = np.array(signs).T
    assert set(expected) == {-1.0, 1.0}
    np.testing.assert_array_equal(found, expected)


def test_inverses_serve_until_they_are_stale_or_of_other_contacts() -> None:
    state = random_state(0, 3.0, 0.3)
    kept = solver(state).reuse
    assert isinstance(kept, _KeptRing)
    assert kept.serves(np.arange(3))
    assert not kept.serves(np.arange(1))
    assert not replace(kept, stale=True).serves(np.arange(2))
    again = LinearisedRing(
        state.balance, state.deviation, state.rows, np.ones(len(state.rows)), None, kept
    )
    assert again.reuse is kept
    assert len(kept.inverse) == RINGS[0][0] // 2 + 1
