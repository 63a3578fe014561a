"""Matrices with contacts between coordinates: closed forms, time integration, one-line errors."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from tests.nonlinear.systems import in_time, jenkins_element
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    STUCK,
    Contact,
    Options,
    System,
    frequency_response,
    linear_response,
    static_response,
)

M2, K2 = np.diag([1.0, 0.5]), np.array([[3e4, -1e4], [-1e4, 1e4]])
DAMPER = Contact(tangential=1, kt=2e4, mu=0.3, preload=10.0)


def two_masses(**changed):
    given = {"damping_ratio": 0.01, "force": {0: 2.0}}
    return System.from_matrices(M2, K2, [DAMPER], **{**given, **changed})


def receptance(hertz):
    """(p, 2) both coordinates over a unit force on the first, by modes."""
    omega2, shapes = la.eigh(K2, M2)
    w = 2 * np.pi * hertz[:, None]
    gain = 1 / (omega2 - w**2 + 2j * 0.01 * w * np.sqrt(omega2))
    return (gain * shapes[0]) @ shapes.T


def test_a_structure_without_contacts_is_the_sum_of_its_modes():
    hertz = np.linspace(5, 40, 30)
    loads = {"force": {0: 2.0}, "static_force": {1: 3.0}}
    system = System.from_matrices(M2, K2, damping_ratio=0.01, **loads)
    assert system.output_names == ("x0", "x1")
    solved = frequency_response(system, hertz, Options(1), find_jumps=False)
    for found in (solved, linear_response(system, hertz)):
        assert found.converged.all()
        np.testing.assert_allclose(found.output[:, 1, :, 0], 2.0 * receptance(hertz), rtol=1e-9)
        rest = np.tile(np.linalg.solve(K2, [0.0, 3.0]), (30, 1))
        np.testing.assert_allclose(found.output[:, 0, :, 0], rest, rtol=1e-9)


def test_damping_is_that_of_the_structure_without_its_contacts():
    """Sticking adds a spring and no damper: K + kt, with the C of the free structure's modes."""
    hertz = np.linspace(5, 40, 30)
    found = linear_response(two_masses(), hertz)
    omega2, shapes = la.eigh(K2, M2)
    C = M2 @ shapes @ np.diag(0.02 * np.sqrt(omega2)) @ shapes.T @ M2
    for point, w in enumerate(2 * np.pi * hertz):
        dynamic = K2 + np.diag([0, 2e4]) - w**2 * M2 + 1j * w * C
        expected = np.linalg.solve(dynamic, [2.0, 0.0])
        np.testing.assert_allclose(found.output[point, 1, :, 0], expected, rtol=1e-9)
    given = linear_response(two_masses(damping_ratio=None, C=C), hertz)
    np.testing.assert_allclose(given.output, found.output, rtol=1e-9)


def test_full_sticking_and_slip_by_hand():
    """Masing's loop of one slider on a single mass: work and stiffness in closed form."""
    kt, limit = 2e4, 3.0  # N/m, and mu times preload
    system = System.from_matrices(
        [[1.0]], [[1e4]], [DAMPER_ALONE], damping_ratio=0.02, force={0: 8.0}
    )
    found = frequency_response(system, (14, 30), Options(1), find_jumps=False)
    top = int(found.amplitude[:, 0, 0].argmax())
    X, force = found.amplitude[top, 0, 0], found.force[top, 1, 0, 1]
    assert X > limit / kt  # it slips
    stiffness, work = jenkins_element(X, kt, limit)
    assert found.dissipation[top, 0] == pytest.approx(work, rel=1e-9)
    assert force / found.output[top, 1, 0, 0] == pytest.approx(stiffness, rel=1e-9)


DAMPER_ALONE = Contact(tangential=0, kt=2e4, mu=0.3, preload=10.0)


def block(push, load):
    """A block pressed on the ground through springs: its normal motion changes friction's bound."""
    return System.from_matrices(
        np.eye(2),
        np.diag([12.0, 21.0]),
        [Contact(tangential=0, normal=1, kt=5.0, kn=21.0, mu=0.85)],
        C=np.diag([2 * 0.05 * np.sqrt(12), 2.0]),
        static_force={1: load},
        force={0: push, 1: 0.1 * push},
        outputs={"along": 0, "across": 1},
    )


@pytest.mark.parametrize("hertz", [0.45, 0.58])
def test_a_block_on_the_ground_moves_as_time_integration_says(hertz):
    found = frequency_response(block(12.0, 10.0), [hertz], Options(15), find_jumps=False)
    assert found.converged.all()
    assert found.state[0, 0] != STUCK
    marched, _ = in_time(block(12.0, 10.0), hertz, 30, 1000)
    expected = np.ptp(marched, axis=0) / 2
    np.testing.assert_allclose(found.amplitude[0, :, 0], expected, rtol=2e-3)


