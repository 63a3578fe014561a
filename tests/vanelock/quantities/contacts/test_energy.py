"""Energy balance, damping ratios and wear indicators against oscillators and loops by hand."""

import numpy as np
import pytest

from vanelock import nonlinear
from vanelock.nonlinear import Contacts, Diameter, Force, System
from vanelock.quantities.contacts import (
    EnergyBalance,
    _half_power,
    _travel,
    balance,
    bandwidth_ratio,
    wear,
)

ZETA, K, M = 0.02, 4e6, 1.0
F = np.sqrt(K / M) / (2 * np.pi)
MU, KT, LOAD = 0.3, 1e5, 40.0


def slid(force, spring, mass, kt, mu, load, **more):
    """A mass on a spring with a contact at its side, which a spring of its own loads evenly."""
    own = np.zeros((1, 3, 2))
    own[0, 0, 1] = own[0, 1, 0] = 1
    matrices = Diameter(np.diag([spring, 1e6]), np.diag([mass, 1e-9]), own)
    v0 = np.array([2 * load / 1e6])
    contacts = Contacts(np.array([1e6]), np.array([[kt, kt]]), np.array([mu]), v0)
    return System(1, 0, {0: matrices}, contacts, {1: Force(np.array([force + 0j, 0]))}, **more)


def oscillator(force):
    """Its damping ratio is ζ with the contact stuck."""
    return slid(force, K - KT, M, KT, MU, LOAD, damping_ratio=ZETA)


def test_linear_oscillator_at_resonance_has_its_own_damping_ratio():
    system = oscillator(1.0)
    response = nonlinear.linear_response(system, [F])
    found = balance(system, response)
    X = 1.0 / (2 * ZETA * K)
    assert found.stored == pytest.approx(0.5 * K * X**2)
    assert found.input == pytest.approx(np.pi * X)
    assert found.damping_ratio == pytest.approx(ZETA)
    assert found.friction == 0
    assert found.viscous == pytest.approx(found.input)


def test_linear_curve_has_its_damping_ratio_by_bandwidth():
    system = oscillator(1.0)
    hertz = np.linspace(0.8 * F, 1.2 * F, 2001)
    curve = nonlinear.linear_response(system, hertz)
    amplitude = np.abs(curve.x[1][:, 0])
    # Where |H|² is half its largest value: r² = 1 - 2ζ² ± 2ζ√(1 - ζ²), so nearly ζ.
    r = [np.sqrt(1 - 2 * ZETA**2 + s * 2 * ZETA * np.sqrt(1 - ZETA**2)) for s in (-1, 1)]
    assert _half_power(hertz, amplitude) == pytest.approx([F * each for each in r], rel=1e-5)
    assert bandwidth_ratio(hertz, amplitude) == pytest.approx(ZETA, rel=2e-3)


def test_friction_and_viscous_work_are_those_of_the_motion():
    system = oscillator(50.0)
    hertz = np.linspace(0.97 * F, F, 61)
    response = nonlinear.frequency_response(system, hertz, nonlinear.Options(5))
    point = int(np.abs(response.x[1][:, 0]).argmax())
    found = balance(system, response, point)
    assert found.friction > 0.01 * found.input
    # Viscous work of the mass alone: π c ω |hX_h|² with c = 2 ζ √(K M).
    omega = 2 * np.pi * response.frequency[point]
    c = 2 * ZETA * np.sqrt(K * M)
    speed = sum((h * abs(response.x[h][point, 0])) ** 2 for h in range(1, 6))
    assert found.viscous == pytest.approx(np.pi * c * omega * speed, rel=1e-6)
    # Friction by Jenkins' loop: 4 μn (U - μn/kt), U from the motion.
    angle = 2 * np.pi * np.arange(2000) / 2000
    u = sum((response.x[h][point, 0] * np.exp(1j * h * angle)).real for h in range(1, 6))
    U = np.ptp(u) / 2
    assert found.friction == pytest.approx(4 * MU * LOAD * (U - MU * LOAD / KT), rel=1e-3)


def test_a_lost_point_beside_the_peak_leaves_no_bandwidth():
    f = np.linspace(90, 110, 401)
    a = 1 / np.hypot(1 - (f / 100) ** 2, 2 * 0.01 * f / 100)
    assert bandwidth_ratio(f, a) == pytest.approx(0.01, rel=2e-3)
    inside, outside = a.copy(), a.copy()
    inside[np.abs(f - 100.5).argmin()] = np.nan
    outside[np.abs(f - 105).argmin()] = np.nan
    assert np.isnan(bandwidth_ratio(f, inside))
    assert bandwidth_ratio(f, outside) == bandwidth_ratio(f, a)
    assert np.isnan(bandwidth_ratio(f, 1 + 1e-3 * a))  # falls to no half of its power


