"""Structures that nothing holds: two masses by hand, a bar of the wave equation, a block at rest.

Two masses m₁, m₂ that pull at each other have the motion of their centre of mass and that of
q = x₁ - x₂, which is a mass μ = m₁m₂/(m₁ + m₂) on the same spring under F m₂/(m₁ + m₂):

    x₁ = X + m₂ q / (m₁ + m₂),    x₂ = X - m₁ q / (m₁ + m₂),    X = -F / ω²(m₁ + m₂).
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.nonlinear.systems import solved_response
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    audit_response,
    linear_response,
    stability,
    static_response,
    time_response,
)

ZETA = 0.02


@dataclass(frozen=True)
class Pair:
    """Two masses in kg, their spring and the contact's in N/m, force and largest friction in N."""

    m1: float
    m2: float
    k: float
    kt: float
    force: float
    limit: float

    @property
    def share(self) -> float:
        """m₂ / (m₁ + m₂)."""
        return self.m2 / (self.m1 + self.m2)

    @property
    def mu(self) -> float:
        """μ."""
        return self.m1 * self.share

    def system(self, free: bool, joints: str = "open") -> System:
        """Both masses, or μ alone on the ground."""
        K, M, along = np.array([[self.k]]), np.array([[self.mu]]), np.ones(1)
        force = np.array([self.share * self.force], complex)
        if free:
            along = np.array([1.0, -1.0])
            K, M = self.k * np.outer(along, along), np.diag([self.m1, self.m2])
            force = np.array([self.force, 0.0], complex)
        own = np.zeros((1, 3, len(along)))
        own[0, 1] = along
        kt, unit = np.full((1, 2), self.kt), np.ones(1)
        return System(
            sectors=1,
            engine_order=1,
            diameters={0: Diameter(K=K, M=M, own=own)},
            contacts=Contacts(self.limit * unit, kt, unit, unit),
            force={1: Force(force)},
            damping_ratio=ZETA,
            damping_joints=joints,
        )


@pytest.fixture(params=range(4))
def pair(request: pytest.FixtureRequest) -> Pair:
    """Masses and springs over several decades."""
    rng = np.random.default_rng(request.param)
    m1, m2, k, kt, force = 10 ** rng.uniform([-2, -2, 3, 3, -1], [1, 1, 6, 6, 3])
    stuck = force * m2 / (m1 + m2) * kt / (k + kt)  # friction at low frequency
    return Pair(m1, m2, k, kt, force, stuck * rng.uniform(0.5, 2))


def hertz(pair: Pair, stiffness: float) -> np.ndarray:
    """From far below to far above the resonance, and at it."""
    natural = float(np.sqrt(stiffness / pair.mu)) / (2 * np.pi)
    return np.array([0.01, 0.5, 0.98, 1, 1.03, 4]) * natural


@pytest.mark.parametrize("closed", ["all", "none"])
@pytest.mark.parametrize("joints", ["open", "stuck"])
def test_frequency_response_of_two_masses(pair, joints, closed, below):
    k = pair.k + pair.kt * (closed == "all")
    damped = np.sqrt(pair.mu * (pair.k + pair.kt * (joints == "stuck")))
    f = hertz(pair, k)
    omega = 2 * np.pi * f
    q = pair.share * pair.force / (k - omega**2 * pair.mu + 2j * ZETA * omega * damped)
    centre = -pair.force / (omega**2 * (pair.m1 + pair.m2))
    exact = np.column_stack([centre + pair.share * q, centre - (1 - pair.share) * q])
    found = linear_response(pair.system(True, joints), f, closed)
    error = np.abs(found.x[1] / exact - 1).max()
    below("error", error, 1e-9)


