"""Damped nonlinear modes against closed forms, linear limits, forced vibration and sweeps."""

from dataclasses import replace
from time import process_time

import numpy as np
import pytest
import scipy.linalg as la
from scipy.interpolate import PchipInterpolator

from tests.conftest import FULL
from tests.nonlinear.systems import jenkins_element, rows, solved_response, stuck_damping
from tests.verification.nonlinear.peaks.test_limit_cycles import SLIP, SPRING, STIFFNESS, one_mass
from tests.verification.nonlinear.spring_rings import MASSES, loaded, spring_ring
from vanelock import rom
from vanelock.nonlinear import STUCK, Options, damped_mode, linear_response
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.fourier import to_complex, to_real
from vanelock.nonlinear.newton.newton import solve
from vanelock.rom.system.system import Contacts, Diameter, Force, System

SEEDS = range(5 if FULL else 2)
C = 0.01
RANGE = (1e-7, 1e-3)
"""Modal amplitudes of the vane, kg^½ m, beyond those of the loads that it is put under."""


def test_one_mass_follows_the_describing_function(record, below):
    system = one_mass()
    damped = {0: replace(system.diameters[0], C=np.diag([C, 0.0]))}
    found = damped_mode(replace(system, diameters=damped), 1, (1e-2, 1e4), Options(1))
    stiffness, _ = jenkins_element(found.amplitude.clip(SLIP / SPRING), SPRING, SLIP)
    omega = np.sqrt(STIFFNESS + stiffness.real)
    ratio = (C + stiffness.imag / omega) / (2 * omega)
    assert not found.ended
    assert found.converged.all()
    frequency = np.abs(2 * np.pi * found.frequency / omega - 1).max()
    damping = np.abs(found.damping_ratio / ratio - 1).max()
    record("points", len(omega))
    below("frequency's difference", frequency, 1e-9)
    below("damping's difference", damping, 1e-8)
    record("largest damping ratio", f"{ratio.max():.4f}")


def linear(system, mode, tangential):
    """Frequency, Hz, and D of singular K + iωC - (ω² + iωξ) M; and D of the complex eigenvalue."""
    k = system.nodal_diameter(1)
    M, B, damping = system.at(k).M, rows(system, k), stuck_damping(system, k)
    stiffness = system.contacts.stiffness * [1.0, tangential, tangential]
    own = system.at(k).K + (B.conj().T * stiffness.reshape(-1)) @ B
    omega = np.sqrt(la.eigh(own, M, eigvals_only=True)[mode - 1])
    for _ in range(50):
        values = la.eigvals(own + 1j * omega * damping, M)
        value = values[np.argmin(np.abs(values - omega**2))]
        omega = np.sqrt(value.real)
    n, lower = len(own), -la.solve(M, np.hstack([own, damping]))
    first = np.vstack([np.eye(n, 2 * n, n), lower])
    roots = la.eigvals(first)
    root = roots[np.argmin(np.abs(roots - 1j * omega))]
    return omega / (2 * np.pi), value.imag / (2 * omega**2), -root.real / abs(root)


@pytest.mark.parametrize("seed", SEEDS)
def test_small_amplitudes_stick_and_large_ones_slide(seed, record, below):
    system = spring_ring(seed)
    options = Options(3 if FULL else 1, coupling="constant-load")
    small, large, aside, folds = 0.0, 0.0, 0.0, 0
    for mode in range(1, MASSES + 1) if FULL else (1 + seed,):
        found = damped_mode(system, mode, (1e-4, 1e9), options)
        assert not found.ended
        assert found.converged.all()
        folds += int(np.count_nonzero(np.diff(np.sign(np.diff(found.amplitude)))))
        for point, tangential in ((0, 1.0), (-1, 0.0)):
            frequency, damping, of_root = linear(system, mode, tangential)
            error = max(
                abs(found.frequency[point] / frequency - 1),
                abs(found.damping_ratio[point] / damping - 1),
            )
            small, large = (max(small, error), large) if point == 0 else (small, max(large, error))
            aside = max(aside, abs(of_root / damping - 1))
    below("stuck", small, 1e-6)
    below("sliding", large, 1e-6)
    record("turning points", folds)
    record("damping ratio of the complex eigenvalue", f"{aside:.1e} aside")


