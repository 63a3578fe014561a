"""Floquet exponents of waves against eigenvalues, closed forms, and rings followed in time."""

from dataclasses import replace
from functools import lru_cache, partial
from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg as la
from scipy.optimize import fsolve

from tests.conftest import FULL
from tests.nonlinear.systems import rows as contact_rows
from tests.nonlinear.systems import solved_response, stuck_damping, stuck_stiffness
from tests.verification.nonlinear.kicked_ring import parting, refined
from tests.verification.nonlinear.spring_rings import (
    FollowedRing,
    assembled,
    spring_ring,
    worst_of,
    worst_ring,
)
from tests.verification.vane import interlocked
from vanelock import fem, mesh, rom
from vanelock.nonlinear import (
    STABLE,
    STUCK,
    UNSTABLE,
    Options,
    System,
    frequency_response,
    stability,
    stuck_modes,
)
from vanelock.nonlinear.floquet.exponents import zeros
from vanelock.nonlinear.floquet.perturbation import PerturbedStructure, law_transfer
from vanelock.nonlinear.fourier import to_real
from vanelock.rom.system.system import Contacts, Diameter, Force
from vanelock.stages.parts.segment import Joint, Segment


@pytest.mark.parametrize("seed", range(24 if FULL else 3))
def test_ring_that_sticks_has_the_eigenvalues_of_its_matrices(seed, below):
    frequency = 0.3
    response = frequency_response(spring_ring(seed, 1e-3), [frequency], Options(5))
    assert np.all(response.state == STUCK)
    found = stability(spring_ring(seed, 1e-3), response, count=100)
    omega = 2 * np.pi * frequency
    K, M, B, stiffness, C = assembled(seed)
    n = len(K)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [K + (B.T * stiffness) @ B, C]])
    A[n:] = -la.solve(M, A[n:])
    exact = la.eigvals(A)
    exact = exact[exact.real > -0.1 * omega]
    exact = exact.real + 1j * ((exact.imag + omega / 2) % omega - omega / 2)
    exponent = found.exponent[0][found.diameter[0] >= 0]
    either = np.concatenate([exponent, exponent.conj()])
    apart = np.abs(np.subtract.outer(exact, either)) / omega
    below("apart", apart.min(axis=1).max(), 1e-10)
    assert apart.min(axis=0).max() < 1e-10
    assert len(exponent) >= len(exact) / 2
    assert found.verdict[0] == STABLE


def moved(spring, centre, mass, damping, push, omega, state, begin, end):
    """State (x, x') of a mass on a spring about `centre`, under a cosine, from one instant on."""

    def steady(t):
        q = push / (spring - mass * omega**2 + 1j * omega * damping) * np.exp(1j * omega * t)
        return np.array([centre + q.real, (1j * omega * q).real])

    A = np.array([[0, 1], [-spring / mass, -damping / mass]])
    return steady(end) + la.expm(A * (end - begin)) @ (state - steady(begin))


