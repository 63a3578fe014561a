"""Systems of matrices: closed forms, other programs, what may be given and what is refused."""

from dataclasses import replace
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from tests.nonlinear.systems import solved_response
from tests.refusals import refused
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contact,
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    linear_response,
    static_response,
)
from vanelock.rom.system.coordinates import check
from vanelock.rom.system.element import spring_along

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
    solved = solved_response(system, hertz, Options(1))
    for found in (solved, linear_response(system, hertz)):
        assert found.converged.all()
        np.testing.assert_allclose(found.output[:, 1, :, 0], 2.0 * receptance(hertz), rtol=1e-9)
        rest = np.tile(np.linalg.solve(K2, [0.0, 3.0]), (30, 1))
        np.testing.assert_allclose(found.output[:, 0, :, 0], rest, rtol=1e-9)


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
    found = solved_response(block(push, 100.0), omega / (2 * np.pi), Options(8))
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
    found = solved_response(system, omega / (2 * np.pi), Options(5))
    np.testing.assert_allclose(np.abs(found.output[:, 1, 0, 0]), expected, rtol=2e-6)


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
    refused(message, System.from_matrices, **{"M": M2, "K": K2, **changed})


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
    refused(f"Contact 'contact': {message}", Contact, **given)


ROWS = [[[1], [0], [0]]]
ALONE = {"K": [[4, 1j], [-1j, 3]], "M": np.eye(2), "own": [[[1, 0], [0, 1], [0, 0]]]}


def oscillator(**changed):
    """A unit mass with a gap, in lists of whole numbers."""
    given = {
        "sectors": 1,
        "engine_order": 0,
        "diameters": {0: Diameter(K=[[1]], M=[[1]], C=[[0.02]], own=ROWS, output=ROWS)},
        "contacts": Contacts([1], [[1, 1]], [0], [-1]),
        "force": {1: Force([0.15])},
        "output_names": ["mass"],
    }
    return System(**{**given, **changed})


def test_lists_whole_numbers_and_sparse_matrices_are_as_good_as_arrays():
    lists = oscillator()
    row = np.array(ROWS, float)
    one = sp.csc_array([[1]])
    sparse = Diameter(K=one, M=sp.eye(1), C=0.02 * one, own=row, output=row)
    arrays = oscillator(
        diameters={np.int64(0): sparse},
        contacts=Contacts(np.ones(1), np.ones((1, 2)), np.zeros(1), np.array([-1.0])),
        force={1: Force(np.array([0.15 + 0j]))},
        output_names=("mass",),
    )
    for system in (lists, arrays):
        assert system.contacts.v0.dtype == float
        assert system.diameters[0].K.dtype == float
        assert system.output_names == ("mass",)
    hertz = [0.15, 0.18]
    one_way, other = (
        frequency_response(each, hertz, Options(1)).output for each in (lists, arrays)
    )
    np.testing.assert_array_equal(one_way, other)
    np.testing.assert_array_equal(Diameter(**ALONE).K, [[4, 1j], [-1j, 3]])


def test_arrays_of_double_precision_are_not_copied():
    K = np.eye(2)
    assert np.shares_memory(Diameter(K=K, M=K, own=np.zeros((1, 3, 2))).K, K)


