"""Time integration of the ring: its accuracy, isotropic friction, and what a ring settles at."""

from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.nonlinear.systems import (
    PLANE_PATHS,
    even,
    planar,
    random_system,
    solved_response,
    with_contacts,
)
from tests.refusals import refused
from tests.verification.nonlinear.spring_rings import (
    CONTACTS,
    MASSES,
    assembled,
    loaded,
    spring_ring,
    worst_of,
    worst_ring,
)
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    MODULATED,
    SLIP,
    SLIP_OPEN,
    STEADY,
    UNSETTLED,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    settled_response,
    stability,
    time_response,
)
from vanelock.nonlinear.transient.settled_response import _verdict


def single(mu, force, v0):
    """A mass on a spring of 1 N/m that slides on the ground, and one that bounces."""
    one = {0: Diameter(K=np.eye(2), M=np.eye(2), own=np.array([[[0, 1], [1, 0.3], [0, 0]]]))}
    contacts = Contacts([1.0], [[0.8, 0.8]], [mu], [v0])
    return System(1, 0, one, contacts, {1: Force([force, 0.3 * force])}, damping_ratio=0.03)


@pytest.mark.parametrize("v0", [1.0, 0.1, -0.1])
def test_error_falls_with_the_square_of_the_step(v0):
    # Where in a step a state changes scatters the error; the order shows over many steps.
    system, steps = single(0.4, 0.5, v0), np.array([50, 100, 200, 400, 800, 1600])
    exact = time_response(system, 0.17, 30, 12800).contact
    found = [time_response(system, 0.17, 30, int(count)).contact for count in steps]
    errors = np.array([np.abs(each - exact).max() for each in found]) / np.abs(exact[1]).max()
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] < -1.7
    assert errors[3] < 5e-5


def test_missing_diameters_are_named():
    system = random_system(1, sectors=7, harmonics=1)
    refused("nodal diameters 2, 3", time_response, system, 0.1)


def test_what_the_integration_does_not_know_is_refused():
    system = single(0.4, 0.5, 0.1)
    response = frequency_response(system, [0.17, 0.2], Options(3))
    for start, message in (
        ((response, 2), "given point 2: the response has 2"),
        ((response, 1), "given a point at 0.2 Hz: needs one at 0.17 Hz"),
        ((replace(response, friction="isotropic"), 0), "needs one with orthogonal"),
        ((replace(response, harmonic_diameters=np.array([0, 0, 0, 1])), 0), "nodal diameters"),
    ):
        refused(message, time_response, system, 0.17, start=start)
    matrices = replace(system.at(0), C=np.array([[0.1, 0.05], [0.05, 0.1]]))
    with pytest.raises(InputError, match="nd/0/C: given one that couples the modes"):
        time_response(replace(system, diameters={0: matrices}), 0.17)
    refused("steps: given 30: allowed: 40 or more", time_response, system, 0.17, steps=30)


def test_linear_ring_is_in_its_steady_state_at_once():
    # So much preload and friction that all sticks: the motion is the balance's, nothing to settle.
    system = random_system(3, preload=1e3, mu=50.0, sectors=6, engine_order=-1, harmonics=5)
    response = frequency_response(system, [0.3], Options(2))
    found = time_response(system, 0.3, 2, 64, 2)
    assert found.defect.max() < 1e-12
    lag = np.exp(2j * np.pi * np.arange(6) / 6)[:, None, None]
    for name in ("contact", "force", "output"):
        given, expected = getattr(found, name), getattr(response, name)[0]
        for h in range(3):
            scale = np.abs(expected[:2]).max()
            assert np.abs(given[h] - lag**h * expected[h]).max() < 1e-10 * scale
    for h in range(3):
        assert np.abs(found.x[h] - response.x[h][0]).max() < 1e-10 * np.abs(response.x[1]).max()


HERTZ, RATIO = 1.05 / (2 * np.pi), 0.03