@pytest.mark.parametrize("omega", [1.4, 2.0, 2.6, 3.2] if FULL else [3.2])
def test_mass_on_an_impact_spring_in_closed_form(omega, record, below):
    # Two springs, one of which cannot pull: the motion and the growth of what is beside it are
    # matrix exponentials, one after the other; forces are continuous, and nothing jumps between.
    k, kn, mass, ratio, v0, push = 1.0, 4.0, 1.0, 0.05, 0.3, 1.0
    own = np.array([[[1.0], [0.0], [0.0]]])
    system = System(
        sectors=1,
        engine_order=1,
        diameters={0: Diameter(K=np.array([[k]]), M=np.array([[mass]]), own=own)},
        contacts=Contacts(np.array([kn]), np.ones((1, 2)), np.zeros(1), np.array([v0])),
        force={1: Force(np.array([push], complex))},
        damping_ratio=ratio,
    )
    harmonics = 161 if FULL else 101
    response = frequency_response(system, [omega / (2 * np.pi)], Options(harmonics))
    found = stability(system, response, harmonics=harmonics)
    damping, period = 2 * ratio * np.sqrt((k + kn) * mass), 2 * np.pi / omega
    common = mass, damping, push, omega

    def left(unknown):
        opens, rate, closes = unknown
        middle = moved(k, 0, *common, np.array([-v0, rate]), opens, closes)
        centre = -kn * v0 / (k + kn)
        end = moved(k + kn, centre, *common, middle, closes, opens + period)
        return [middle[0] + v0, end[0] + v0, end[1] - rate]

    t = np.linspace(0, period, 2001)
    turning = np.exp(1j * omega * np.outer(t, np.arange(harmonics + 1)))
    v = (turning @ response.contact[0, :, 0, 0]).real
    opens, closes = (t[:-1][np.diff(np.sign(v)) == sign][0] for sign in (-2, 2))
    rate = np.interp(opens, t, np.gradient(v, t))
    opens, rate, closes = fsolve(
        left, [opens, rate, closes + period * (closes < opens)], xtol=1e-13
    )
    assert np.abs(left([opens, rate, closes])).max() < 1e-11
    free = [
        la.expm(np.array([[0, 1], [-spring / mass, -damping / mass]]) * span)
        for spring, span in ((k, closes - opens), (k + kn, period - closes + opens))
    ]
    exact = la.eigvals(free[1] @ free[0])
    exact = exact[np.abs(exact) > 0.6]
    given = found.multiplier[0][found.diameter[0] == 0]
    apart = np.abs(np.subtract.outer(exact, np.concatenate([given, given.conj()]))).min(axis=1)
    record("multipliers", ", ".join(f"{value:.4f}" for value in exact))
    below("apart", apart.max(), 1e-8)
    assert found.verdict[0] == (UNSTABLE if np.abs(exact).max() > 1 else STABLE)
    assert found.growing[0] == (np.abs(exact) > 1).sum()  # here all are real


@pytest.mark.parametrize("seed", range(24) if FULL else (1, 0))
def test_rings_against_finite_differences_of_their_motion(seed, record, below):
    _, force, frequency = worst_of(seed)["lift"]
    system = spring_ring(seed, force)
    response = frequency_response(system, [frequency], Options(25))
    found = stability(system, response, harmonics=25, count=100)
    shift = (system.engine_order % system.sectors) / system.sectors
    steps = 1200 if FULL else 300 if shift > 0.5 else 600  # of a sector's turn
    ring = FollowedRing(seed, force, frequency, steps * system.sectors)
    there = found.diameter[0] >= 0
    s, n = found.exponent[0][there] / (2 * np.pi * frequency), found.diameter[0][there]
    given = np.exp(2 * np.pi * (s * shift - 1j * n / system.sectors))
    standing = (2 * n % system.sectors == 0) & (np.abs(s.imag) < 1e-9)
    given = np.concatenate([given, given[~standing].conj()])
    exact = la.eigvals(ring.derivative(response))
    size, apart = np.abs(exact) ** (1 / shift), np.abs(np.log(np.divide.outer(exact, given)))
    kept = size > 0.6
    # What is off in a whole period, of each and of none but these.
    off = (size[:, None] * apart / shift).min(axis=1)[kept]
    assert (apart / shift).min(axis=0)[np.abs(given) ** (1 / shift) > 0.6].max() < 2e-3
    largest = np.abs(exact).max() ** (1 / shift)
    record("largest multiplier", f"{largest:.5f}")
    record("by exponents", f"{np.abs(found.multiplier[0][0]):.5f}")
    record("motions", int(kept.sum()))
    below("apart", off.max(), 1e-3)
    if abs(largest - 1) > 1e-3:
        assert found.verdict[0] == (UNSTABLE if largest > 1 else STABLE)


MEASURED = {1: 1.0706, 0: 0.752, 4: 0.940}
"""Of rings followed by the program and by central differences, period by period."""