NO_SYSTEM: list[tuple[Any, str]] = [
    (lambda: Contacts(1, 1, 0, -1), r"Contacts\.kn: given shape \(\): needs 1 dimension"),
    (lambda: Contacts([1], [1], [0], [1]), r"Contacts\.kt: given shape \(1,\): needs 2 dim"),
    (lambda: Contacts(["a"], [[1, 1]], [0], [1]), r"Contacts\.kn: given \['a'\]: needs an array"),
    (lambda: Contacts([1], [[1, 1]], [1j], [1]), r"Contacts\.mu: given complex numbers: needs re"),
    (lambda: Diameter(**{**ALONE, "K": 1.0}), r"Diameter\.K: given shape \(\): needs 2"),
    (lambda: Diameter(**{**ALONE, "M": None}), r"Diameter\.M: given None: needs an array"),
    (lambda: Diameter(**{**ALONE, "K": [[1, 2], [1]]}), r"Diameter\.K: given rows of different"),
    (lambda: Force(1.0), r"Force\.vector: given shape \(\)"),
    (lambda: Force([1.0], omega_power=None), r"Force\.omega_power: given None: needs a whole"),
    (lambda: oscillator(sectors="16"), r"System\.sectors: given '16': needs a whole number"),
    (lambda: oscillator(engine_order=1.5), r"System\.engine_order: given 1\.5: needs a whole"),
    (lambda: oscillator(contacts=None), r"System\.contacts: given a NoneType: needs a Contacts"),
    (lambda: oscillator(diameters=[1]), r"System\.diameters: given a list: needs a Mapping"),
    (lambda: oscillator(force={1: [0.1]}), r"System\.force\[1\]: given a list: needs a Force"),
    (lambda: oscillator(force={"1": Force([1])}), r"System\.force: given '1': needs a whole numb"),
    (lambda: oscillator(output_names="mass"), r"System\.output_names: given 'mass': needs a list"),
    (lambda: oscillator(damping_ratio="1 %"), r"System\.damping_ratio: given '1 %'"),
    (lambda: oscillator(damping_ratio=[0.1]), r"System\.damping_ratio: given shape \(1,\)"),
    (lambda: linear_response(oscillator(), [1j]), "frequencies: given complex numbers"),
]


@pytest.mark.parametrize(("make", "message"), NO_SYSTEM)
def test_what_is_no_system_is_refused_in_one_line(make, message):
    refused(message, make)


def test_each_part_of_a_system_shows_itself_in_one_line():
    system = oscillator()
    expected = "Contacts(kn=<1 float64>, kt=<1 x 2 float64>, mu=<1 float64>, v0=<1 float64>, "
    expected += "joint=(), always_closed=(), slider=<1 x 2 float64>)"
    assert repr(system.contacts) == expected
    assert "diameters={0}, contacts=<Contacts>, force={1}, output_names=('mass',)" in repr(system)
    silent = Diameter(K=[[1]], M=[[1]], C=[[0.02]], own=ROWS)
    bare = oscillator(diameters={0: silent}, output_names=())
    assert "output=none, amplitude=none" in repr(frequency_response(bare, 0.1, Options(1)))
    for shown in (system, system.force[1], system.diameters[0], frequency_response(system, 0.1)):
        assert "\n" not in repr(shown)
        assert len(repr(shown)) < 1000


def test_a_file_with_arrays_that_do_not_fit_is_named(tmp_path):
    path = tmp_path / "system.h5"
    oscillator().save(path)
    with h5py.File(path, "a") as file:
        del file["nd/0/K"]
        file["nd/0/K"] = np.ones(3)
    refused(r"system\.h5: Diameter\.K: given shape \(3,\)", System.load, path)


def test_joints_in_damping_are_kept_checked_and_stuck_in_older_files(tmp_path):
    given = replace(oscillator(damping_ratio=0.01), damping_joints="open")
    given.save(tmp_path / "system.h5")
    assert System.load(tmp_path / "system.h5").damping_joints == "open"
    with h5py.File(tmp_path / "system.h5", "a") as file:
        del file["damping"].attrs["joints"]
    assert System.load(tmp_path / "system.h5").damping_joints == "stuck"
    with pytest.raises(InputError, match="damping/joints = 'free': allowed are 'open' and 'stuck'"):
        check(replace(given, damping_joints="free"))


def test_the_spring_along_a_displacement_is_its_stiffness_or_else_its_inertia():
    """Of a coordinate alone K, whatever its factor does to the displacement."""
    K, M = np.diag([2.0, 0.0]), np.diag([3.0, 5.0])
    assert spring_along(np.array([1.0, 0.0]), K, M) == 2.0
    assert spring_along(np.array([2.0, 0.0]), K, M) == 0.5  # of x = u / 2
    assert spring_along(np.array([0.0, 1j]), K, M) == 5.0
    assert spring_along(np.zeros(2), K, M) == 0.0
