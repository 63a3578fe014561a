"""What may be given for a system's arrays, and what is said of the rest."""

from dataclasses import replace
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.sparse as sp

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    frequency_response,
    linear_response,
)
from vanelock.rom.system.coordinates import check
from vanelock.rom.system.element import spring_along

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


REFUSED: list[tuple[Any, str]] = [
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


@pytest.mark.parametrize(("make", "message"), REFUSED)
def test_what_is_no_system_is_refused_in_one_line(make, message):
    with pytest.raises(InputError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


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
    with pytest.raises(InputError, match=r"system\.h5: Diameter\.K: given shape \(3,\)"):
        System.load(path)


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