def test_nothing_that_vibrates_has_no_damping_ratio():
    assert np.isnan(EnergyBalance(0.0, 0.0, 0.0, 0.0).damping_ratio)
    assert EnergyBalance(1.0, 0.7, 0.3, 2.0).damping_ratio == pytest.approx(1 / (8 * np.pi))


SPRING, TANGENT, FRICTION, N = 4e5, 2e6, 0.4, 50.0


def jenkins(force):
    """Dragged slowly, at rest with the contact."""
    return slid(force, SPRING, 1e-9, TANGENT, FRICTION, N)


@pytest.fixture(scope="module")
def loop():
    """Exact loop of a slider dragged by U cos θ at constant load: displacement, force."""
    U = 5 * FRICTION * N / TANGENT
    angle = 2 * np.pi * np.arange(4096) / 4096
    u, w = U * np.cos(angle), np.empty(4096)
    play = FRICTION * N / TANGENT
    place = U - play  # after a first quarter it is at the lower bound
    for i, each in enumerate(np.concatenate([u, u])):
        place = min(max(place, each - play), each + play)
        w[i % 4096] = place
    displacement = np.column_stack([np.full(4096, 1e-5), u, np.zeros(4096)])
    force = np.column_stack([np.full(4096, N), TANGENT * (u - w), np.zeros(4096)])
    return U, displacement, force


def test_slip_counts_in_the_plane_and_while_the_contact_is_closed(loop):
    """Of a Jenkins element it is four times what exceeds its play."""
    U, displacement, force = loop
    stiffness = np.array([1e6, TANGENT, TANGENT])
    slip = _travel(displacement, force, stiffness)
    assert slip == pytest.approx(4 * (U - FRICTION * N / TANGENT), rel=1e-5)
    both, pushed, opened = displacement.copy(), force.copy(), force.copy()
    both[:, 1:] = displacement[:, [1]] * [0.6, 0.8]
    pushed[:, 1:] = force[:, [1]] * [0.6, 0.8]
    assert _travel(both, pushed, stiffness) == pytest.approx(slip)
    opened[:2048] = 0
    assert _travel(displacement, opened, stiffness) == pytest.approx(slip / 2, rel=1e-2)


def test_solved_response_dissipates_what_its_slider_travels_under_load():
    response = nonlinear.frequency_response(jenkins(60.0), [10.0], nonlinear.Options(9))
    assert response.converged.all()
    found = wear(response, np.array([2e-6]), np.array([1e-15]))
    assert found.slip[0] > 0
    assert found.work[0] == pytest.approx(N * found.slip[0], rel=1e-4)
    # By hand: at constant load the slider travels 4 (U - μn/kt) and dissipates μn times that.
    U = np.ptp(nonlinear.contact_loop(response, 0, 0)[0][:, 1]) / 2
    assert found.slip[0] == pytest.approx(4 * (U - FRICTION * N / TANGENT), rel=1e-3)
    assert found.mean_load[0] == found.largest_load[0] == pytest.approx(N)
    assert found.mean_pressure[0] == pytest.approx(N / 2e-6)
    assert found.slip_per_hour[0] == pytest.approx(found.slip[0] * 36000)
    assert found.depth_per_hour[0] == pytest.approx(1e-15 * found.work[0] * 36000 / 2e-6)


def test_stuck_contact_travels_nowhere_and_sampled_friction_has_no_exact_slip():
    response = nonlinear.frequency_response(jenkins(1.0), [10.0], nonlinear.Options(3))
    unknown = np.full(1, np.nan)
    found = wear(response, unknown, unknown)
    assert found.slip[0] == found.work[0] == found.energy[0] == 0
    assert np.isnan(found.energy_per_area[0])
    assert np.isnan(found.volume_per_hour[0])
    response = nonlinear.frequency_response(
        jenkins(60.0), [10.0], nonlinear.Options(3, samples=256)
    )
    found = wear(response, unknown, unknown)
    assert np.isnan(found.slip[0])
    assert found.work[0] == found.energy[0] / FRICTION > 0