@pytest.mark.parametrize(("swing", "v0", "shake", "state"), PLANE_PATHS)
def test_steady_states_are_those_of_the_balance(swing, v0, shake, state):
    system, counts = planar(swing, 0.6, v0, shake, RATIO), np.array([128, 256, 512, 1024])
    balance = frequency_response(system, [HERTZ], Options(41, friction="isotropic"))
    each = frequency_response(system, [HERTZ], Options(41))
    exact = balance.contact[0, :21]
    scale, errors = np.abs(exact[1]).max(), []
    for steps in counts:
        found = time_response(system, HERTZ, 60, int(steps), 20, friction="isotropic")
        assert found.unsolved == 0
        assert found.defect[-1] < 1e-10
        assert found.state[0, 0] == balance.state[0, 0] == state
        errors.append(np.abs(found.contact[:, 0] - exact).max() / scale)
        np.testing.assert_allclose(
            found.dissipation[0], balance.dissipation[0], rtol=3 * (32 / steps) ** 2
        )
    assert errors[-1] < 1e-5
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] < -1.5
    # Friction bounded in each direction by itself is another law.
    assert np.abs(each.contact[0, :21] - exact).max() > 1e3 * errors[-1] * scale
    begun = time_response(system, HERTZ, 2, 1024, 20, (balance, 0), friction="isotropic")
    assert begun.departure.max() < 5e-5


def test_sectors_of_a_ring_repeat_the_wave():
    system = random_system(4, size=8, contacts=2, preload=2.0, sectors=5, damping_ratio=0.03)
    system = even(system)
    hertz, errors = 0.16, []
    balance = frequency_response(system, [hertz], Options(15, friction="isotropic"))
    assert {SLIP, SLIP_OPEN} & set(balance.state[0])
    lag = np.exp(-2j * np.pi * np.outer(np.arange(16), np.arange(5)) / 5)[..., None, None]
    for steps in (256, 1024):
        found = time_response(
            system, hertz, 60, steps, 15, (balance, 0), 1e-9, friction="isotropic"
        )
        apart = np.abs(found.contact - lag * balance.contact[0][:, None]).max()
        errors.append(apart / np.abs(balance.contact[0, 1]).max())
    assert errors[0] < 1e-3
    assert errors[1] < 0.2 * errors[0]


def test_a_start_has_the_law_that_is_followed():
    system = planar(0.7j, 0.6, 2.0, 0.0, RATIO)
    response = frequency_response(system, [HERTZ], Options(1))
    with pytest.raises(InputError, match="with orthogonal friction.*needs one with isotropic"):
        time_response(system, HERTZ, start=(response, 0), friction="isotropic")
    with pytest.raises(InputError, match="friction: given 'round': allowed: orthogonal, isotropic"):
        time_response(system, HERTZ, friction="round")
    uneven = with_contacts(system, kt=np.array([[1.0, 2.0]]))
    refused("contact 0 has kt", time_response, uneven, HERTZ, friction="isotropic")


SEED, N = 0, 5


def sector(order, v0, harmonics):
    """A ring's sector under loads in three harmonics."""
    system, rng = spring_ring(SEED), np.random.default_rng(103)
    force = {
        0: Force(0.1 * rng.normal(size=MASSES)),
        1: system.force[1],
        2: Force(0.3 * rng.normal(size=MASSES)),
    }
    force = {h: f for h, f in force.items() if h <= harmonics}
    system = replace(system, engine_order=order, force=force)
    return with_contacts(system, v0=np.full(CONTACTS, v0))


def whole(one):
    """The same ring with every sector's coordinates and contacts, no symmetry used."""
    K, M, B, *_ = assembled(SEED)
    lag = np.exp(-2j * np.pi * one.engine_order * np.arange(N) / N)
    force = {h: Force(np.kron(lag**h, f.vector)) for h, f in one.force.items()}
    given = one.contacts
    kt, others = np.tile(given.kt, (N, 1)), (np.tile(x, N) for x in (given.mu, given.v0))
    contacts = Contacts(np.tile(given.kn, N), kt, *others)
    diameter = Diameter(K, M, B.reshape(-1, 3, N * MASSES))
    return System(1, 0, {0: diameter}, contacts, force, damping_ratio=one.damping_ratio)