ANOTHER = {
    50.0: [
        (3.559717454634983, 12.80699, 0.1656718),
        (3.7846137178405383, 17.1987, 0.174258),
        (3.836984257819639, 17.06191, 0.1764512),
    ],
    100.0: [
        (3.2949129726457764, 29.69457, 0.3141384),
        (3.5415045677979635, 45.56482, 0.3300622),
        (3.574553083411597, 45.169, 0.3323987),
    ],
}
"""By push, N: rad/s and half the peak-to-peak along and across, m, of the example of an elastic dry
friction element that tmdsimpy (2025-02) ships, its law at 4,096 instants of the period."""


@pytest.mark.parametrize("push", ANOTHER)
def test_a_block_on_the_ground_moves_as_another_program_says(push):
    omega, *expected = np.transpose(ANOTHER[push])
    found = frequency_response(
        block(push, 100.0), omega / (2 * np.pi), Options(8), find_jumps=False
    )
    np.testing.assert_allclose(found.amplitude[:, :, 0], np.transpose(expected), rtol=1e-6)


DAMPED = [
    (23.79822127042419, 0.00909763675),
    (24.988372173658227, 0.0819594281),
    (25.998763131383555, 0.023214061),
]
"""rad/s and amplitude of harmonic 1 of the sprung mass, m, of the two masses of pyHarm's (1.2.2)
tutorial on friction, with its Jenkins element at 16,384 instants of the period."""


def test_two_masses_with_a_friction_damper_move_as_another_program_says():
    system = System.from_matrices(
        M=np.diag([1.0, 0.02]),
        C=np.diag([0.05, 0.0]),
        K=[[680.0, -40.0], [-40.0, 40.0]],
        contacts=[Contact(tangential=1, kt=400.0, mu=0.5, preload=1.0)],
        force={0: 1.0},
    )
    omega, expected = np.transpose(DAMPED)
    found = frequency_response(system, omega / (2 * np.pi), Options(5), find_jumps=False)
    np.testing.assert_allclose(np.abs(found.output[:, 1, 0, 0]), expected, rtol=2e-6)


def test_a_stop_lifts_off_as_time_integration_says():
    """A mass with a stop at a gap; the gap stays open below the amplitude that closes it."""

    def made(force):
        return System.from_matrices(
            [[1.0]], [[100.0]], [Contact(normal=0, kn=400.0, gap=0.1)], C=[[1.0]], force={0: force}
        )

    little = frequency_response(made(0.5), [1.0], Options(1), find_jumps=False)
    assert little.amplitude[0, 0, 0] < 0.1
    dynamic = 100 - (2 * np.pi) ** 2 + 2j * np.pi
    assert little.output[0, 1, 0, 0] == pytest.approx(0.5 / dynamic, rel=1e-9)
    much = frequency_response(made(15.0), [1.0], Options(20), find_jumps=False)
    path, _ = in_time(made(15.0), 1.0, 30, 1000)
    np.testing.assert_allclose(much.amplitude[0, 0, 0], np.ptp(path) / 2, rtol=2e-3)


def test_pairs_the_ground_and_factors_are_places():
    def row(place):
        output = System.from_matrices(M2, K2, outputs={"o": place}).diameters[0].output
        assert output is not None
        return output[0, 0]

    assert row(1).tolist() == [0, 1]
    assert row((0, 1)).tolist() == [1, -1]
    assert row((None, 1)).tolist() == [0, -1]
    assert row(np.array([0.5, 2])).tolist() == [0.5, 2]
    relative = System.from_matrices(
        M2, K2, [Contact(tangential=(0, 1), normal=(None, 1), kt=1, kn=2.0, mu=0, preload=3.0)]
    )
    assert relative.diameters[0].own[0].tolist() == [[0, -1], [1, -1], [0, 0]]
    assert (relative.contacts.kn[0], relative.contacts.v0[0]) == (2.0, 1.5)
    both = Contact(tangential=0, second=1, kt=(1.0, 2.0), mu=0.1, preload=5.0)
    system = System.from_matrices(sp.csr_array(M2), sp.csr_array(K2), [both])
    assert system.contacts.kt.tolist() == [[1, 2]]
    assert system.diameters[0].own[0].tolist() == [[0, 0], [1, 0], [0, 1]]


