"""Balances of rings, and linearised balances solved by iteration, against dense matrices."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from tests.nonlinear.systems import first_frequency, random_system, with_contacts
from tests.verification.nonlinear.spring_rings import spring_ring
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.forced_response.ring.mistuning import Mistuning
from vanelock.nonlinear.forced_response.ring.ring_source import ring_contacts, ring_source
from vanelock.nonlinear.newton.linearised import _Iterative, newton_matrix
from vanelock.nonlinear.newton.linearised_ring import LinearisedRing
from vanelock.nonlinear.newton.newton import active_rows
from vanelock.nonlinear.newton.preconditioner import Border, Equations

H, OMEGA = 2, 1.1


@dataclass(frozen=True)
class State:
    """A state of a balance that is no solution, its Newton matrix, and the contacts' stiffness.

    None of a ring, which does not need it.
    """

    balance: Any
    deviation: Any
    rows: Any
    matrix: Any
    stiffness: Any = None

    def solver(self, border=None):
        """What solves it."""
        count = self.deviation.w.size + (border.count if border else 0)
        given = self.balance, self.deviation, self.rows, np.ones(count), border, None
        solver = LinearisedRing if self.stiffness is None else _Iterative
        return solver(Equations(*given, self.stiffness))

    def check(self, seed, tolerance=1e-11, bordered=0):
        """Solver whose step under a random gap is that of the dense matrix, some rows bordered."""
        n, rows, rng = self.deviation.w.size, self.rows, np.random.default_rng(seed)
        gap, matrix, border = np.zeros(n), self.matrix, None
        gap[rows] = right = rng.normal(size=len(rows))
        if bordered:
            rate, normal = rng.normal(size=(2, bordered, n)) * np.isin(np.arange(n), rows)
            border = Border(rate, normal, rng.normal(size=(bordered, bordered)))
            matrix = np.block([[matrix, -rate[:, rows].T], [normal[:, rows], border.corner]])
            gap, right = (np.append(each, np.full(bordered, 0.7)) for each in (gap, right))
        problem, expected = self.solver(border), np.linalg.solve(matrix, right)
        step = problem.solve(gap, tolerance)
        found = step[np.append(rows, n + np.arange(bordered))]
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
        assert not np.delete(step[:n], rows).any()
        return problem


def sector_state(seed, large, **system):
    """A state in which contacts stick, slip and open."""
    one = random_system(3, **system)
    omega = 2 * np.pi * first_frequency(one) * (0.9 + 0.01 * seed)
    balance = structure(one, 3).balance(omega)
    w = large * np.random.default_rng(seed).normal(size=balance.linear.shape)
    w[::4] = 0.0
    deviation = contact_law(one.contacts, 3)(balance.displacement(w))
    rows = active_rows(w, deviation)
    matrix = newton_matrix(balance, deviation, rows)
    return State(balance, deviation, rows, matrix, one.contacts.stiffness.reshape(-1))


def ring_state(seed, size=3.0, apart=0.3, sticks=False):
    """A state in which contacts slip and open, every sector's a little of its own.

    Or of which the first sticks on springs that differ by sector.
    """
    system = spring_ring(seed)
    mistuning = Mistuning(system.sectors)
    if sticks:
        system = with_contacts(system, v0=np.array([1e3, 3.0]), mu=np.array([1e3, 0.4]))
        mistuning = Mistuning.scatter(system, {"contact": {"kn": 0.05, "kt": 0.05}}, seed)
    balance = ring_source(system, H, (OMEGA, OMEGA), 1).balance(OMEGA)
    contacts = ring_contacts(system.contacts, mistuning.of(system))
    rng, N = np.random.default_rng(seed + 50), system.sectors
    one = size * rng.normal(size=(1, system.contacts.count, 3, 2 * H + 1))
    w = one + apart * size * rng.normal(size=(N, *one.shape[1:]))
    w = w.reshape(balance.linear.shape)
    found = contacts.law(H, None, "orthogonal")(balance.displacement(w))
    slope = found.jacobian.reshape(len(w), 3 * (2 * H + 1), -1)
    columns = []
    for unit in np.eye(w.size):
        moved = balance.moved(unit.reshape(w.shape)).reshape(len(w), -1, 1)
        columns.append(unit - (slope @ moved).reshape(-1))
    assert len(active_rows(w, found)) == w.size
    return State(balance, found, np.arange(w.size), np.array(columns).T)


@pytest.mark.parametrize("bordered", [0, 1, 3])
def test_step_is_that_of_the_dense_matrix(bordered):
    state = sector_state(1, 0.5, contacts=40, size=60, preload=3.0)
    state.check(4, bordered=bordered)
    for seed in range(5):
        ring_state(seed).check(seed, bordered=bordered)


@pytest.mark.parametrize("of", ["sector", "ring"])
def test_orientation_is_the_sign_of_the_dense_determinant(of):
    signs = []
    for seed in range(60 if of == "ring" else 40):
        if of == "ring":
            state = ring_state(seed, 2.0)
        else:  # normal motion coupled to friction (large μ) is what turns the sign
            state = sector_state(seed, 0.3, contacts=30, size=40, preload=1.0, mu=4.0)
        problem = state.check(seed, 1e-9)
        signs.append((problem.orientation(), np.linalg.slogdet(state.matrix)[0]))
    found, expected = np.array(signs).T
    assert set(expected) == {-1.0, 1.0}
    np.testing.assert_array_equal(found, expected)
