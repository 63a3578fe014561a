"""By how much sectors differ: what is drawn, scaled, turned and refused."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import with_contacts
from tests.verification.nonlinear.spring_rings import spring_ring
from vanelock.common.errors import InputError
from vanelock.nonlinear import Contacts, Element, Mistuning, SectorModes
from vanelock.nonlinear.forced_response.ring.ring_source import ring_contacts

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
    with pytest.raises(InputError, match="do not fit"):
        SectorModes.of_part(two_joints(8), K, M, np.eye(5, 6), 1)


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


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"hub": {"mu": 0.1}}, "mistuning: given 'hub': known are hook, interlock"),
        ({"hook": {"E": 0.1}}, "mistuning: hook.E: allowed: interference, kn, kt, mu, slider"),
        ({"hook": {"mu": -0.1}}, "mistuning: hook.mu: given -0.1: must be >= 0"),
        ({"hook": {"mu": float("nan")}}, "mistuning: hook.mu: given nan: must be >= 0"),
        (Mistuning(11), "mistuning: of 11 sectors: the system has 12"),
        (Mistuning(12, mu=np.zeros((12, 3))), "mistuning.mu: given shape (12, 3): needs (12, 2)"),
        (
            Mistuning(12, kn=np.full((12, 2), np.nan)),
            "mistuning.kn: holds values that are not finite",
        ),
        (
            Mistuning(12, mu=np.full((12, 2), -1.5)),
            "mistuning.mu: given -1.5: relative, must be >= -1",
        ),
        (
            Mistuning(12, kn=np.full((12, 2), -1.0)),
            "mistuning.kn: given -1: relative, must be > -1",
        ),
        (
            Mistuning(12, frequency=np.zeros((12, 1)), modes=two_modes()),
            "mistuning.frequency: given shape (12, 1): needs (12, 2)",
        ),
        (
            Mistuning(12, frequency=np.zeros((12, 1))),
            "mistuning.frequency: given shape (12, 1): needs (12, 0)",
        ),
    ],
)
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
    with pytest.raises(InputError, match="mistuning.mu: elements follow laws of their own"):
        Mistuning(12, mu=mu).of(system)
