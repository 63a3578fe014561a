"""Rings whose sectors all deviate alike, the ways to a point, and what is refused."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import even, with_contacts
from tests.verification.nonlinear.spring_rings import (
    CONTACTS,
    MASSES,
    RINGS,
    assembled,
    loaded,
    spring_ring,
    springs,
    worst_of,
)
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Mistuning,
    Options,
    SectorModes,
    frequency_response,
    ring_modes,
    ring_response,
    whitehead,
)
from vanelock.nonlinear.forced_response.ring.ring_response import _RingSolver


def damped(seed, kind):
    """A ring, damped in proportion to its mass, and the frequency of its peak."""
    _, force, frequency = worst_of(seed)[kind]
    system = loaded(spring_ring(seed), force)
    diameters = {k: replace(each, C=0.03 * each.M) for k, each in system.diameters.items()}
    return replace(system, diameters=diameters, damping_ratio=None), frequency


def own_modes(seed):
    """Two modes of the masses of a sector between walls, and the rows of the first."""
    K0, _, M0, *_ = springs(seed)
    modes = SectorModes.of_part(spring_ring(seed), K0, M0, np.eye(MASSES), 2)
    return modes, modes.rows[0].real


@pytest.mark.parametrize("friction", ["orthogonal", "isotropic"])
@pytest.mark.parametrize(("seed", "kind"), [(0, "slip"), (4, "lift")])
def test_sectors_that_deviate_alike_are_another_wave(seed, kind, friction):
    system, frequency = damped(seed, kind)
    system = even(system) if friction == "isotropic" else system
    contacts, N = system.contacts, system.sectors
    rng = np.random.default_rng(seed)
    more = {name: rng.uniform(-0.2, 0.2, CONTACTS) for name in ("mu", "kn", "kt", "interference")}
    slider, shift = rng.normal(0, 0.2, (CONTACTS, 2)), np.array([0.04, -0.03])
    modes, g = own_modes(seed)
    stiffer = (g.T * (modes.stiffness * ((1 + shift) ** 2 - 1))) @ g
    diameters = {k: replace(each, K=each.K + stiffer) for k, each in system.diameters.items()}
    changed = with_contacts(
        replace(system, diameters=diameters),
        kn=contacts.kn * (1 + more["kn"]),
        kt=contacts.kt * (1 + more["kt"][:, None]),
        mu=contacts.mu * (1 + more["mu"]),
        v0=contacts.v0 + more["interference"],
        slider=slider,
    )
    hertz = frequency + np.array([-0.01, 0.0, 0.01])
    options = Options(5, friction=friction, tolerance=1e-11)
    one = frequency_response(changed, hertz, options, find_jumps=False)
    asked = {name: np.tile(more[name], (N, 1)) for name in ("interference", "mu", "kn")}
    asked |= {"kt": np.tile(more["kt"][:, None], (N, 1, 2)), "slider": np.tile(slider, (N, 1, 1))}
    mistuning = Mistuning(N, **asked, frequency=np.tile(shift, (N, 1)), modes=modes)
    ring = ring_response(system, hertz, mistuning, options)
    assert one.converged.all()
    assert ring.converged.all()
    lag = np.exp(-2j * np.pi * np.outer(np.arange(6), np.arange(N)) * system.engine_order / N)
    for of in ("contact", "force", "output"):
        own = getattr(one, of)[:, :, None]
        expected = lag[:, :, None, None] * own
        apart = np.abs(getattr(ring, of) - expected).max()
        assert apart < 1e-9 * np.abs(own).max()
    np.testing.assert_array_equal(ring.state, np.repeat(one.state[:, None], N, axis=1))
    work = np.repeat(one.dissipation[:, None], N, axis=1)
    np.testing.assert_allclose(ring.dissipation, work, rtol=1e-8, atol=1e-9 * work.max())
    assert np.abs(ring.amplification - 1).max() > 0.01


def imbalance(seed, system, mistuning, found):
    """What is left of the equations of motion of the whole ring, its matrices and its forces."""
    N, order = RINGS[seed % len(RINGS)]
    K, M, B, _, C = assembled(seed)
    if system.damping_joints == "open":
        omega2, V = la.eigh(K, M)
        C = M @ (V * (0.03 * np.sqrt(omega2))) @ V.T @ M
    if mistuning.modes is not None:
        g, k = mistuning.modes.rows[0].real, mistuning.modes.stiffness
        own = [(g.T * (k * ((1 + shift) ** 2 - 1))) @ g for shift in mistuning.frequency]
        K = K + la.block_diag(*own)
    lag = np.exp(-2j * np.pi * order * np.arange(N) / N)
    omega, worst = 2 * np.pi * found.frequency[0], 0.0
    push = np.kron(lag, system.force[1].vector)
    for h in range(found.contact.shape[1]):
        x = found.output[0, h].reshape(-1)  # all masses
        inertia = (K - (h * omega) ** 2 * M + 1j * h * omega * C) @ x
        left = inertia + B.T @ found.force[0, h].reshape(-1) - (push if h == 1 else 0)
        worst = max(worst, np.abs(left).max() / np.abs(push).max())
    return worst


@pytest.mark.parametrize(
    ("seed", "kind", "damped_open"), [(0, "slip", False), (4, "lift", False), (4, "lift", True)]
)
def test_forces_move_the_ring_as_its_assembled_matrices_say(seed, kind, damped_open):
    _, force, frequency = worst_of(seed)[kind]
    system = loaded(spring_ring(seed), force)
    modes = None
    asked = {"contact": dict.fromkeys(("interference", "mu", "kn", "kt"), 0.3)}
    if damped_open:
        system, modes = replace(system, damping_joints="open"), own_modes(seed)[0]
        asked["modes"] = {"frequency": 0.02}
    mistuning = Mistuning.scatter(system, asked, seed, modes)
    found = ring_response(system, [frequency], mistuning, Options(7))
    assert found.converged.all()
    assert found.amplification.max() > 1.05
    assert imbalance(seed, system, mistuning, found) < 1e-9


def test_range_is_sampled_and_its_peak_located():
    system, frequency = damped(0, "slip")
    asked = {"contact": {"interference": 0.2, "mu": 0.2}}
    mistuning = Mistuning.scatter(system, asked, 1)
    limits = (frequency - 0.03, frequency + 0.03)
    reported = []
    found = ring_response(
        system, limits, mistuning, Options(1), lambda *each: reported.append(each)
    )
    assert found.converged.all()
    assert reported[-1][0] == reported[-1][1]
    top = np.unravel_index(found.amplitude.argmax(), found.amplitude.shape)
    beside = found.frequency[top[0]] + np.array([-1e-4, 0.0, 1e-4])
    near = ring_response(system, beside, mistuning, Options(1)).amplitude[:, top[1], top[2], top[3]]
    assert near.max() < found.amplitude[top] * (1 + 1e-4)
    largest = found.amplitude.max(axis=0) / found.alike
    np.testing.assert_array_equal(found.amplification, largest)


def test_deviations_are_raised_where_newton_fails(monkeypatch):
    _, force, frequency = worst_of(4)["lift"]
    system = loaded(spring_ring(4), force)
    asked = {"contact": dict.fromkeys(("interference", "mu", "kn", "kt"), 0.2)}
    mistuning, options = Mistuning.scatter(system, asked, 2), Options(5)
    plain = ring_response(system, [frequency], mistuning, options)
    solved, parts = _RingSolver._solved, list[float]()

    def hindered(self, omega, part, *more):
        found = solved(self, omega, part, *more)
        far = part - (parts[-1] if parts else 0.0) > 0.3
        if far:
            return replace(found, converged=False)
        parts.append(part)
        return found

    monkeypatch.setattr(_RingSolver, "_solved", hindered)
    found = ring_response(system, [frequency], mistuning, options)
    assert parts[0] == 0.0
    assert parts[-1] == 1.0
    assert all(0 < b - a <= 0.3 for a, b in pairwise(parts))
    assert found.converged.all()
    assert found.iterations[0] > plain.iterations[0]
    np.testing.assert_allclose(found.output, plain.output, atol=1e-8 * np.abs(plain.output).max())


def test_what_is_not_found_is_flagged():
    _, force, frequency = worst_of(4)["lift"]
    system = loaded(spring_ring(4), force)
    mistuning = Mistuning.scatter(system, {"contact": {"mu": 0.1}}, 2)
    found = ring_response(system, [frequency], mistuning, Options(3, tolerance=1e-30, effort=1))
    assert not found.converged.any()
    assert np.isnan(found.alike).all()
    assert np.isnan(found.amplification).all()


@pytest.mark.parametrize("own", [False, True])
def test_rings_share_modes_to_the_same_bits(own):
    system, frequency = damped(0, "slip")
    modes = own_modes(0)[0] if own else None
    shift = np.linspace(-0.02, 0.02, 2 * system.sectors).reshape(-1, 2)
    shared = ring_modes(system, modes).diameters
    for seed in range(2):
        mistuning = Mistuning.scatter(system, {"contact": {"mu": 0.1}}, seed, modes)
        mistuning = replace(mistuning, frequency=shift) if own else mistuning
        found, alone = (
            ring_response(system, [frequency], mistuning, Options(3), shared=each)
            for each in (shared, None)
        )
        assert found.converged.all()
        assert np.array_equal(found.amplitude, alone.amplitude)


def test_alike_ring_without_contacts_moving():
    system = loaded(spring_ring(0), 1e-3)
    found = ring_response(system, [0.2, 0.3], Mistuning(system.sectors), Options(1))
    np.testing.assert_allclose(found.amplification, 1.0, rtol=1e-12)
    assert found.contact.shape[:2] == (2, 2)
    assert whitehead(16) == 2.5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (Options(coupling="uncoupled"), "coupling: given 'uncoupled'"),
        (Options(harmonic_diameters="sector"), "harmonic_diameters: given 'sector'"),
        (Options(static_beyond=3.0), "static_beyond: given 3.0"),
        (Options(0), "harmonics: given 0: the system has force/1; needs at least 1"),
    ],
)
def test_impossible_options_are_refused(options, message):
    system = spring_ring(0)
    with pytest.raises(InputError) as refused:
        ring_response(system, [0.2], Mistuning(system.sectors), options)
    assert message in str(refused.value)


def test_missing_diameters_and_rows_are_refused():
    system = spring_ring(0)
    fewer = {k: each for k, each in system.diameters.items() if k < 2}
    with pytest.raises(InputError, match="a mistuned ring"):
        ring_response(replace(system, diameters=fewer), [0.2], Mistuning(5), Options(1))
    modes, _ = own_modes(0)
    short = SectorModes({k: g for k, g in modes.rows.items() if k < 2}, modes.stiffness)
    mistuning = Mistuning(5, frequency=np.zeros((5, 2)), modes=short)
    with pytest.raises(InputError, match="mistuning.modes: rows of nodal diameter 2: given none"):
        ring_response(system, [0.2], mistuning, Options(1))
    wide = SectorModes(dict.fromkeys(range(3), np.eye(2, MASSES + 1) + 0j), modes.stiffness)
    mistuning = Mistuning(5, frequency=np.zeros((5, 2)), modes=wide)
    with pytest.raises(InputError, match=r"given shape \(2, 4\): needs \(2, 3\)"):
        ring_response(system, [0.2], mistuning, Options(1))