@pytest.mark.parametrize("seed", MEASURED if FULL else (1, 0))
@pytest.mark.parametrize("harmonics", [3, 9])
def test_few_harmonics_predict_what_rings_do(seed, harmonics, record):
    system, frequency = worst_ring(seed, "lift")
    response = frequency_response(system, [frequency], Options(harmonics))
    found = stability(system, response)
    largest = float(np.abs(found.multiplier[0, 0]))
    record("largest multiplier", f"{largest:.5f}")
    assert largest == pytest.approx(MEASURED[seed], abs=1e-3)
    assert found.verdict[0] == (UNSTABLE if largest > 1 else STABLE)


EDGE = 0.51  # of Im s: motions that turn over each period lie at 1/2


def turns_of_determinant(system, u, frequency, diameter, harmonics):
    """How often det[I - Γ(s) R(s)] turns round zero along Re s = 0 and 3, |Im s| = EDGE."""
    contacts, omega = system.contacts, 2 * np.pi * frequency
    law = law_transfer(u, (contacts.mu * contacts.kn)[:, None] / contacts.kt, harmonics)
    order = np.arange(-harmonics, harmonics + 1)
    stiffness = contacts.stiffness.reshape(-1)[law.components]
    matrices, rows, poles = [], [], []
    for k in (diameter + order * system.engine_order) % system.sectors:
        B, K, M = contact_rows(system, int(k)), stuck_stiffness(system, int(k)), system.at(int(k)).M
        C, pull = stuck_damping(system, int(k)), B[law.components].conj().T * stiffness
        matrices.append((K, C, M, pull))
        rows.append((B[law.components], B[law.partners[1]]))
        poles.append(np.sqrt(la.eigvalsh(K, M)) / omega)
    K, C, M, pull = (np.array(each) for each in zip(*matrices, strict=True))
    own, normal = (np.array(each) for each in zip(*rows, strict=True))

    def determinant(s):
        z = omega * (s + 1j * order)[:, None, None]
        x = np.linalg.solve(K + z * C + z**2 * M, pull)
        pairs = zip(law.at(s).parts, (own, normal), strict=True)
        blocks = sum(part[:, :, None] * (b @ x).transpose(1, 2, 0)[:, None] for part, b in pairs)
        size = len(law.components) * len(order)
        return np.linalg.slogdet(np.eye(size) - blocks.reshape(size, size))[0]

    corners = np.array([1j * EDGE, -1j * EDGE, 3 - 1j * EDGE, 3 + 1j * EDGE, 1j * EDGE])
    total = 0.0
    # Along the imaginary axis poles of what is hardly damped are near, and zeros beside them.
    heights = np.array(poles).T - order, -np.array(poles).T - order
    spread = system.damping_ratio * np.array([-30, -10, -3, -1, -0.3, 0, 0.3, 1, 3, 10, 30])
    beside = (np.add.outer(EDGE - np.concatenate(heights), spread) / (2 * EDGE)).ravel()
    for i, (begin, end) in enumerate(pairwise(corners)):
        t = list(np.linspace(0, 1, 201))
        if i == 0:
            t = sorted({*t, *beside[(beside > 0) & (beside < 1)]})
        elif i != 2:  # denser near the axis
            t = [share**2 if i == 1 else 1 - (1 - share) ** 2 for share in t]
        found = [determinant(begin + share * (end - begin)) for share in t]
        j = 0
        while j + 1 < len(t):
            turned = np.angle(found[j + 1] / found[j])
            if abs(turned) > 0.7 and t[j + 1] - t[j] > 1e-9:
                t.insert(j + 1, (t[j] + t[j + 1]) / 2)
                found.insert(j + 1, determinant(begin + t[j + 1] * (end - begin)))
                continue
            total += turned
            j += 1
    return round(total / (2 * np.pi))