def separated(force):
    """Three masses in a row, friction on the first; the second mode is 2.8 times as fast."""
    K3 = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    rows = np.zeros((1, 3, 4))
    rows[0, 0, 3] = rows[0, 1, 0] = 1.0
    contacts = Contacts(np.ones(1), np.full((1, 2), 0.15), np.full(1, 0.5), np.full(1, 0.08))
    output = np.zeros((1, 3, 4))
    output[0, 0, 2] = 1.0
    diameter = Diameter(K=la.block_diag(K3, 1.0), M=np.eye(4), own=rows, output=output)
    push = np.array([0.0, 0.0, force, 0.0], complex)
    return System(1, 1, {0: diameter}, contacts, {1: Force(push)}, ("tip",), 0.01)


def in_its_place(system, found, i, excitation):
    """The system under the self-excitation of a point as an external force."""
    omega = 2 * np.pi * found.frequency[i]
    xi = 2 * found.damping_ratio[i] * omega
    force = {h: each for h, each in system.force.items() if h == 0}
    for h, x in found.response.x.items():
        if h == 1 or (h and excitation == "all"):
            force[h] = Force(1j * h * omega * xi * system.at(system.nodal_diameter(h)).M @ x[i])
    return replace(system, force=force)


@pytest.mark.parametrize("excitation", ["all", "fundamental"])
@pytest.mark.parametrize("seed", SEEDS if FULL else SEEDS[:1])
def test_a_force_in_its_place_keeps_up_the_same_motion(seed, excitation, record, below):
    system, options = spring_ring(seed), Options(3)
    worst, again, count, same = 0.0, 0.0, 0, 0
    law = options.law(system.contacts)(3)
    for mode in range(1, MASSES + 1) if FULL else (1, 2):
        found = damped_mode(system, mode, options=options, self_excitation=excitation)
        assert not found.ended
        assert found.converged.all()
        response = found.response
        for i in range(0, len(found.amplitude), 7 if FULL else 14):
            forced, omega = (
                in_its_place(system, found, i, excitation),
                2 * np.pi * response.frequency[i],
            )
            size, count = np.abs(response.contact[i, 1:]).max(), count + 1
            w = to_real(response.contact[i] - response.force[i] / response.stiffness)
            near = solve(fixed(structure(forced, 3).balance(omega), law), w, 0.0)
            assert near.converged
            apart = np.abs(to_complex(near.u) - response.contact[i])[1:].max() / size
            worst = max(worst, apart)
            swept = solved_response(forced, [response.frequency[i]], options)
            apart = np.abs(swept.contact[0] - response.contact[i])[1:].max() / size
            if apart < 1e-3:  # else another solution under the same force
                same, again = same + 1, max(again, apart)
    below("difference", worst, 1e-8)
    record("found without a start", f"{same} of {count}")
    below("difference of these", again, 1e-7)
    assert same > 0.5 * count


def synthesised(found, force, output):
    """Excitation frequencies, Hz, and amplitudes of one mode alone under a force on its shape.

    (ω² - Ω² + 2iDωΩ) a = φᴴf for the two Ω of each amplitude.
    """
    every = np.log(found.amplitude)
    fine = np.linspace(every[0], every[-1], 100_000)  # of a smooth mode: its points are far apart
    modal = np.abs(found.shape.conj() @ force) / found.amplitude
    drawn = (2 * np.pi * found.frequency, found.damping_ratio, modal, output)
    omega, ratio, modal, output = (PchipInterpolator(every, each)(fine) for each in drawn)
    p = omega**2 * (1 - 2 * ratio**2)
    root = p**2 - omega**4 + modal**2
    some = root >= 0
    sides = []
    for sign in (-1, 1):
        square = p + sign * np.sqrt(root, where=some, out=np.zeros_like(root))
        there = some & (square > 0)
        sides.append((np.sqrt(square[there]) / (2 * np.pi), output[there]))
    (low, rising), (high, falling) = sides
    hertz, size = np.concatenate([low, high[::-1]]), np.concatenate([rising, falling[::-1]])
    order = np.argsort(hertz)
    return hertz[order], size[order]