@pytest.mark.parametrize(("harmonics", "order", "v0"), [
    (1, 1, 4.0), (4, 1, 0.5), (3, -1, 0.5), (3, 2, 0.5), (1, 5, 1.0), (3, 5, 1.0)
])  # fmt: skip
def test_sector_balance_is_the_rings(order, v0, harmonics):
    one = sector(order, v0, harmonics)
    hertz = np.array([0.12, 0.21])
    mine, ring = (
        solved_response(system, hertz, Options(harmonics)) for system in (one, whole(one))
    )
    assert np.any(np.isin(mine.state, (SLIP, SLIP_OPEN)))
    lag = np.exp(-2j * np.pi * order * np.arange(N) / N)
    scale = np.abs(mine.x[1]).max()
    for h in range(harmonics + 1):
        expected = np.concatenate([mine.x[h] * lag[j] ** h for j in range(N)], axis=1)
        assert np.abs(ring.x[h] - expected).max() < 1e-7 * scale
    np.testing.assert_array_equal(ring.state, np.tile(mine.state, N))
    work = N * mine.dissipation.sum(axis=1)
    np.testing.assert_allclose(ring.dissipation.sum(axis=1), work, rtol=1e-7)


def test_one_diameter_for_all_harmonics_is_another_structure():
    # The wave's own diameters reproduce the ring; that of the first harmonic for all does not.
    one, hertz = sector(1, 0.5, 2), [0.17, 0.21]
    wave = frequency_response(one, hertz, Options(5))
    same = frequency_response(one, hertz, Options(5, harmonic_diameters="sector"))
    np.testing.assert_array_equal(wave.harmonic_diameters, [0, 1, 2, 3, 4, 0])
    np.testing.assert_array_equal(same.harmonic_diameters, [0, 1, 1, 1, 1, 1])
    assert same.converged.all()
    assert np.abs(same.x[2] - wave.x[2]).max() > 0.05 * np.abs(wave.x[2]).max()


STAYS, LEAVES = 0, 1
"""Rings of which the largest multiplier is 0.752 and 1.0707."""


@lru_cache
def wave(seed, friction="orthogonal", harmonics=9):
    """A ring, and its wave where friction with lift-off holds the peak down most."""
    system, frequency = worst_ring(seed, "lift")
    if friction == "isotropic":
        kt = system.contacts.kt.mean(axis=1)
        system = with_contacts(system, kt=np.column_stack([kt, kt]))
    return system, frequency_response(system, [frequency], Options(harmonics, friction=friction))


def statistics(found):
    return np.array([found.mean, found.largest, found.smallest])[:, 0]


@pytest.mark.parametrize("friction", ["orthogonal", "isotropic"])
def test_a_ring_comes_back_to_a_stable_wave(friction):
    system, response = wave(STAYS, friction)
    errors = []
    for steps in (64, 256):
        found = settled_response(system, response, 0, steps, disturbance=1e-3, growth=0.0)
        assert found.verdict == STEADY
        assert found.returned
        assert found.defect[0] > 1e3 * found.defect[-1]
        assert found.largest == pytest.approx(found.smallest, rel=1e-3)
        errors.append(np.abs(statistics(found) / response.amplitude[0, 0] - 1).max())
    assert errors[1] < 3e-4
    assert errors[1] < errors[0] / 3


def test_a_ring_leaves_an_unstable_wave_by_its_multiplier():
    """Before that the wave itself, and after that what is no longer small, bend the growth."""
    system, response = wave(LEAVES, harmonics=41)
    multiplier = float(np.abs(stability(system, response, harmonics=41).multiplier[0, 0]))
    found = settled_response(system, response, 0, 256, disturbance=1e-5)
    small = np.flatnonzero(found.defect > 5e-3)[0]
    grows = slice(small - 40, small)
    rate = np.polyfit(np.arange(40), np.log(found.defect[grows]), 1)[0]
    assert np.exp(rate) == pytest.approx(multiplier, abs=3e-3)
    assert found.verdict == MODULATED
    assert not found.returned
    assert found.departure[-found.window :].min() > 0.1


