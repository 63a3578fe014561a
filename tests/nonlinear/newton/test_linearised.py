"""Linearised balances solved by GMRES on few directions, against their dense matrices."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.nonlinear import System
from vanelock.nonlinear.balance.balance import Balance, structure
from vanelock.nonlinear.contact.law import Deviation, contact_law
from vanelock.nonlinear.newton.linearised import Border, _Iterative, newton_matrix
from vanelock.nonlinear.newton.newton import active_rows
from vanelock.nonlinear.newton.preconditioner import _gmres

Make = Callable[..., System]
Lowest = Callable[[System], float]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class State:
    """A state of the balance that is no solution, and its Newton matrix."""

    balance: Balance
    deviation: Deviation
    rows: NDArray[np.int64]
    matrix: Floats
    stiffness: Floats


def random_state(system: System, omega: float, seed: int, size: float) -> State:
    """A state in which contacts stick, slip and open."""
    balance = structure(system, 3).balance(omega)
    rng = np.random.default_rng(seed)
    w = size * rng.normal(size=balance.linear.shape)
    w[::4] = 0.0
    law = contact_law(system.contacts, 3)
    found = law(balance.displacement(w))
    rows = active_rows(w, found)
    matrix = newton_matrix(balance, found, rows)
    return State(balance, found, rows, matrix, system.contacts.stiffness.reshape(-1))


def iterative(state: State, border: Border | None = None) -> _Iterative:
    count = state.deviation.w.size + (border.count if border else 0)
    return _Iterative(
        state.balance, state.deviation, state.rows, np.ones(count), border, None, state.stiffness
    )


@pytest.mark.parametrize("bordered", [0, 1, 3])
def test_solution_is_that_of_the_dense_matrix(
    random_system: Make, first_frequency: Lowest, bordered: int
) -> None:
    system = random_system(3, contacts=40, size=60, preload=3.0)
    state = random_state(system, 2 * np.pi * 1.1 * first_frequency(system), 1, 0.5)
    n, rng = state.deviation.w.size, np.random.default_rng(4)
    gap, rows, matrix, border = np.zeros(n), state.rows, state.matrix, None
    gap[rows] = right = rng.normal(size=len(rows))
    if bordered:
        rate, normal = rng.normal(size=(2, bordered, n)) * np.isin(np.arange(n), rows)
        border = Border(rate, normal, rng.normal(size=(bordered, bordered)))
        matrix = np.block([[matrix, -rate[:, rows].T], [normal[:, rows], border.corner]])
        gap, right = (np.append(each, np.full(bordered, 0.7)) for each in (gap, right))
    expected = np.linalg.solve(matrix, right)
    step = iterative(state, border).solve(gap, 1e-11)
    assert step is not None
    got = step[np.append(rows, n + np.arange(bordered))]
    assert np.abs(got - expected).max() < 1e-8 * np.abs(expected).max()
    outside = np.delete(step, state.rows)
    assert np.abs(outside[: n - len(state.rows)]).max(initial=0.0) == 0.0


def test_orientation_is_the_sign_of_the_dense_determinant(
    random_system: Make, first_frequency: Lowest
) -> None:
    # Normal motion coupled to friction (large μ) is what turns the sign.
    system = random_system(3, contacts=30, size=40, preload=1.0, mu=4.0)
    lowest = first_frequency(system)
    signs = []
    for seed in range(40):
        omega = 2 * np.pi * lowest * (0.9 + 0.01 * seed)
        state = random_state(system, omega, seed, 0.3)
        problem = iterative(state)
        gap = np.zeros(state.deviation.w.size)
        gap[state.rows] = np.random.default_rng(seed).normal(size=len(state.rows))
        assert problem.solve(gap, 1e-9) is not None
        signs.append((problem.orientation(), np.linalg.slogdet(state.matrix)[0]))
    found, expected = np.array(signs).T
    assert set(expected) == {-1.0, 1.0}
    np.testing.assert_array_equal(found, expected)


def test_gmres_stops_at_the_tolerance_and_gives_eigenvalues() -> None:
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(80, 80)))[0]
    values = np.concatenate([[-0.3, 0.02], rng.uniform(0.8, 1.2, 78)])
    matrix = (turn * values) @ turn.T
    right = rng.normal(size=80)
    reached = _gmres(lambda x: matrix @ x, right, 1e-10, 80)
    left = np.linalg.norm(matrix @ reached.solution - right) / np.linalg.norm(right)
    assert left < 1.1e-10
    np.testing.assert_allclose(reached.residual, left, rtol=1e-3)
    assert 10 < reached.iterations < 40
    ritz = np.sort(np.linalg.eigvals(reached.hessenberg).real)
    np.testing.assert_allclose(ritz[:2], [-0.3, 0.02], atol=1e-6)
