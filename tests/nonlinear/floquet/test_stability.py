"""What `stability` refuses, reports and keeps; isotropic friction against integration in time."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from scipy.integrate import solve_ivp

from tests.nonlinear.forced_response.test_hysteresis import HIGH, LOW
from tests.nonlinear.systems import gap_oscillator, solved_response
from tests.refusals import refused
from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    STABLE,
    UNDECIDED,
    UNSTABLE,
    Contacts,
    Diameter,
    Force,
    Options,
    Stability,
    System,
    frequency_response,
    hysteresis,
    stability,
    static_response,
    stuck_modes,
)
from vanelock.nonlinear.contact.disc_slider import FREE, HELD
from vanelock.nonlinear.contact.disc_slip import BEGIN, END, KIND
from vanelock.nonlinear.contact.isotropic_law import slider_pieces, slider_places
from vanelock.nonlinear.floquet.plane_transfer import plane_transfer
from vanelock.nonlinear.fourier import TURN, grid, to_real


def impact(push=1.0, sectors=1, **more):
    """A mass on two springs, one of which cannot pull, in every sector; the sectors are apart."""
    own = np.array([[[1.0], [0.0], [0.0]]])
    same = Diameter(K=np.eye(1), M=np.eye(1), own=own)
    contacts = Contacts([4.0], [[1.0, 1.0]], [0.0], [0.3])
    diameters = dict.fromkeys(range(sectors // 2 + 1), same)
    return System(sectors, 1, diameters, contacts, {1: Force([push])}, damping_ratio=0.05, **more)


HERTZ = 3.2 / (2 * np.pi)


@pytest.fixture(scope="module")
def wave():
    return frequency_response(impact(), [HERTZ], Options(5))


@pytest.mark.parametrize(("options", "words"), [
    (Options(5, coupling="uncoupled"), "uncoupled, located events"),
    (Options(5, coupling="constant-load"), "constant-load, located events"),
    (Options(5, samples=64), "coupled, 64 samples"),
])  # fmt: skip
def test_other_laws_are_refused(options, words):
    response = frequency_response(impact(), [HERTZ], options)
    refused(f"response: {words}.*: stability is of coupled", stability, impact(), response)


def test_what_does_not_fit_is_refused_in_one_line(wave):
    system = impact()
    for given, words in (
        ((system, static_response(system)), "response: at rest"),
        ((impact(1.1), wave), "response: no solution of this system at 0.509296 Hz: off by"),
        ((system, wave, [1]), "points: given 1: there are 1, counted from 0"),
        ((system, wave, []), "points: given none"),
        ((system, wave, None, 4), "harmonics: given 4: the response has 5 already"),
        ((system, wave, None, None, 0), "count: given 0"),
    ):
        refused(words, stability, *given)


def test_all_nodal_diameters_are_needed():
    system = impact(sectors=6)
    response = frequency_response(system, [HERTZ], Options(1))
    few = replace(system, diameters={k: system.at(k) for k in (0, 1)})
    refused(
        "no matrices for nodal diameters 2, 3: stability needs 0 to 3", stability, few, response
    )


def test_damping_that_couples_modes_is_refused():
    own = [[[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]]
    C = [[0.1, 0.05], [0.05, 0.1]]
    diameters = {0: Diameter(K=np.diag([1.0, 2.0]), M=np.eye(2), own=own, C=C)}
    system = replace(impact(), diameters=diameters, force={1: Force([1.0, 0.0])})
    system = replace(system, damping_ratio=None)
    response = frequency_response(system, [HERTZ], Options(1))
    refused("nd/0/C: given one that couples the modes", stability, system, response)


def test_what_is_reported_is_kept(wave, tmp_path):
    found = stability(impact(), wave, modes={0: stuck_modes(impact(), 0)})
    # The multiplier of the closed form is -1.3503: a period twice as long.
    assert found.verdict.tolist() == [UNSTABLE]
    assert found.growing.tolist() == [1]
    assert found.multiplier[0, 0] == pytest.approx(-1.3503, abs=1e-3)
    np.testing.assert_allclose(found.seen[0, 0] % HERTZ, HERTZ / 2, rtol=1e-5)
    assert found.harmonics.tolist() == [5, 7]
    found.save(tmp_path / "stability.h5")
    again = Stability.load(tmp_path / "stability.h5")
    np.testing.assert_array_equal(again.exponent, found.exponent)
    np.testing.assert_array_equal(again.seen, found.seen)


def test_sectors_apart_have_the_exponents_of_one(wave):
    # In a ring of sectors that know nothing of each other diameters are a matter of phase.
    alone = stability(impact(), wave, count=1)
    for sectors in (2, 3, 4, 5, 6):
        ring = impact(sectors=sectors)
        response = frequency_response(ring, [HERTZ], Options(5))
        found = stability(ring, response, count=2 * sectors)
        grows = found.exponent[0][found.exponent[0].real > 0]
        np.testing.assert_allclose(grows.real, alone.exponent[0, 0].real, rtol=1e-6)
        # In the sectors' own frames each is one with all N others: a motion for each sector.
        either = sum(1 if abs(s.imag) < 1e-6 * HERTZ else 2 for s in grows)
        assert found.growing[0] == len(grows)
        assert either >= sectors


def test_point_that_is_not_solved_is_undecided(wave):
    found = stability(impact(), replace(wave, converged=np.array([False])))
    assert found.verdict.tolist() == [UNDECIDED]
    assert np.isnan(found.exponent).all()
    assert np.isnan(found.growth).all()


def test_truncations_that_differ_leave_it_open():
    # One harmonic of an impact spring knows nothing of how it parts from the wave.
    seen = set()
    for hertz in np.linspace(0.3, 0.6, 16):
        response = frequency_response(impact(), [hertz], Options(1))
        found = stability(impact(), response, harmonics=9)
        both = found.growth[0] > 0
        expected = UNDECIDED if both[0] != both[1] else UNSTABLE if both[0] else STABLE
        assert found.verdict[0] == expected
        seen.add(expected)
    assert seen == {STABLE, UNSTABLE, UNDECIDED}


def test_neutral_motions_are_undecided():
    # No damping, no friction that moves: nothing grows, nothing shrinks.
    system = replace(impact(0.01), damping_ratio=None)
    found = stability(system, frequency_response(system, [0.6], Options(1)))
    assert found.verdict.tolist() == [UNDECIDED]
    np.testing.assert_allclose(np.abs(found.multiplier[0, 0]), 1)


def test_the_branch_between_folds_is_unstable_and_the_others_are_not():
    system = gap_oscillator()
    found = hysteresis(system, (LOW / TURN, HIGH / TURN), Options(3))
    path, (first, second) = found.branch, found.fold
    assert 1 < first < second < path.points - 2
    middle = (first + second) // 2
    chosen = [first // 2, middle, (second + path.points) // 2]
    assert found.unstable[chosen].tolist() == [False, True, False]
    tested = stability(system, path, chosen)
    assert tested.verdict.tolist() == [STABLE, UNSTABLE, STABLE]
    assert abs(tested.exponent[1, 0].imag) < 1e-9 * TURN * path.frequency[middle]
    assert tested.growing.tolist() == [0, 1, 0]


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
    response = solved_response(system, [omega / (2 * np.pi)], Options(25, friction="isotropic"))
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