def test_as_many_grow_as_the_determinant_turns(record):
    counts = []
    for seed in range(500 if FULL else 6):
        rng = np.random.default_rng(seed)
        system = spring_ring(seed, 10 ** rng.uniform(0, 1.5))
        system = replace(system, damping_ratio=10 ** rng.uniform(-4, -2))
        frequency = rng.uniform(0.1, 0.45)
        response = frequency_response(system, [frequency], Options(3))
        u, N = to_real(response.contact[0]), system.sectors
        modes = {k: stuck_modes(system, k) for k in range(N)}
        n, omega = int(rng.integers(N // 2 + 1)), 2 * np.pi * frequency
        structure = partial(PerturbedStructure, system, modes, n, omega, 5)
        alpha = (system.contacts.mu * system.contacts.kn)[:, None] / system.contacts.kt
        _, pairs, complete = zeros(structure, law_transfer(u, alpha, 5))
        assert complete, seed
        growing = np.array([s.real > 0 and abs(s.imag) < EDGE for s, _ in pairs], bool)
        assert growing.sum() == turns_of_determinant(system, u, frequency, n, 5), seed
        counts.append(int(growing.sum()))
    record("random systems", len(counts))
    record("with growing motions", sum(count > 0 for count in counts))
    record("growing motions", sum(counts))
    assert sum(counts) > 0


@pytest.fixture(scope="module")
def vane(request):
    """The coarse vane's system, roots sharp, with all nodal diameters of its ring."""
    if not FULL:
        return request.getfixturevalue("ring_of_vanes")
    coarse = request.getfixturevalue("coarse")
    steel = fem.Material(E=170e9, nu=0.3, rho=8200)
    sharp = mesh.vane_segment(mesh.VaneDimensions(root_fillet=0.0), size="coarse")
    segment, casing = (fem.assemble(part, steel) for part in (sharp, coarse[1]))
    shared = ("hook_front", "hook_rear", "key", "output")
    joints = (
        Joint("hook", kn=1.67e7, kt=1.67e7, mu=0.3, interference=20e-6),
        Joint("interlock", kn=1e6, kt=1e6, mu=0.15, interference=2e-6),
    )
    return Segment(joints, 1, force=30.0, damping_ratio=0.003).join(
        rom.reduce(segment, (*shared, "interlock_left", "interlock_right")),
        rom.reduce(casing, (*shared, "force"), modes=10, nodal_diameters=range(9)),
    )


@pytest.fixture(scope="module")
def at_peak(vane):
    """Function that finds a peak with few harmonics, and its stability, once for each."""

    @lru_cache
    def find(mu, interference, load):
        system = interlocked(vane, mu, 1e-6 * interference, load)
        near = (250.0, 285.0) if FULL else (263.0, 299.0)
        response = solved_response(system, near, Options(HARMONICS))
        peak = int(response.amplitude[:, 0].max(axis=1).argmax())
        finer = 5 if FULL or load == 1 else 3  # the less load, the fewer
        return system, response, peak, stability(system, response, [peak], finer)

    return find


@pytest.fixture(scope="module")
def in_time(at_peak):
    """Function that follows the ring at such a peak in time, once for each.

    Of the motion that is predicted to grow most: what a period multiplies it by, and its frequency.
    """

    @lru_cache
    def follow(mu, interference, load):
        system, response, peak, tested = at_peak(mu, interference, load)
        frequency, sectors = float(response.frequency[peak]), system.sectors
        wave = refined(system, response, peak, WAVE)
        steps, periods = (256, 60) if FULL else (128, 12)
        found = parting(system, wave, periods, steps, INERTIA, FAR)
        # By its nodal diameter and frequency: others may grow beside it.
        turn = 2j * np.pi * int(tested.diameter[0, 0])
        expected = np.exp((tested.exponent[0, 0] / frequency - turn) / sectors)
        values = found.eigenvalues(len(found.departure) // 2)
        nearest = values[np.abs(values - expected).argmin()]
        turned = float(np.angle(nearest / expected)) * sectors / (2 * np.pi)
        return wave, found, float(np.abs(nearest) ** sectors), turned

    return follow


def test_vane_at_full_load_leaves_its_wave(vane, at_peak, in_time, record):
    # What a period multiplies departures from the wave by, of the ring followed in time.
    measured = 1.774 if FULL else in_time(*PEAKS[0])[2]
    if FULL:
        response = frequency_response(vane, (255.0, 280.0), Options(1))
        frequency = [response.frequency[response.amplitude[:, 0].max(axis=1).argmax()]]
        responses = {H: frequency_response(vane, frequency, Options(H)) for H in (3, 9)}
        tested = {H: stability(vane, response) for H, response in responses.items()}
    else:
        tested = {HARMONICS: at_peak(*PEAKS[0])[-1]}
    for H, found in tested.items():
        largest = float(np.abs(found.multiplier[0, 0]))
        record(f"H = {H}", f"{largest:.4f} a period, nodal diameter {found.diameter[0, 0]}")
        assert largest == pytest.approx(measured, abs=5e-3)
        assert found.diameter[0, 0] == 7
        assert found.verdict[0] == UNSTABLE


HARMONICS = 3 if FULL else 2
"""H of the wave beside which more harmonics predict the growth."""
WAVE = 25 if FULL else 15
"""H of the same wave, from which rings set out: so near the true one that growth shows for long."""
INERTIA = 60  # modes of each nodal diameter that keep their inertia
FAR = 5e-3  # departure up to which what grows is small
# Friction of the interlock, its interference in micrometres, and load as a factor of 30 N.
PEAKS = [
    (0.15, 2, 1), (0.6, 1, 0.5), (0.1, 2, 0.5), (0.3, 2, 0.5), (0.2, 5, 1),
    (0.1, 2, 0.25), (0.06, 10, 1), (0.2, 2, 0.2), (0.1, 20, 1), (0.05, 2, 0.1),
]  # fmt: skip
"""Chosen before any was followed in time. A sample takes the first and the last: with its few
harmonics the verdict of the one before is not decided."""


@pytest.mark.parametrize(("mu", "interference", "load"), PEAKS if FULL else PEAKS[::9])
def test_vane_in_time_stays_or_leaves_as_predicted(
    at_peak, in_time, mu, interference, load, record
):
    system, response, peak, tested = at_peak(mu, interference, load)
    frequency = float(response.frequency[peak])
    verdict, n = tested.verdict[0], int(tested.diameter[0, 0])
    both = ", ".join(f"{size:.4f}" for size in np.exp(tested.growth[0] / frequency))
    record("peak", f"{frequency:.2f} Hz")
    record("verdict", ("stable", "unstable", "undecided")[verdict])
    few, more = (int(each) for each in tested.harmonics)
    record(f"at H = {few} and {more}", f"{both} a period, nodal diameter {n}")
    wave, found, measured, turned = in_time(mu, interference, load)
    again = refined(system, response, peak, more)  # those of the verdict
    apart = np.abs(wave.contact[0, 1] - again.contact[0, 1]).max()
    assert apart < 0.05 * np.abs(wave.contact[0, 1]).max()
    half = len(found.departure) // 2
    grown = found.size[-1] / found.size[half]
    record("periods", len(found.departure))
    record("departure", f"{found.departure[0]:.1e} to {found.departure[-1]:.1e}")
    record("kick in the second half", f"times {grown:.2g}")
    assert found.unsolved == 0
    if verdict == STABLE:
        assert found.departure.max() < 1e-3
        assert grown < 1
    if verdict == UNSTABLE:
        size = float(np.abs(tested.multiplier[0, 0]))
        record("measured", f"{measured:.4f} a period, {measured / size - 1:+.1%}")
        record("frequency", f"{turned:+.4f} of the excitation's from the estimate")
        assert found.departure[-1] > FAR or size < 1.15
        assert abs(turned) < 0.02
        assert abs(measured - size) < 0.03 * size
        assert abs(measured - size) < 0.15 * (size - 1) + 1e-3  # where it is near 1