def test_what_has_not_settled_says_so():
    system, response = wave(LEAVES)
    short = settled_response(system, response, 0, periods=60)
    assert (short.verdict, short.periods) == (UNSETTLED, 60)
    # One that came to rest, but was not followed as long as asked for, has not either.
    system, response = wave(STAYS)
    rest = settled_response(system, response, 0, periods=60, least=200, growth=0.0)
    assert rest.verdict == UNSETTLED


def test_a_second_motion_on_its_way_is_waited_for():
    """Two motions grow, 1.267 and 1.158 a period: the first alone seems settled after 72."""
    _, force, frequency = worst_of(LEAVES)["lift"]
    system = loaded(spring_ring(LEAVES), 1.5 * force)
    response = frequency_response(system, [frequency], Options(5))
    followed = partial(settled_response, system, response, 0, 64)
    for need, ends in ((71.5, 72), (72.5, 108)):
        growth = 2 * np.log(1e4) / need * frequency
        assert followed(periods=108, growth=growth).periods == ends
    found = followed(periods=360)
    assert found.verdict == UNSETTLED
    early, late = (
        found.amplitude[part, :, 0].max((0, 1)) for part in (slice(48, 72), slice(336, 360))
    )
    assert late[2] > 1.4 * early[2]


@pytest.mark.parametrize("seed", [0, 1])
def test_what_grows_slowly_is_not_hidden_by_what_dies_out(seed):
    """A wave that a ring leaves slowly is not taken for one that it stays with, growth unknown."""
    system, frequency = loaded(spring_ring(20), 0.7101), worst_of(20)["lift"][2]
    response = frequency_response(system, [frequency], Options(9))
    assert 1.002 < np.abs(stability(system, response).multiplier[0, 0]) < 1.004
    found = settled_response(system, response, 0, periods=200, seed=seed, growth=0.0)
    assert found.verdict != STEADY


@pytest.mark.parametrize(("growth", "above", "verdict"), [
    (1.002, 1.0, UNSETTLED),  # amplitudes are alike, but may be those of the wave yet
    (1.002, 20.0, MODULATED),
    (1.01, 20.0, UNSETTLED),  # still growing
    (0.9, 1.0, STEADY),
    (1.02, 1e-4, UNSETTLED),  # small, and growing
])  # fmt: skip
def test_a_disturbance_on_its_way_is_no_verdict(growth, above, verdict):
    defect: NDArray[np.float64] = np.multiply(1e-2 * above, np.power(growth, np.arange(150)))
    defect[0] = 1e-2
    assert _verdict(np.ones((150, 4, 1, 3)), defect, 0.02) == verdict


def test_sectors_that_are_excited_alike_are_followed_one_by_one():
    """A disturbance that they do not share is there, and dies out."""
    system, _ = wave(STAYS)
    alike = replace(system, engine_order=system.sectors)
    response = frequency_response(alike, [0.12], Options(5))
    found = settled_response(alike, response, 0, disturbance=1e-2, growth=0.0)
    assert found.amplitude.shape[1] == system.sectors
    assert np.ptp(found.amplitude[0, :, 0, 0]) > 1e-3 * response.amplitude[0, 0, 0]
    assert np.ptp(found.amplitude[-1, :, 0, 0]) < 1e-4 * response.amplitude[0, 0, 0]
    assert found.returned


@pytest.mark.parametrize(("more", "message"), [
    ({"point": 1}, "point: given 1: there are 1, counted from 0"),
    ({"steps": 39}, "steps: given 39: allowed: 40 or more"),
    ({"periods": 47}, "periods: given 47: allowed: 48 or more"),
    ({"tolerance": 1.0}, "tolerance: given 1.0: allowed: from 0 to below 1"),
    ({"seed": -1}, "seed: given -1: allowed: 0 or more"),
    ({"modes": 0}, "modes: given 0: allowed: 1 or more"),
])  # fmt: skip
def test_what_cannot_be_followed_is_refused(more, message):
    system, response = wave(STAYS)
    refused(message, settled_response, system, response, **{"point": 0, **more})


def test_a_point_that_did_not_converge_is_no_wave():
    system, response = wave(STAYS)
    lost = replace(response, converged=np.array([False]))
    refused("point: given 0: it did not converge", settled_response, system, lost, 0)