@pytest.mark.parametrize("joints", ["open", "stuck"])
def test_friction_between_two_masses_is_that_of_one_on_the_ground(pair, joints, below):
    free, held = pair.system(True, joints), pair.system(False, joints)
    f = np.sqrt((pair.k + 0.5 * pair.kt) / pair.mu) / (2 * np.pi) * np.linspace(0.8, 1.1, 9)
    a, b = (solved_response(each, f, Options(3)) for each in (free, held))
    assert b.dissipation.max() > 0
    size = np.abs(b.contact).max()
    error = np.abs(a.contact - b.contact).max() / size
    below("contact", error, 1e-8)
    np.testing.assert_allclose(a.dissipation, b.dissipation, rtol=1e-6)
    for h in range(1, 4):  # the centre of mass knows the force alone
        moved = a.x[h] @ [pair.m1, pair.m2]
        exact = -pair.force / (2 * np.pi * f) ** 2 if h == 1 else 0.0
        np.testing.assert_allclose(moved, exact, rtol=1e-8, atol=1e-8 * size * pair.m1)
    audited = audit_response(free, a, [4])
    assert audited.residual.max() < 1e-8
    assert stability(free, a, [4]).verdict == stability(held, b, [4]).verdict
    marched = [
        time_response(each, f[4], 3, steps=512, harmonics=3, start=(start, 4)).x[1]
        for each, start in ((free, a), (held, b))
    ]
    off = abs(marched[0] @ [1, -1] / marched[1][0] - 1)
    below("marched in time", off, 1e-6)
    np.testing.assert_allclose(marched[0] @ [pair.m1, pair.m2], a.x[1][4] @ [pair.m1, pair.m2])


@pytest.mark.parametrize("joints", ["open", "stuck"])
def test_inertia_carries_a_load_at_rest(pair, joints):
    """F on one mass accelerates both by F/(m₁ + m₂); F m₂/(m₁ + m₂) goes through the springs."""
    system = pair.system(True, joints)
    loaded = replace(system, force={0: Force(np.array([0.1 * pair.limit, 0.0], complex))})
    found = static_response(loaded)
    q = pair.share * 0.1 * pair.limit / (pair.k + pair.kt)
    exact = [pair.share * q, -(1 - pair.share) * q]
    np.testing.assert_allclose(found.x[0][0], exact, rtol=1e-9)
    assert audit_response(loaded, found).residual.max() < 1e-9


def bar(elements: int, joint: float) -> System:
    """A bar of unit length, section, modulus and density, in two halves that a contact joins."""
    h = 1 / elements
    K, M = np.zeros((2, elements + 2, elements + 2))
    for i in range(elements):
        at = np.array([i, i + 1]) + (i >= elements // 2)
        K[np.ix_(at, at)] += np.array([[1, -1], [-1, 1]]) / h
        M[np.ix_(at, at)] += h / 6 * np.array([[2, 1], [1, 2]])
    own = np.zeros((1, 3, elements + 2))
    own[0, 0, elements // 2 : elements // 2 + 2] = 1, -1
    unit = np.ones(1)
    return System(
        sectors=1,
        engine_order=1,
        diameters={0: Diameter(K=K, M=M, own=own)},
        contacts=Contacts(joint * unit, np.ones((1, 2)), 0 * unit, unit),
        force={1: Force(np.eye(elements + 2, dtype=complex)[-1])},
        damping_ratio=0.0,
    )


def test_free_bar_shaken_at_its_end(below):
    """u(x) = -cos(ωx) / (ω sin ω), also about its first two resonances at ω = π and 2π."""
    omega = np.array([1e-3, 1.0, 3.0, 3.3, 5.0, 6.2, 6.4])
    found = linear_response(bar(400, 1e9), omega / (2 * np.pi)).x[1]
    exact = -np.cos(omega[:, None] * [0, 1]) / (omega * np.sin(omega))[:, None]
    error = np.abs(found[:, [0, -1]] / exact - 1)
    # elements: (ω/400)²/24 of the frequency, over its distance
    below("largest error", error.max(), 1e-3)


def test_free_bar_pushed_at_its_end(record):
    """At rest the force in the bar is -Fx: u = u(0) - F x²/2, the centre of mass where it was."""
    system = replace(bar(50, 1e3), force={0: Force(-np.eye(52, dtype=complex)[-1])})
    moved = static_response(system).x[0][0]
    x = np.insert(np.linspace(0, 1, 51), 25, 0.5)
    # Half the force is on the contact, which an interference of 1 m drives apart.
    exact = -(x**2) / 2 + (1 - 0.5 / 1e3) * (np.arange(52) > 25)
    error = np.abs(moved - moved[0] - exact).max()
    record("largest error", f"{error:.1e} m")
    assert error < 1e-10
    assert abs((system.at(0).M @ moved).sum()) < 1e-12
