"""Multipliers with isotropic friction against finite differences of another integration in time."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from scipy.integrate import solve_ivp

from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    STABLE,
    UNSTABLE,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    stability,
)
from vanelock.nonlinear.contact.disc_slider import FREE, HELD
from vanelock.nonlinear.contact.disc_slip import BEGIN, END, KIND
from vanelock.nonlinear.contact.isotropic_law import slider_pieces, slider_places
from vanelock.nonlinear.floquet.plane_transfer import plane_transfer
from vanelock.nonlinear.fourier import grid, to_real

MASS, SPRING = np.array([1.0, 1.0, 0.6]), np.array([1.0, 1.3, 2.0])
ROWS = np.array([[0.3, -0.2, 1.0], [1.0, 0.1, 0.2], [0.0, 1.0, -0.3]])  # v, u1, u2
RATIO = 0.01


def block(push, mu, v0, kn=0.9, kt=0.8, sectors=1):
    """A mass on springs that slides on the ground, its directions not those of the contact."""
    same = Diameter(K=np.diag(SPRING), M=np.diag(MASS), own=ROWS[None])
    return System(
        sectors=sectors,
        engine_order=min(sectors - 1, 1),
        diameters=dict.fromkeys(range(sectors // 2 + 1), same),
        contacts=Contacts(np.full(1, kn), np.full((1, 2), kt), np.array([mu]), np.array([v0])),
        force={1: Force(np.array(push, complex))},
        damping_ratio=RATIO,
    )


class Block:
    """The same, its three states integrated one after another, events located by SciPy.

    The state is (x, x', w): w' = 0 held, w' = λ e slipping, w' = p' open.
    """

    def __init__(self, system, omega):
        contacts = system.contacts
        self.stiffness, self.v0 = contacts.stiffness[0], contacts.v0[0]
        self.alpha, self.omega = contacts.alpha[0, 0], omega
        self.push = system.force[1].vector
        stuck = np.diag(SPRING) + (ROWS.T * self.stiffness) @ ROWS
        squares, V = la.eigh(stuck, np.diag(MASS))
        scaled = MASS[:, None] * V
        self.damping = (scaled * (2 * RATIO * np.sqrt(squares))) @ scaled.T

    def contact(self, state):
        """What is p - w, and r, p' and r'."""
        u, rate = ROWS @ state[:3], ROWS @ state[3:6]
        return u[1:] - state[6:], self.alpha * (u[0] + self.v0), rate[1:], self.alpha * rate[0]

    def sliding(self, state):
        """The force's direction e, and λ."""
        away, _, moved, grown = self.contact(state)
        e = away / la.norm(away)
        return e, moved @ e - grown

    def rates(self, t, state, mode):
        """Rates of the state while the contact is held, slips or is open."""
        away, r, moved, _ = self.contact(state)
        pull = self.stiffness * np.array([max(r, 0.0) / self.alpha, *away])
        if mode == "open":
            pull[:] = 0.0
        force = (self.push * np.exp(1j * self.omega * t)).real - ROWS.T @ pull
        bent = (force - SPRING * state[:3] - self.damping @ state[3:6]) / MASS
        rate = {"held": np.zeros(2), "open": moved}
        if mode == "slip":
            e, size = self.sliding(state)
            rate["slip"] = size * e
        return np.concatenate([state[3:6], bent, rate[mode]])

    def leaves(self, mode):
        """Events that end a state, as zeros that are passed one way."""

        def edge(_, state):
            away, r, *_ = self.contact(state)
            return la.norm(away) - r

        def caught(_, state):
            return self.sliding(state)[1]

        def gap(_, state):
            return self.contact(state)[1]

        closing = 1 if mode == "open" else -1
        events: dict[str, list[tuple[Any, int]]] = {
            "held": [(edge, 1), (gap, closing)],
            "slip": [(caught, -1), (gap, closing)],
            "open": [(gap, closing)],
        }
        for event, direction in events[mode]:
            event.terminal, event.direction = True, direction
        return [event for event, _ in events[mode]]

    def after(self, state, begin, mode):
        """State a period later, from a state that is held or open."""
        t, end = begin, begin + 2 * np.pi / self.omega
        later = {"held": ["slip", "open"], "slip": ["held", "open"], "open": ["held"]}
        while t < end:
            run = self._run(t, end, state, mode)
            t, state = run.t[-1], run.y[:, -1]
            if run.status != 1:
                break
            hit = next(i for i, each in enumerate(run.t_events) if len(each))
            before, mode = mode, later[mode][hit]
            if mode == "open":
                state[6:] = ROWS[1:] @ state[:3]
            if before == "open":
                _, _, moved, grown = self.contact(state)
                if la.norm(moved) > grown:  # the disc's edge is slower: a little later on it
                    short = 1e-8 / self.omega
                    state = state + short * self.rates(t, state, "open")
                    t, mode = t + short, "slip"
                    e = moved / la.norm(moved)
                    state[6:] = ROWS[1:] @ state[:3] - self.contact(state)[1] * e
        return state

    def _run(self, t, end, state, mode):
        def rates(time, values):
            return self.rates(time, values, mode)

        events = self.leaves(mode)
        return solve_ivp(rates, (t, end), state, "DOP853", events=events, rtol=1e-11, atol=1e-13)

    def monodromy(self, state, begin, mode):
        """(8, 8) by central differences; an open slider is where the block is."""
        columns = []
        for i in range(8 if mode == "held" else 6):
            both = []
            for step in (1e-5, -1e-5):
                moved = state.copy()
                moved[i] += step
                if mode == "open":
                    moved[6:] = ROWS[1:] @ moved[:3]
                both.append(self.after(moved, begin, mode))
            columns.append((both[0] - both[1]) / 2e-5)
        matrix = np.array(columns).T
        return matrix[: len(columns)]


def test_what_a_straight_path_remembers_fades_with_the_distance_slipped():
    # Back and forth along one line, r constant: 4 (U - r) slipped a period, η' = -(λ/r) η.
    u = np.zeros((1, 3, 3))
    u[0, :2, :2] = [[1.0, 0.0], [0.0, 1.3]]
    for alpha in (0.9, 1.2):
        law = plane_transfer(u, np.full((1, 2), alpha), 4)
        assert law.memory == pytest.approx([np.exp(-4 * (1.3 - alpha) / alpha)], rel=1e-8)


CASES = {
    "remembers": ((0.3, 0.02j, 0.0), 0.28, 2.0, 0.9, 1.05),
    "slips, the load varies": ((0.5, 0.3 + 0.2j, 0.3), 0.4, 1.2, 0.9, 0.9),
    "opens": ((0.4, 0.3j, 1.3), 0.5, 0.3, 4.0, 2.6),
    "leaves the wave": ((0.4, 0.1j, 1.5), 0.3, 0.3, 4.0, 3.4),
}


@pytest.mark.parametrize("name", CASES)
def test_multipliers_are_those_of_finite_differences_in_time(name):
    push, mu, v0, kn, omega = CASES[name]
    system, opens = block(push, mu, v0, kn), kn > 1
    response = frequency_response(
        system, [omega / (2 * np.pi)], Options(25, friction="isotropic"), find_jumps=False
    )
    assert response.state[0, 0] == (SLIP_OPEN if opens else SLIP)
    found = stability(system, response, harmonics=25, count=20)
    u = to_real(response.contact[0])[0]
    alpha = system.contacts.alpha[0, 0]
    pieces = slider_pieces(u, alpha, grid(25))
    kind = FREE if opens else HELD
    longest = max((p for p in pieces if p[KIND] == kind), key=lambda p: p[END] - p[BEGIN])
    angle = (longest[BEGIN] + longest[END]) / 2
    wave = np.exp(1j * angle * np.arange(26))
    x = sum((response.x[h][0] * wave[h]).real for h in range(26))
    rate = sum((1j * h * omega * response.x[h][0] * wave[h]).real for h in range(26))
    ring, mode = Block(system, omega), "open" if opens else "held"
    start = np.concatenate([x, rate, slider_places(u, alpha, np.array([angle]))[0]])
    if opens:
        start[6:] = ROWS[1:] @ x
    begin = angle / omega
    assert np.abs(ring.after(start, begin, mode) - start).max() < 1e-4
    exact = la.eigvals(ring.monodromy(start, begin, mode))
    law = plane_transfer(u[None], system.contacts.alpha, 2)
    assert len(law.memory) == (0 if opens else 1)
    exact = exact[np.abs(exact) > 0.55]
    given = found.multiplier[0][found.diameter[0] == 0]
    given = np.concatenate([given, given.conj()])
    apart = np.abs(np.subtract.outer(exact, given))
    assert len(exact)
    assert apart.min(axis=1).max() < 1e-5
    assert apart[:, np.abs(given) > 0.56].min(axis=0).max() < 1e-5
    assert found.verdict[0] == (UNSTABLE if np.abs(exact).max() > 1 else STABLE)
