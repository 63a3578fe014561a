"""Joining: counts, excitation, files."""

import re
from dataclasses import replace
from typing import Any

import h5py
import numpy as np
import pytest

from tests.refusals import refused
from vanelock import rom
from vanelock.common.errors import InputError
from vanelock.stages.parts.segment import Joint, Segment


def test_unbalance_resultant(ring_scene):
    """The casing's load, summed around the ring, is the unbalance's centrifugal force U ω²."""
    unbalance, omega, N = 1.5e-3, 1600.0, 8
    system = Segment(ring_scene.joints, 1, unbalance=unbalance).join(
        ring_scene.vane, ring_scene.casing
    )
    f = system.force[1].at(omega)[
        ring_scene.casing.dofs(ring_scene.casing.masters.node_sets["force"])
    ]
    for t in (0.0, 0.3, 1.1):
        total = np.zeros(3)
        for j in range(N):
            a = 2 * np.pi * j / N
            forward = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
            of_sector = (f * np.exp(-1j * a) * np.exp(1j * t)).real.sum(axis=0)
            total += forward @ of_sector
        expected = unbalance * omega**2 * np.array([np.cos(t), np.sin(t), 0.0])
        np.testing.assert_allclose(total, expected, atol=1e-9 * unbalance * omega**2)


def test_system_file_round_trip(ring_scene, tmp_path):
    ring_scene.system.save(tmp_path / "system.h5")
    back = rom.System.load(tmp_path / "system.h5")
    for k, matrices in ring_scene.system.diameters.items():
        for name in ("K", "M", "own", "next", "output"):
            np.testing.assert_array_equal(getattr(back.at(k), name), getattr(matrices, name))
    np.testing.assert_array_equal(back.force[1].vector, ring_scene.system.force[1].vector)
    assert back.contacts.joint == ring_scene.system.contacts.joint
    assert back.output_names == ring_scene.system.output_names
    assert (back.sectors, back.engine_order, back.damping_ratio) == (8, 1, 0.003)


@pytest.mark.parametrize("name", ["nd", "force", "nd/1", "contact"])
def test_numbers_where_a_system_file_has_a_group_are_refused(ring_scene, tmp_path, name):
    ring_scene.system.save(tmp_path / "system.h5")
    with h5py.File(tmp_path / "system.h5", "a") as file:
        del file[name]
        file[name] = np.ones(3)
    refused(r"system\.h5: not a vanelock System", rom.System.load, tmp_path / "system.h5")


def test_component_file_round_trip(ring_scene, tmp_path):
    ring_scene.casing.save(tmp_path / "casing.h5")
    back = rom.Component.load(tmp_path / "casing.h5")
    np.testing.assert_array_equal(back.at(2).basis, ring_scene.casing.at(2).basis)
    np.testing.assert_array_equal(back.masters.nodes, ring_scene.casing.masters.nodes)
    assert back.size == ring_scene.casing.size
    assert sorted(back.diameters) == [0, 1, 2, 4]