def test_a_preload_is_the_normal_force_at_rest():
    held = Contact(tangential=0, kt=1e4, mu=0.2, preload=7.0, name="damper")
    pressed = Contact(tangential=0, normal=1, kt=1e4, kn=5e4, mu=0.0, preload=7.0)
    for contact, expected in ((held, 7.0), (pressed, 7.0 / (1 + 5e4 / (1e4 - 1e4**2 / 3e4)))):
        system = System.from_matrices(M2, K2, [contact])
        found = static_response(system)
        assert found.force[0, 0, 0, 0].real == pytest.approx(expected, rel=1e-9)
        assert system.contacts.joint == (contact.name,)


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"K": np.ones((2, 3))}, r"K: given shape \(2, 3\): needs a square matrix"),
    ({"M": np.eye(3)}, r"M: given shape \(3, 3\): needs that of K, \(2, 2\)"),
    ({"C": [1.0, 2.0]}, r"C: given shape \(2,\): needs a square matrix"),
    ({"K": [[1, 2], [0, 1]]}, r"K: not symmetric: K\[0, 1\] = 2, K\[1, 0\] = 0"),
    ({"M": np.diag([1, 0])}, "M: not positive: every coordinate needs a mass"),
    ({"K": [[1, np.nan], [np.nan, 1]]}, "K: holds values that are not finite"),
    ({"K": [[1, 1j], [-1j, 1]]}, "K: given complex numbers: needs real ones"),
    ({"force": {2: 1.0}}, "force: coordinate 2: there are 0 to 1"),
    ({"force": [1.0]}, r"force: given shape \(1,\): needs a force for each of 2"),
    ({"static_force": {-1: 1.0}}, "static_force: coordinate -1: there are 0 to 1"),
    (
        {"outputs": {"tip": (0, 1, 1)}},
        r"outputs\['tip'\]: given \(0, 1, 1\): needs a coordinate, or",
    ),
    ({"outputs": {"tip": 0.5}}, r"outputs\['tip'\]: given 0.5: needs a whole number"),
    ({"outputs": {"tip": np.ones(3)}}, r"outputs\['tip'\]: given shape \(3,\): needs a factor for"),
    ({"contacts": [1]}, r"contacts\[0\]: given 1: needs a Contact"),
    (
        {"contacts": [Contact(tangential=(0, 4), kt=1, mu=0.1, preload=1)]},
        r"contacts\[0\]\.tangential: coordinate 4: there are 0 to 1",
    ),
]


@pytest.mark.parametrize(("changed", "message"), REFUSED)
def test_what_fits_nothing_is_refused_in_one_line(changed, message):
    with pytest.raises(InputError, match=message) as caught:
        System.from_matrices(**{"M": M2, "K": K2, **changed})
    assert "\n" not in str(caught.value)


LACKING: list[tuple[dict[str, Any], str]] = [
    ({}, "needs tangential or normal, the coordinates that it acts on"),
    ({"tangential": 0, "kt": 1, "preload": 1}, "tangential needs mu"),
    ({"tangential": 0, "mu": 0.1, "preload": 1}, "tangential needs kt"),
    ({"tangential": 0, "mu": 0.1, "kt": 1, "kn": 1}, "kn needs normal"),
    ({"normal": 0}, "normal needs kn"),
    ({"normal": 0, "kn": 1, "mu": 0.3}, "mu needs tangential"),
    ({"tangential": 0, "mu": 0.1, "kt": 1}, "needs normal, or a preload that stays as it is"),
    ({"normal": 0, "kn": 1, "preload": 1, "gap": 1}, "preload = 1 and gap = 1: needs one of them"),
    ({"second": 1, "normal": 0, "kn": 1}, "has a second tangential direction without the first"),
    ({"normal": 0, "kn": 0}, "kn = 0: must be > 0"),
    ({"normal": 0, "kn": 1, "gap": -1}, "gap = -1: must be >= 0"),
    ({"tangential": 0, "mu": 0.1, "kt": (1, -1), "preload": 1}, r"kt = \(1, -1\): must be > 0"),
    ({"tangential": 0, "mu": np.inf, "kt": 1, "preload": 1}, "mu = inf: must be >= 0"),
    ({"tangential": 0, "mu": 0.1, "kt": 1, "preload": 0}, "preload = 0: must be > 0"),
]


@pytest.mark.parametrize(("given", "message"), LACKING)
def test_a_contact_says_what_it_lacks(given, message):
    with pytest.raises(InputError, match=f"Contact 'contact': {message}") as caught:
        Contact(**given)
    assert "\n" not in str(caught.value)
