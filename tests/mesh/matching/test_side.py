"""A user's sets, found by name or number, and the frames of their nodes."""

from dataclasses import replace

import numpy as np
import pytest

from tests.mesh.conftest import refusal
from vanelock.mesh import (
    HookDimensions,
    VaneDimensions,
    casing_sector,
    pair,
    read_mesh,
    vane_segment,
)
from vanelock.mesh.matching.side import own_part


@pytest.mark.parametrize(("sets", "expected"), [
    ({"output": "absent"}, "no set absent for vane.output; it has "),
    ({"key": [1, 2]}, "belongs to no solid element"), ({"output": "hollow"}, "it has no nodes"),
    ({"key": "output"}, "belongs to neither hook: its nodes must be some of theirs"),
    ({"fixed": "interlock_left"}, "is in the sets fixed and interlock_left, which must not"),
    ({"interlock_left": "interlock_right"}, "is in the sets interlock_left and interlock_right"),
])  # fmt: skip
def test_sets_are_checked(tmp_path, ring, write_mesh, sets, expected):
    part = ring("vane")
    path = tmp_path / "vane.inp"
    write_mesh(path, part)
    path.write_text(path.read_text() + "*NSET, NSET=hollow\n")
    line = refusal(lambda: own_part(read_mesh(path, "mm"), "vane", sets))
    assert line.startswith(str(path))
    assert expected in line


@pytest.mark.parametrize("name", ["force", "output"])
@pytest.mark.parametrize("face", ["left", "right"])
def test_loads_and_outputs_are_not_on_a_cut_face(tmp_path, ring, write_mesh, name, face):
    """The node is called by the file's number."""
    part = ring("casing")
    node = part.node_sets[face][5]
    path = tmp_path / "casing.inp"
    write_mesh(path, replace(part, node_sets=part.node_sets | {name: np.array([node])}))
    mesh = read_mesh(path, "mm")
    line = refusal(lambda: own_part(mesh, "casing"))
    wanted = mesh.numbers[np.linalg.norm(mesh.points - part.points[node], axis=1).argmin()]
    assert f"node {wanted} is in the sets {name} and {face}, which must not share" in line


def test_set_with_a_node_of_no_element_is_refused(tmp_path, ring, write_mesh):
    path = tmp_path / "vane.inp"
    write_mesh(path, ring("vane"))
    text = path.read_text().replace("*NODE\n", "*NODE\n7, 0., 0., 0.\n")
    path.write_text(text + "*NSET, NSET=output\n7\n")
    line = refusal(lambda: own_part(read_mesh(path, "mm"), "vane"))
    assert line.endswith("set OUTPUT: 1 of its nodes belong to no solid element, such as 7")


def test_interlock_sets_are_needed_only_with_contacts(tmp_path, ring, write_mesh):
    part = ring("vane")
    names = ("hook_front", "hook_rear", "key", "output")
    path = tmp_path / "vane.inp"
    write_mesh(path, replace(part, node_sets={name: part.node_sets[name] for name in names}))
    found = own_part(read_mesh(path, "mm"), "vane", interlock=False)
    assert set(found.node_sets) == set(names)
    line = refusal(lambda: own_part(read_mesh(path, "mm"), "vane"))
    assert "no set interlock_left for vane.interlock_left" in line


def test_frames_of_the_program_s_own_parts_come_back(tmp_path, write_mesh):
    """Those of slanted interlock faces among them, whatever the order in the files."""
    hook = HookDimensions(band_nodes=3)
    vane = VaneDimensions(aerofoils=1, root_fillet=0.0, interlock_nodes=3, hook=hook)
    made = vane_segment(vane, size=0.04), casing_sector(hook=hook, size=0.04)
    read = []
    for part, ending in zip(made, (".gmsh.msh", ".cdb"), strict=True):
        called = write_mesh(tmp_path / f"{part.name}{ending}", part)
        mesh = read_mesh(tmp_path / f"{part.name}{ending}", "mm")
        read.append(own_part(mesh, part.name, called))
    both = pair(*read, 16)
    for part, found in zip(made, (both.vane, both.casing), strict=True):
        for name, wanted in part.frames.items():
            own, other = part.points[part.node_sets[name]], found.points[found.node_sets[name]]
            place = np.linalg.norm(own[:, None] - other, axis=2)
            assert place.min(axis=1).max() < 1e-13
            assert np.abs(found.frames[name][place.argmin(axis=1)] - wanted).max() < 1e-9