def test_what_does_not_fit_is_refused(ring_scene, tmp_path):
    rivet = (Joint("rivet", 1.0, 1.0, 0.1, 0.0),)
    refused('joint "rivet"', Segment(rivet, 1, force=1.0).join, ring_scene.vane, ring_scene.casing)
    refused("not reduced at nodal diameter 3", ring_scene.casing.at, 3)
    refused("no matrices for nodal diameter 3", ring_scene.system.at, 3)
    with pytest.raises(InputError, match="engine order 1 or -1, not 4"):
        Segment(ring_scene.joints, 4, unbalance=1e-3).join(ring_scene.vane, ring_scene.casing)
    (tmp_path / "noise.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(range(200)))
    refused(r"noise\.h5: not a readable HDF5 file", rom.System.load, tmp_path / "noise.h5")


def test_what_does_not_go_together_is_refused(ring_scene):
    parts = {"rim": ring_scene.casing, "block": ring_scene.vane}
    wave = rom.travelling_load(ring_scene.casing, "force", 1, force=1.0)
    spin = rom.travelling_load(ring_scene.casing, "force", 1, unbalance=1.0)
    for keys, line in (
        ({"parts": {}}, "parts: given none"),
        ({"sectors": 9}, "rim: of a ring of 8 sectors, not 9"),
        ({"parts": {"shell": ring_scene.casing}}, "excitation: no part 'rim'; there are shell"),
        ({"engine_order": 3}, "excitation: of engine order 1, not 3"),
        ({"loads": [wave, spin]}, "a force and an unbalance in harmonic 1: give one"),
    ):
        asked = {"sectors": 8, "engine_order": 1, "parts": parts, "loads": [wave], **keys}
        refused(line, rom.Assembly, **asked)
    assembly = rom.Assembly(8, 1, parts, loads=(each for each in [wave]))
    refused("nodal_diameters: given none", assembly.system, [])
    assert list(assembly.system([9]).diameters) == list(assembly.system([1]).force) == [1]
    one, other = ring_scene.vane, ring_scene.casing
    with pytest.raises(InputError, match="no node set 'kye'"):
        rom.contact_pairs("a", one, "hook_front", other, "hook_front", kn=1, kt=1, mu=0, tied="kye")


def test_a_casing_without_nodal_diameters_is_refused(ring_scene):
    """Its sides would be free: the frequencies too low, and nothing would say so."""
    sets = tuple(ring_scene.casing.masters.node_sets)
    piece = rom.reduce(ring_scene.casing_model, sets, modes=2)
    with pytest.raises(InputError, match="rim: reduced in one piece.*give nodal_diameters"):
        Segment(ring_scene.joints, 1, force=30.0).join(ring_scene.vane, piece)


def test_a_file_that_holds_a_system_in_its_group_says_so(ring_scene, tmp_path):
    path = tmp_path / "results.h5"
    expected = f"{path}: expected the format 'vanelock-system' in its attributes"
    with h5py.File(path, "w") as file:
        file["mine"] = 1
    with pytest.raises(InputError) as caught:
        rom.System.load(path)
    assert str(caught.value) == expected
    with h5py.File(path, "a") as file:
        ring_scene.system.save(file.create_group("system"))
    with pytest.raises(InputError) as caught:
        rom.System.load(path)
    assert str(caught.value) == f"{expected}; a results file holds it in its group /system"
    with h5py.File(path) as file:
        assert rom.System.load(file["system"]).sectors == 8


def test_modal_assurance_criterion():
    """MAC is 1 for the same shape in any phase and scale, 0 for M-orthogonal ones."""
    M = np.diag([2.0, 1.0])
    a = np.array([[1.0, 1.0], [1.0, -2.0]])
    b = a * np.array([3j, -0.5])
    np.testing.assert_allclose(rom.mac(a, b, M), np.eye(2), atol=1e-15)


def small(**changes):
    """A system of two coordinates and one contact, with some fields changed."""
    n = 2
    own, eye = np.ones((1, 3, n)), np.eye(n)
    plain = rom.Diameter(2 * eye, eye, own, next=-own, output=np.ones((1, 3, n)))
    contacts = rom.Contacts(np.ones(1), np.ones((1, 2)), np.ones(1), np.zeros(1))
    fields: dict[str, Any] = {
        "sectors": 4,
        "engine_order": 1,
        "diameters": {0: plain, 1: plain},
        "contacts": contacts,
        "force": {1: rom.Force(np.ones(n))},
        "output_names": ("o",),
        "damping_ratio": 0.01,
    }
    return rom.System(**{**fields, **changes}), plain


WRONG: dict[str, Any] = {
    "nd/1/output is missing": lambda d: {"diameters": {0: d, 1: replace(d, output=None)}},
    "nd/0/next is missing": lambda d: {"diameters": {0: replace(d, next=None), 1: d}},
    "nd/1/C is missing": lambda d: {"diameters": {0: replace(d, C=np.eye(2)), 1: d}},
    "nd/0/C is not Hermitian": lambda d: {"diameters": {0: replace(d, C=1j * np.eye(2))}},
    "nd/0/K is not Hermitian": lambda d: {"diameters": {0: replace(d, K=np.triu(d.K + 1))}},
    "nd/0/M is not positive": lambda d: {"diameters": {0: replace(d, M=np.diag([1.0, -1.0]))}},
    "damping/ratio = -0.05": lambda d: {"damping_ratio": -0.05},
    "damping/ratio = nan": lambda d: {"damping_ratio": float("nan")},
    "force/0 is complex": lambda d: {"force": {0: rom.Force(1j * np.ones(2))}},
    "force/-1: harmonics": lambda d: {"force": {-1: rom.Force(np.ones(2))}},
    "force/1 has shape": lambda d: {"force": {1: rom.Force(np.ones(3))}},
    "sectors = 0": lambda d: {"sectors": 0},
    "object 'nd' doesn't exist": lambda d: {"diameters": {}, "force": {}},
}


@pytest.mark.parametrize("message", WRONG)
def test_a_system_file_that_does_not_fit_together_is_refused(message, tmp_path):
    right, plain = small()
    right.save(tmp_path / "right.h5")
    rom.System.load(tmp_path / "right.h5")
    wrong, _ = small(**WRONG[message](plain))
    wrong.save(tmp_path / "wrong.h5")
    refused(re.escape(message), rom.System.load, tmp_path / "wrong.h5")