def top_of(found, force, node, direction):
    """Frequency, Hz, and height of the peak of a mode alone."""
    hertz, size = synthesised(found, force, found.response.amplitude[:, node, direction])
    return hertz[size.argmax()], size.max()


def half_power(hertz, size):
    """Half-power bandwidth of a peak, Hz."""
    above = hertz[size >= size.max() / np.sqrt(2)]
    return above[-1] - above[0]


def compared(system, found, node, direction, record):
    """Height, shift of the peak and largest difference of the curves: a mode alone and a sweep.

    The bound of a load on the mode itself: the height, and the curve down to 70 % of it, within
    e = 3 %, as one mode alone leaves out what others add. A top that is e lower moves by √(e/2) of
    the half-power bandwidth at most: 12 %.
    """
    output = found.response.amplitude[:, node, direction]
    hertz, size = synthesised(found, system.force[1].vector, output)
    near = size > 0.3 * size.max()
    low, high = hertz[near].min(), hertz[near].max()
    swept = solved_response(system, np.linspace(low, high, 241), Options(found.response.harmonics))
    curve = swept.amplitude[:, node, direction]
    width = half_power(swept.frequency, curve)
    height = size.max() / curve.max() - 1
    shift = (hertz[size.argmax()] - swept.frequency[curve.argmax()]) / width
    top = curve > 0.7 * curve.max()
    drawn = np.interp(swept.frequency[top], hertz, size)
    aside = np.abs(drawn / curve[top] - 1).max()
    slips = np.interp(size.max(), output, found.damping_ratio) / found.damping_ratio[0]
    record("height", f"{height:+.2%}")
    record("peak's shift", f"{shift:+.1%} of the half-power bandwidth")
    record("curve above 70 % of it", f"{aside:.2%}")
    record("damping at the peak / stuck", f"{slips:.1f}")
    return abs(height), abs(shift), aside


@pytest.mark.parametrize("force", [0.01, 0.05])
def test_one_mode_alone_draws_its_resonance(force, record):
    system = separated(force)
    found = damped_mode(system, 1, (1e-3, 1e2), Options(3))
    assert not found.ended
    height, shift, aside = compared(system, found, 0, 0, record)
    assert height < 0.03
    assert shift < np.sqrt(0.03 / 2)
    assert aside < 0.03


def others(system, hertz, node, direction, mode):
    """What all modes but one add at a frequency, all contacts stuck, m."""
    stuck = linear_response(system, [hertz])
    frequencies, shapes = rom.linear_modes(system, 1, mode)
    phi, own, omega = shapes[:, -1], 2 * np.pi * frequencies[-1], 2 * np.pi * hertz
    dynamic = own**2 - omega**2 + 2j * system.damping_ratio * own * omega
    moved = phi * (phi.conj() @ system.force[1].vector) / dynamic
    return abs(system.at(1).output[node, direction] @ (stuck.x[1][0] - moved))


def largest_output(found):
    """Output node and direction that move most."""
    size = found.response.amplitude.max(axis=0)
    return np.unravel_index(size.argmax(), size.shape)


@pytest.mark.parametrize("force", [0.3])
def test_one_mode_alone_draws_the_vanes_resonance_under_a_force_on_it(scene, force, record):
    system = loaded(scene.system, force)
    found = damped_mode(system, 2, RANGE, Options(1))
    assert not found.ended
    stuck = found.shape[0]
    along = system.at(1).M @ stuck * np.abs(stuck.conj() @ system.force[1].vector)
    system = replace(system, force={1: Force(along)})
    node, direction = largest_output(found)
    height, shift, aside = compared(system, found, node, direction, record)
    assert height < 0.03
    assert shift < np.sqrt(0.03 / 2)
    assert aside < 0.03


