"""Mistuned rings: what is drawn, scaled and refused, and the assembled matrices."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import even, with_contacts
from tests.refusals import refused
from tests.verification.nonlinear.spring_rings import (
    MASSES,
    RINGS,
    assembled,
    loaded,
    spring_ring,
    springs,
    worst_ring,
)
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contacts,
    Element,
    Mistuning,
    Options,
    SectorModes,
    ring_modes,
    ring_response,
    whitehead,
)
from vanelock.nonlinear.forced_response.ring.ring_response import _RingSolver
from vanelock.nonlinear.forced_response.ring.ring_source import ring_contacts


def damped(seed, kind):
    """A ring, damped in proportion to its mass, and the frequency of its peak."""
    system, frequency = worst_ring(seed, kind)
    diameters = {k: replace(each, C=0.03 * each.M) for k, each in system.diameters.items()}
    return replace(system, diameters=diameters, damping_ratio=None), frequency


def own_modes(seed):
    """Two modes of the masses of a sector between walls, and the rows of the first."""
    K0, _, M0, *_ = springs(seed)
    modes = SectorModes.of_part(spring_ring(seed), K0, M0, np.eye(MASSES), 2)
    return modes, modes.rows[0].real


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


@pytest.mark.parametrize(("seed", "kind", "damped_open", "friction"), [
    (0, "slip", False, "orthogonal"), (4, "lift", False, "orthogonal"),
    (4, "lift", True, "orthogonal"), (4, "lift", True, "isotropic"),
])  # fmt: skip
def test_forces_move_the_ring_as_its_assembled_matrices_say(seed, kind, damped_open, friction):
    system, frequency = worst_ring(seed, kind)
    system, modes = even(system) if friction == "isotropic" else system, None
    asked = {"contact": dict.fromkeys(("interference", "mu", "kn", "kt"), 0.3)}
    if damped_open:
        system, modes = replace(system, damping_joints="open"), own_modes(seed)[0]
        asked["modes"] = {"frequency": 0.02}
    mistuning = Mistuning.scatter(system, asked, seed, modes)
    found = ring_response(system, [frequency], mistuning, Options(7, friction=friction))
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
    system, frequency = worst_ring(4, "lift")
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
    system, frequency = worst_ring(4, "lift")
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


@pytest.mark.parametrize(("options", "message"), [
    (Options(coupling="uncoupled"), "coupling: given 'uncoupled'"),
    (Options(harmonic_diameters="sector"), "harmonic_diameters: given 'sector'"),
    (Options(static_beyond=3.0), "static_beyond: given 3.0"),
    (Options(0), "harmonics: given 0: the system has force/1; needs at least 1"),
])  # fmt: skip
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


ALL = ("interference", "mu", "kn", "kt", "slider")


def two_joints(sectors=400):
    """Many sectors, whose two contacts are of two joints."""
    system = spring_ring(0)
    kt, joints = [[1.0, 4.0], [2.0, 2.0]], ("hook", "interlock")
    contacts = Contacts([2.0, 3.0], kt, [0.3, 0.5], [0.1, -0.2], joints)
    return replace(system, sectors=sectors, contacts=contacts)


def two_modes():
    """Two modes of three coordinates."""
    return SectorModes(dict.fromkeys(range(3), np.eye(2, 3, dtype=complex)), np.array([1.0, 2.0]))


def test_deviations_are_normal_of_the_size_asked_for():
    system = two_joints()
    found = Mistuning.scatter(system, {"hook": dict.fromkeys(ALL, 0.1)}, seed=3)
    shares = {
        "interference": found.interference[:, 0] / 0.1,
        "mu": found.mu[:, 0],
        "kn": found.kn[:, 0],
        "kt": found.kt[:, 0, 0],
        "slider": found.slider[:, 0, 0] / (0.3 * 2.0 / 1.0 * 0.1),
        "slider 2": found.slider[:, 0, 1] / (0.3 * 2.0 / 4.0 * 0.1),
    }
    for share in shares.values():
        assert abs(share.mean()) < 4 * 0.1 / 20  # standard error of 400
        assert abs(share.std() / 0.1 - 1) < 4 / np.sqrt(800)
    between = np.corrcoef(list(shares.values())) - np.eye(6)
    assert np.abs(between).max() < 4 / 20
    np.testing.assert_array_equal(found.kt[:, 0, 0], found.kt[:, 0, 1])
    for name in ALL:
        assert not getattr(found, name)[:, 1].any()


def test_contacts_of_a_ring_are_those_of_its_sectors_in_turn():
    system = two_joints(4)
    mistuning = Mistuning.scatter(system, {"hook": dict.fromkeys(ALL, 0.1)}, seed=5).of(system)
    ring, alike = ring_contacts(system.contacts, mistuning).contacts, system.contacts
    for j in range(4):
        own = slice(2 * j, 2 * j + 2)
        np.testing.assert_allclose(ring.slider[own], alike.slider + mistuning.slider[j])
        np.testing.assert_allclose(ring.v0[own], alike.v0 + mistuning.interference[j])
        for name in ("mu", "kn", "kt"):
            expected = getattr(alike, name) * (1 + getattr(mistuning, name)[j])
            np.testing.assert_allclose(getattr(ring, name)[own], expected)
    assert len({*ring.slider.ravel()}) == 9  # eight drawn, and those of the interlock


def test_same_seed_draws_the_same_ring():
    system = two_joints(12)
    asked = {"hook": {"mu": 0.1, "kn": 0.1}, "interlock": {"interference": 0.2}}
    turned = {"interlock": {"interference": 0.2}, "hook": {"kn": 0.1, "mu": 0.1}}
    one, same = Mistuning.scatter(system, asked, 5), Mistuning.scatter(system, turned, 5)
    other = Mistuning.scatter(system, asked, 6)
    for name in ALL:
        np.testing.assert_array_equal(getattr(one, name), getattr(same, name))
    assert not np.array_equal(one.mu, other.mu)


def test_modes_are_drawn_each_by_itself_and_sliders_of_gaps_are_not():
    found = Mistuning.scatter(two_joints(), {"modes": {"frequency": 0.02}}, 1, two_modes())
    assert found.frequency.shape == (400, 2)
    assert np.abs(found.frequency.std(axis=0) / 0.02 - 1).max() < 4 / np.sqrt(800)
    assert abs(np.corrcoef(found.frequency.T)[0, 1]) < 4 / 20
    assert not Mistuning.scatter(two_joints(12), {"interlock": {"slider": 0.3}}).slider.any()


def test_one_mode_of_a_part_is_shifted_and_no_other():
    rng = np.random.default_rng(0)
    half = rng.normal(size=(6, 4))
    K, M = half @ half.T, np.diag(rng.uniform(0.5, 2, 6))  # two motions are held by nothing
    modes = SectorModes.of_part(two_joints(8), K, M, np.eye(6), 3)
    before = la.eigvalsh(K, M)
    shift = np.array([0.0, 0.04, 0.0])
    g = modes.rows[4].real
    stiffer = (g.T * (modes.stiffness * ((1 + shift) ** 2 - 1))) @ g
    after = la.eigvalsh(K + stiffer, M)
    expected = before * np.array([1, 1, 1, 1.04, 1, 1]) ** 2
    np.testing.assert_allclose(after, np.sort(expected), atol=1e-12 * before[-1])
    assert sorted(modes.rows) == [0, 1, 2, 3, 4]
    with pytest.raises(InputError, match="modes: given 5: the part has 4"):
        SectorModes.of_part(two_joints(8), K, M, np.eye(6), 5)
    refused("do not fit", SectorModes.of_part, two_joints(8), K, M, np.eye(5, 6), 1)


def test_parts_and_its_file(tmp_path):
    asked = {"hook": dict.fromkeys(ALL, 0.1), "modes": {"frequency": 0.1}}
    whole = Mistuning.scatter(two_joints(12), asked, 2, two_modes())
    whole.save(tmp_path / "ring.h5")
    read = Mistuning.load(tmp_path / "ring.h5")
    for name in (*ALL, "frequency"):
        value = getattr(whole, name)
        np.testing.assert_array_equal(getattr(whole.share(0.25), name), 0.25 * value)
        np.testing.assert_array_equal(getattr(read, name), value)
    assert read.modes is not None
    np.testing.assert_array_equal(read.modes.rows[2], np.eye(2, 3))


@pytest.mark.parametrize(("asked", "message"), [
    ({"hub": {"mu": 0.1}}, "mistuning: given 'hub': known are hook, interlock"),
    ({"hook": {"E": 0.1}}, "mistuning: hook.E: allowed: interference, kn, kt, mu, slider"),
    ({"hook": {"mu": -0.1}}, "mistuning: hook.mu: given -0.1: must be >= 0"),
    ({"hook": {"mu": float("nan")}}, "mistuning: hook.mu: given nan: must be >= 0"),
    (Mistuning(11), "mistuning: of 11 sectors: the system has 12"),
    (Mistuning(12, mu=np.zeros((12, 3))), "mistuning.mu: given shape (12, 3): needs (12, 2)"),
    (Mistuning(12, kn=np.full((12, 2), np.nan)), "mistuning.kn: holds values that are not finite"),
    (Mistuning(12, mu=np.full((12, 2), -1.5)), "mistuning.mu: given -1.5: relative, must be >= -1"),
    (Mistuning(12, kn=np.full((12, 2), -1.0)), "mistuning.kn: given -1: relative, must be > -1"),
    (Mistuning(12, frequency=np.zeros((12, 1)), modes=two_modes()),
     "mistuning.frequency: given shape (12, 1): needs (12, 2)"),
    (Mistuning(12, frequency=np.zeros((12, 1))),
     "mistuning.frequency: given shape (12, 1): needs (12, 0)"),
])  # fmt: skip
def test_what_is_impossible_or_does_not_fit_is_refused(asked, message):
    system = two_joints(12)
    given = asked.of if isinstance(asked, Mistuning) else lambda one: Mistuning.scatter(one, asked)
    with pytest.raises(InputError) as refused:
        given(system)
    assert str(refused.value) == message


def test_elements_have_no_friction_to_deviate():
    element = Element(force="cubic_spring", places=[0], parameters=[1.0])
    system, mu = with_contacts(two_joints(12), elements={1: element}), np.zeros((12, 2))
    mu[:, 0] = 0.1
    Mistuning(12, mu=mu).of(system)
    mu[3, 1] = 0.1
    refused("mistuning.mu: elements follow laws of their own", Mistuning(12, mu=mu).of, system)
