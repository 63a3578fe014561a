"""The stiffness that meshes add, taken off a joined system: what is exact."""

import numpy as np
import pytest
import scipy.linalg as sl

from vanelock import rom
from vanelock.rom.joining.mesh_excess import _FRICTIONLESS, MeshExcess, _ModalExcess

MODES = 6
SHARES = (0.05, 0.03)
"""Of the strain energy of vane and casing, in the combination of modes that loses least."""


def excess_of(ring_scene, k):
    """A Hermitian excess of both parts that couples the modes: shares of their strain energy."""
    hertz, shapes = rom.linear_modes(ring_scene.system, k, MODES)
    random = np.random.default_rng(k)
    parts, forces = [], []
    one = ring_scene.system.at(k)
    for part, share in zip((ring_scene.vane, ring_scene.casing), SHARES, strict=True):
        K = one.joined(part.masters.part, part.at(k).K.astype(complex))
        turned = random.normal(size=(MODES, MODES)) + 1j * random.normal(size=(MODES, MODES))
        root = sl.cholesky(shapes.conj().T @ K @ shapes + 1e-9 * np.eye(MODES))
        unitary = np.linalg.qr(turned.real if k == 4 else turned)[0]
        energy = (unitary * (share * (1 + np.arange(MODES)))) @ unitary.conj().T
        parts.append(root.conj().T @ energy @ root)
        forces.append(K @ shapes)
    return shapes, rom.modal_excess(shapes, hertz, parts, forces)


@pytest.fixture(scope="module")
def taken(ring_scene):
    return MeshExcess({k: excess_of(ring_scene, k)[1] for k in (1, 2)})


def test_the_energy_of_the_modes_is_less_by_the_excess(ring_scene, taken):
    found = taken.taken_off(ring_scene.system)
    for k in (1, 2):
        shapes, one = excess_of(ring_scene, k)
        K, lowered = ring_scene.system.at(k).K, found.at(k).K
        np.testing.assert_allclose(lowered, lowered.conj().T, atol=1e-9 * np.abs(K).max())
        expected = shapes.conj().T @ K @ shapes - one.parts.sum(axis=0)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(shapes.conj().T @ lowered @ shapes, expected, atol=1e-8 * scale)


def test_no_shape_loses_more_of_its_energy_than_the_modes(ring_scene, taken):
    """Whatever contacts do: so a structure that is held stays so, with all of them open too."""
    found = taken.taken_off(ring_scene.system)
    least = 1 - max(SHARES) * MODES
    for k in (1, 2):
        values = sl.eigh(found.at(k).K - least * ring_scene.system.at(k).K, eigvals_only=True)
        assert values[0] > -1e-9 * values[-1]
        none = np.zeros(ring_scene.system.contacts.count, bool)
        as_it_is, lowered = (
            rom.linear_modes(system, k, 3, none)[0] for system in (ring_scene.system, found)
        )
        assert np.all(lowered > as_it_is * least**0.5)
        assert np.all(lowered < as_it_is)


def test_frequencies_fall_by_half_the_share_of_the_excess(ring_scene, taken):
    found, k = taken.taken_off(ring_scene.system), 1
    one = excess_of(ring_scene, k)[1]
    omega2 = (2 * np.pi * one.frequency) ** 2
    small = sl.eigvalsh(np.diag(omega2) - one.parts.sum(axis=0))
    lowered, _ = rom.linear_modes(found, k, 3)
    # Shapes outside of the modes' span change them a little, always downwards.
    np.testing.assert_allclose(lowered, np.sqrt(small[:3]) / (2 * np.pi), rtol=5e-3)


def test_what_has_no_excess_stays_as_it_is(ring_scene, taken):
    found = taken.taken_off(ring_scene.system)
    for k in ring_scene.system.diameters.keys() - {1, 2}:
        assert found.at(k) is ring_scene.system.at(k)
    assert found.at(1).M is ring_scene.system.at(1).M


def test_the_excess_of_a_part_goes_with_its_modulus(ring_scene, taken):
    both, vane, casing = (
        taken.taken_off(ring_scene.system, factors).at(1).K - ring_scene.system.at(1).K
        for factors in ((2.0, 3.0), (1.0, 0.0), (0.0, 1.0))
    )
    np.testing.assert_allclose(both, 2 * vane + 3 * casing, atol=1e-12 * np.abs(both).max())
    shell = np.setdiff1d(np.arange(len(vane)), ring_scene.joined_dofs)
    assert not vane[shell].any()
    assert np.abs(vane).max() > 0
    assert np.abs(casing).max() > 0


def test_real_matrices_stay_real(ring_scene):
    taken = MeshExcess({4: excess_of(ring_scene, 4)[1]})
    assert np.isrealobj(ring_scene.system.at(4).K)
    assert np.isrealobj(taken.taken_off(ring_scene.system).at(4).K)


def test_no_more_than_half_of_the_stiffness_is_taken_off():
    shapes, omega2 = np.eye(3), np.array([1.0, 4.0, 9.0])
    given = shapes, np.sqrt(omega2) / (2 * np.pi)
    share = np.array([0.6, 0.3, 0.5])
    found = rom.modal_excess(*given, [np.diag(share * omega2)], [np.diag(omega2)])
    np.testing.assert_allclose(found.stiffness[0], np.diag(share.clip(max=0.5) * omega2))
    assert found.share == pytest.approx(0.6)


def test_answers_to_interference_are_held_by_it_alone(ring_scene):
    """Of each joint, with contacts that stick and with contacts that hardly do so tangentially."""
    system, contacts = ring_scene.system, ring_scene.system.contacts
    joints = list(dict.fromkeys(contacts.joints))
    answers = rom.rest_shapes(system, joints)
    assert answers.shape == (len(system.at(0).K), 2 * len(joints))
    rows, held = system.contact_rows(0), contacts.stiffness.copy()
    for number, shape in enumerate(answers.T):
        joint = joints[number % len(joints)]
        held[:, 1:] = contacts.kt * (1.0 if number < len(joints) else _FRICTIONLESS)
        moved = np.einsum("cdi,i->cd", rows, shape)
        force = system.at(0).K @ shape + np.einsum("cdi,cd->i", rows.conj(), held * moved)
        push = np.einsum("ci,c->i", rows[:, 0].conj(), contacts.kn * contacts.of(joint))
        size = np.vdot(push, force) / np.vdot(push, push)
        np.testing.assert_allclose(force, size * push, atol=1e-7 * np.abs(force).max())
        assert np.vdot(shape, system.at(0).M @ shape).real == pytest.approx(1)


def test_motion_without_strain_has_no_excess():
    """What a part adds to modes in which it does not strain is nothing but round-off."""
    hertz, energy = np.ones(2), np.diag([1.0, 1e-12])
    found = rom.modal_excess(np.eye(2), hertz, [np.diag([0.1, 1e-3])], [energy])
    np.testing.assert_allclose(found.stiffness[0], np.diag([0.1, 0.0]), atol=1e-12)


def test_it_survives_a_file(taken, tmp_path):
    taken.save(tmp_path / "excess.h5")
    again = MeshExcess.load(tmp_path / "excess.h5")
    assert list(again.diameters) == [1, 2]
    assert isinstance(again.diameters[1], _ModalExcess)
    np.testing.assert_array_equal(again.diameters[1].parts, taken.diameters[1].parts)