@pytest.mark.parametrize("force", [0.3] if FULL else [0.1, 0.5])
def test_under_the_vanes_own_load_it_misses_what_other_modes_add(scene, force, record):
    """The bound counts what other modes add to the output, as if friction did not notice them.

    So 0.3 is not of the small vane's sample: there they move the contacts by 31 % of the mode's own
    motion, where damping changes most, and one mode alone is 6.4 % too high, not 5.6 %. With others
    to first order the curve is 7.0 % lower, as the balance has it.
    """
    system = loaded(scene.system, force)
    found = damped_mode(system, 2, RANGE, Options(1))
    node, direction = largest_output(found)
    height, shift, _ = compared(system, found, node, direction, record)
    peak, size = top_of(found, system.force[1].vector, node, direction)
    more = others(system, peak, node, direction, 2) / size
    record("other modes", f"{more:.1%} of the peak")
    assert height < 0.03 + more
    assert shift < np.sqrt((0.03 + more) / 2)


MANY = [(0, 1, 5), (1, 1, 5), (2, 1, 5), (8, 1, 5), (0, 3, 2), (1, 3, 4), (8, 3, 2)]
WAVES = MANY if FULL else [(1, 1, 2)]


def unbalanced(system, found, opens):
    """Work that friction and damping take out in a period over that of self-excitation, less 1.

    πωξ a² = ΣW + Σ_h πh²ω q_hᴴ C q_h, C that of the modes with some contacts open, others stuck.
    """
    stiffness = np.where(opens[:, None], 0.0, system.contacts.stiffness).reshape(-1)
    omega, taken = 2 * np.pi * found.frequency, found.response.dissipation.sum(axis=1)
    for h, x in found.response.x.items():
        if h:
            k = system.nodal_diameter(h)
            matrices = system.at(k)
            B = system.contact_rows(k).reshape(len(stiffness), -1)
            omega2, V = la.eigh(matrices.K + (B.conj().T * stiffness) @ B, matrices.M)
            rate = 2 * system.damping_ratio * np.sqrt(omega2.clip(0))
            size = np.abs(x @ (matrices.M @ V).conj()) ** 2
            taken = taken + np.pi * h**2 * omega * (size @ rate)
    put = 2 * np.pi * omega**2 * found.damping_ratio * found.amplitude**2
    return np.abs(taken / put - 1).max()


@pytest.mark.parametrize(("nodal_diameter", "harmonics", "count"), WAVES)
def test_the_vanes_modes_are_found_from_stuck_to_gross_slip(
    scene, nodal_diameter, harmonics, count, record
):
    system, options = replace(scene.system, damping_joints="open"), Options(harmonics)
    texts, points, work, begun = [], 0, 0.0, process_time()
    for mode in range(1, count + 1):
        found = damped_mode(system, mode, None, options, nodal_diameter)
        assert not found.ended
        assert found.converged.all()
        assert found.residual.max() < 1e-10
        assert np.all(found.response.state[0] == STUCK)
        assert not np.any(found.response.state[-1][scene.interlock] == STUCK)
        np.testing.assert_allclose(found.frequency[0], found.linear[0], rtol=1e-4)
        turned = replace(system, engine_order=nodal_diameter)
        work = max(work, unbalanced(turned, found, scene.interlock))
        hertz, most = found.frequency[[0, -1]], found.damping_ratio.max()
        texts.append(f"{hertz[0]:.1f} to {hertz[1]:.1f} Hz, at most {most:.4f}")
        points += len(found.amplitude)
    record("modes", "; ".join(texts))
    record("points", points)
    record("work put in and taken out", f"{work:.1e} apart")
    record("CPU", f"{process_time() - begun:.0f} s")
    assert work < 1e-6
