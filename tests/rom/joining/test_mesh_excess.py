"""The stiffness that meshes add, taken off a joined system: what is exact, what is refused."""

import numpy as np
import pytest
import scipy.linalg as sl

from vanelock import rom
from vanelock.common.errors import InputError
from vanelock.rom.joining.mesh_excess import MeshExcess, ModalExcess

MODES = 6
SHARES = (0.03, 0.02)
"""Relative excess of vane and casing in the test's first mode; the next ones have more."""


def excess_of(system, k):
    """A Hermitian excess of both parts that couples the modes."""
    hertz, shapes = rom.linear_modes(system, k, MODES)
    omega = 2 * np.pi * hertz
    random = np.random.default_rng(k)
    coupling = random.normal(size=(MODES, MODES)) + 1j * random.normal(size=(MODES, MODES))
    growing = np.diag(1 + 0.1 * np.arange(MODES)) + 0.02 * (coupling + coupling.conj().T)
    parts = [share * np.outer(omega, omega) * growing for share in SHARES]
    return rom.modal_excess(shapes, hertz, parts)


@pytest.fixture(scope="module")
def taken(scene):
    return MeshExcess({k: excess_of(scene.system, k) for k in (1, 2)})


def test_the_modes_are_those_of_the_small_problem_and_the_others_stay(scene, taken):
    found = taken.taken_off(scene.system)
    for k in (1, 2):
        hertz, _ = rom.linear_modes(scene.system, k, 12)
        one = taken.diameters[k]
        small = np.diag((2 * np.pi * one.frequency) ** 2) - one.parts.sum(axis=0)
        expected = np.sqrt(sl.eigvalsh(small)) / (2 * np.pi)
        lowered, _ = rom.linear_modes(found, k, 12)
        np.testing.assert_allclose(
            np.sort(lowered), np.sort([*expected, *hertz[MODES:]]), rtol=1e-8
        )
        assert lowered[0] < 0.99 * hertz[0]
        K = found.at(k).K
        np.testing.assert_allclose(K, K.conj().T, atol=1e-9 * np.abs(K).max())


def test_what_has_no_excess_stays_as_it_is(scene, taken):
    found = taken.taken_off(scene.system)
    for k in scene.system.diameters.keys() - {1, 2}:
        assert found.at(k) is scene.system.at(k)
    assert found.at(1).M is scene.system.at(1).M


def test_the_excess_of_a_part_goes_with_its_modulus(scene, taken):
    both, vane, casing = (
        taken.taken_off(scene.system, factors).at(1).K - scene.system.at(1).K
        for factors in ((2.0, 3.0), (1.0, 0.0), (0.0, 1.0))
    )
    np.testing.assert_allclose(both, 2 * vane + 3 * casing, atol=1e-12 * np.abs(both).max())
    assert np.abs(vane).max() > 0


def test_real_matrices_stay_real(scene):
    taken = MeshExcess({8: excess_of(scene.system, 8)})
    assert np.isrealobj(scene.system.at(8).K)
    assert np.isrealobj(taken.taken_off(scene.system).at(8).K)


def test_how_much_a_mode_is_raised_is_half_its_relative_excess(scene):
    one = excess_of(scene.system, 1)
    omega2 = (2 * np.pi * one.frequency) ** 2
    expected = np.diagonal(one.parts.sum(axis=0)).real / omega2 / 2
    np.testing.assert_allclose(one.raised, expected)


def test_an_excess_that_is_most_of_the_stiffness_is_refused(scene):
    hertz, shapes = rom.linear_modes(scene.system, 1, MODES)
    omega2 = (2 * np.pi * hertz) ** 2
    most = [np.diag(0.4 * omega2), np.diag(0.2 * omega2)]
    with pytest.raises(InputError, match=r"mesh.correction: the mesh holds 60 % of the stiffness"):
        rom.modal_excess(shapes, hertz, most)
    rom.modal_excess(shapes, hertz, [0.5 * each for each in most])


def test_it_survives_a_file(taken, tmp_path):
    taken.save(tmp_path / "excess.h5")
    again = MeshExcess.load(tmp_path / "excess.h5")
    assert list(again.diameters) == [1, 2]
    assert isinstance(again.diameters[1], ModalExcess)
    np.testing.assert_array_equal(again.diameters[1].parts, taken.diameters[1].parts)
