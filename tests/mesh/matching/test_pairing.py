"""Meshes from files matched to each other and to the program's own: places, frames, reports."""

from dataclasses import replace

import numpy as np
import pytest

from tests.mesh.conftest import RADIUS, SECTORS, complaints, refusal, ring_sectors
from vanelock import fem
from vanelock.common.cyclic import turn
from vanelock.mesh import pair, read_mesh, read_sector
from vanelock.mesh.cells import SOLIDS
from vanelock.mesh.matching.pairing import _mates
from vanelock.rom.component import choose


def matched(found, sectors=SECTORS, **options):
    return pair(found.vane(), found.casing(), sectors, **options)


@pytest.mark.parametrize("cell_type", SOLIDS)
def test_ring_sectors_meet(given, cell_type):
    """Mates at one place, cyclic faces exact, frames those of a cylinder and of its radial cuts."""
    both = matched(given(cell_type))
    vane, casing = both.vane, both.casing
    assert vane.cell_type == cell_type
    onto = turn(SECTORS).T
    for name in ("hook_front", "hook_rear", "key"):
        own, other = vane.points[vane.node_sets[name]], casing.points[casing.node_sets[name]]
        assert np.array_equal(own, other)
    for part, one, other_name in (
        (vane, "interlock_left", "interlock_right"),
        (casing, "left", "right"),
    ):
        images = part.points[part.node_sets[one]] @ onto
        assert np.abs(images - part.points[part.node_sets[other_name]]).max() < 1e-12 * RADIUS
    for name in ("hook_front", "hook_rear"):
        places = vane.points[vane.node_sets[name]]
        angle = np.arctan2(places[:, 1], places[:, 0])
        c, s, zero = np.cos(angle), np.sin(angle), np.zeros(len(angle))
        rows = [[c, s, zero], [-s, c, zero], [zero, zero, 1 + zero]]
        wanted = np.array(rows).transpose(2, 0, 1)
        assert np.abs(vane.frames[name] - wanted).max() < 1e-12
        sign = np.array([-1.0, 1.0, -1.0])[:, None]
        assert np.abs(casing.frames[name] - sign * wanted).max() < 1e-12
    half = np.pi / SECTORS
    wanted_left = [[-np.sin(half), -np.cos(half), 0], [np.cos(half), -np.sin(half), 0], [0, 0, 1]]
    assert np.abs(vane.frames["interlock_left"] - wanted_left).max() < 1e-12
    right = np.array([-1.0, 1.0, -1.0])[:, None] * np.array(wanted_left) @ onto
    assert np.abs(vane.frames["interlock_right"] - right).max() < 1e-12
    for name in ("interlock_left", "interlock_right"):  # the whole side, 0.1 m by 0.2 m
        assert vane.areas[name].sum() == pytest.approx(0.02, rel=1e-13)
    assert "hook_front" not in vane.areas


def test_order_does_not_depend_on_the_numbering(given):
    """Pairs come band by band, by axial position, then by angle, keys in their order."""
    both = matched(given(ending=".inp"))
    places = both.vane.points[both.vane.node_sets["hook_front"]]
    steps = np.round(places[:, 2], 6), np.arctan2(places[:, 1], places[:, 0])
    assert np.array_equal(np.lexsort(steps[::-1]), np.arange(len(places)))
    hooks = np.concatenate([both.vane.node_sets[name] for name in ("hook_front", "hook_rear")])
    rank = [int(np.flatnonzero(hooks == node)[0]) for node in both.vane.node_sets["key"]]
    assert rank == sorted(rank)


@pytest.mark.parametrize("own", ["vane", "casing"])
def test_one_part_is_the_programs(given, own):
    """The user's part goes to the program's, which stays as it is, frames and order included."""

    def moved(part):
        points = part.points.copy()
        points[part.node_sets["hook_front"]] += [0, 0, 4e-6]
        return replace(part, points=points)

    files = given(change=moved)
    ours = matched(given())
    other = "casing" if own == "vane" else "vane"
    known = getattr(ours, other)
    sides = {other: known, own: getattr(files, own)()}
    both = pair(sides["vane"], sides["casing"], SECTORS)
    assert getattr(both, other) is known
    part = getattr(both, own)
    for name in ("hook_front", "hook_rear", "key"):
        assert np.array_equal(
            part.points[part.node_sets[name]], known.points[known.node_sets[name]]
        )
    for name in ("hook_front", "hook_rear"):
        assert np.array_equal(part.frames[name], np.array([[-1], [1], [-1]]) * known.frames[name])


def shifted(name, which, by):
    """Change that moves some nodes of a set of a part."""

    def change(part):
        if part.name != name[0]:
            return part
        points = part.points.copy()
        for node, distance in zip(part.node_sets[name[1]][which], by, strict=True):
            points[node] += [0, 0, distance]
        return replace(part, points=points)

    return change


def number(own, part, node):
    """What the file calls a node of the part that was written, found by its place."""
    distance = np.linalg.norm(own.mesh.points - part.points[node], axis=1)
    return own.mesh.numbers[int(distance.argmin())]


def test_hook_mismatch_names_nodes_and_distances(given):
    change = shifted(("casing", "hook_front"), [1, 2, 4], [2e-4, 5e-4, 3e-6])
    found = given(ending=".inp", change=change)
    line = refusal(lambda: matched(found))
    casing, made = found.casing(), change(found.made_casing)
    worse, better = (number(casing, made, made.node_sets["hook_front"][i]) for i in (2, 1))
    count = len(made.node_sets["hook_front"])
    assert line.startswith("casing (")
    assert f"hook_front: 2 of {count} nodes are further than 0.01 mm from the nearest" in line
    vane, apart = found.vane(), found.made_vane
    mate = number(vane, apart, apart.node_sets["hook_front"][2])
    assert line.endswith(
        f"node {worse} 0.5 mm, node {better} 0.2 mm; the other way round 2 of {count}, such as "
        f"node {mate} 0.5 mm"
    )
    near = matched(found, tolerance=6e-4)
    assert np.array_equal(
        near.vane.points[near.vane.node_sets["hook_front"]],
        near.casing.points[near.casing.node_sets["hook_front"]],
    )


def test_cyclic_faces_are_matched_in_this_ring_only(given):
    found = given()
    lines = complaints(lambda: matched(found, sectors=SECTORS + 1))
    assert [line.split(":")[0].split(", ")[1] for line in lines] == ["interlock_right", "right"]
    gap = 2 * np.pi / SECTORS - 2 * np.pi / (SECTORS + 1)
    assert f" {1e3 * 2 * (RADIUS + 0.1) * np.sin(gap / 2):.4g} mm, node" in lines[1]


def test_moved_face_node_is_reported(given):
    change = shifted(("casing", "right"), [3], [2e-5])
    line = refusal(lambda: matched(given(change=change)))
    assert ", right: 1 of 27 nodes is further than 0.01 mm from the nearest node of" in line
    assert line.count(" 0.02 mm") == 2
    assert "unit" not in line
    change = shifted(("vane", "interlock_right"), [0], [5e-6])
    both = matched(given(change=change))
    left, right = (
        both.vane.points[both.vane.node_sets[f"interlock_{s}"]] for s in ("left", "right")
    )
    assert np.abs(left @ turn(SECTORS).T - right).max() < 1e-12 * RADIUS


def listed(part, **sets):
    return replace(part, node_sets=part.node_sets | sets)


CASINGS = {
    "ten times as large": (
        lambda part, sets: replace(part, points=10 * part.points), [": is the unit right?"] * 2
    ),
    "a node less": (
        lambda part, sets: listed(part, hook_rear=sets["hook_rear"][1:]), ["hook_rear: 1 of "]
    ),
    "half of both cut faces": (
        lambda part, sets: listed(part, left=sets["left"][::2], right=sets["right"][::2]),
        ["nodes of either face are missing, such as node"],
    ),
    "other keys": (
        lambda part, sets: listed(part, key=[sets["hook_front"][0], sets["hook_rear"][1]]),
        ["), 1 is missing, such as node", "key: 1 of its nodes meets no key of vane ("],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASINGS)
def test_casings_that_do_not_meet_the_vane(given, case):
    change, expected = CASINGS[case]
    found = given(change=lambda p: p if p.name == "vane" else change(p, p.node_sets))
    lines = complaints(lambda: matched(found))
    for line, words in zip(lines, expected, strict=True):
        assert words in line


@pytest.mark.parametrize("held", ["neither", "vane"])
def test_something_must_be_clamped(given, held):
    """A ring in the air has no static answer; one whose vanes are clamped has."""

    def change(part):
        sets = {name: nodes for name, nodes in part.node_sets.items() if name != "fixed"}
        if part.name == held:
            sets["fixed"] = sets["output"][:1]
            sets["output"] = sets["output"][1:]
        return replace(part, node_sets=sets)

    found = given(ending=".inp", change=change)
    if held == "vane":
        assert len(matched(found).vane.node_sets["fixed"]) == 1
        return
    line = refusal(lambda: matched(found))
    assert line.startswith("casing (")
    assert "no clamped nodes: name the set in [casing.sets] fixed = ...; the file has " in line
    assert line.endswith("FORCE, HOOK_FRONT, HOOK_REAR, KEY, LEFT, OUTPUT, RIGHT, SOLID")


def test_faces_must_be_opposed(given, ring):
    """The casing laid over the vane instead of around it: its faces look the same way."""
    inside = ring("vane")
    names = {"left": "interlock_left", "right": "interlock_right", "force": "output"}
    sets = inside.node_sets | {name: inside.node_sets[own] for name, own in names.items()}
    sets["fixed"] = np.flatnonzero(inside.points[:, 2] < 1e-9)
    casing = replace(inside, name="casing", node_sets=sets)
    found = given(change=lambda part: part if part.name == "vane" else casing)
    lines = complaints(lambda: matched(found))
    assert len(lines) == 2
    assert "hook_front: at " in lines[0]
    assert "the faces are not opposed to those of vane (" in lines[0]
    assert " 180.0" in lines[0]


def test_anyones_sector(tmp_path, ring, write_mesh):
    """A cyclic sector from a file has the frequencies of the one that was written."""
    part = ring("casing")
    path = tmp_path / "sector.inp"
    write_mesh(path, part)
    found = read_sector(path, SECTORS, "mm")
    assert found.name == "sector"
    steel = fem.Material(E=210e9, nu=0.3, rho=7800)
    own, other = (fem.modes(fem.assemble(p, steel), 5, 2).frequency for p in (part, found))
    assert np.abs(other / own - 1).max() < 1e-10
    assert read_sector(path, unit="mm").sectors == 1
    # A deck's own names have capitals alone; whoever names a set need not.
    deck = read_mesh(path, "mm")
    assert "FIXED" in deck.node_sets
    np.testing.assert_array_equal(found.nodes("solid"), found.node_sets["SOLID"])
    np.testing.assert_array_equal(choose(deck.part(), ["Left"]).set("left"), deck.node_sets["LEFT"])
    for fixed in ("fixed", "Fixed"):
        assert fem.assemble(deck, steel, fixed).K.shape == fem.assemble(found, steel).K.shape
    capitals = replace(found, node_sets={n.upper(): each for n, each in found.node_sets.items()})
    again = fem.modes(fem.assemble(capitals, steel), 5, 2).frequency
    assert np.abs(again / own - 1).max() < 1e-10
    line = refusal(lambda: read_sector(path, SECTORS - 1, "mm"))
    assert ", right: 27 of 27 nodes are further than" in line
    write_mesh(path, replace(part, node_sets={"left": part.node_sets["left"]}))
    line = refusal(lambda: read_sector(path, SECTORS, "mm"))
    assert line.endswith("no set right; it has LEFT, SOLID")


def test_two_nodes_cannot_share_a_mate():
    own = np.array([[0.0, 0, 0], [0.001, 0, 0], [1, 0, 0]])
    other = np.array([[0.0, 0, 0], [1, 0, 0]])

    def mistakes(own, other):
        names = (lambda i: f"own {i}", lambda i: f"other {i}")
        return _mates(own, other, 0.01, ("A", "B"), names)[1]

    assert mistakes(own, other) == ["A: own 0 and own 1 both meet other 0 of B"]
    assert mistakes(other, own) == ["B: other 1 lies where another one meets A"]
    assert mistakes(own[[0, 2]], other) == []


@pytest.fixture
def read(tmp_path, write_mesh):
    """Function that writes a sector with the given sets and reads it as a user's."""

    def back(part, **sets):
        path = tmp_path / "sector.inp"
        faces = {name: part.node_sets[name] for name in ("left", "right")}
        write_mesh(path, replace(part, node_sets=faces | sets))
        return read_sector(path, part.sectors, "mm"), read_mesh(path, "mm")

    return back


def test_all_nodes_of_a_face_are_needed(ring, read, tmp_path):
    """Corner nodes alone, or half a face, are refused with their count and a pair of mates."""
    part = ring("casing")
    left, right = part.node_sets["left"], part.node_sets["right"]
    corners = np.unique(part.cells[:, :4])
    for kept in (np.isin(left, corners), np.arange(len(left)) < len(left) // 2):
        line = refusal(lambda kept=kept: read(part, left=left[kept], right=right[kept]))
        lost = len(left) - kept.sum()
        assert f", left and right: {lost} nodes of either face are missing, such as node" in line
        assert line.endswith("2π/12: all nodes of the cut faces are needed")
        found = read_mesh(tmp_path / "sector.inp", "mm")
        pair = line.split("such as node ")[1].split(", which meets node ")
        numbers = [int(pair[0]), int(pair[1].split()[0])]
        own, mate = (found.points[found.numbers == number][0] for number in numbers)
        assert np.linalg.norm(turn(12) @ own - mate) < 1e-7
        assert np.arctan2(own[1], own[0]) == pytest.approx(-np.pi / 12, abs=1e-7)
    line = refusal(lambda: read(part, left=left[1:], right=right[1:]))
    assert ": 1 node of either face is missing, such as" in line


def test_two_sectors(lattice, read):
    """In a ring of two, each cut node meets the other face's in both directions."""
    part = ring_sectors(lattice)("casing", sectors=2)
    found, _ = read(part)
    assert len(found.node_sets["left"]) == len(part.node_sets["left"])
    left, right = part.node_sets["left"], part.node_sets["right"]
    line = refusal(lambda: read(part, left=left[3:], right=right[3:]))
    assert ": 3 nodes of either face are missing" in line


def test_nodes_on_the_axis(lattice, read):
    """A quarter of a disc, whose nodes on the engine axis meet themselves, listed or not."""
    part = lattice((3, 3, 1), lambda p: 0.1 * p, sectors=4)
    part.node_sets.update(left=part.node_sets["y0"], right=part.node_sets["x0"])
    axis = np.intersect1d(part.node_sets["x0"], part.node_sets["y0"])
    assert len(axis) == 3
    for without in (axis[:0], axis):
        left, right = (np.setdiff1d(part.node_sets[name], without) for name in ("left", "right"))
        found, _ = read(part, left=left, right=right)
        assert len(found.node_sets["left"]) == len(left)
    line = refusal(lambda: read(part, left=left[1:], right=right[1:]))
    assert ": 1 node of either face is missing" in line


def test_clamped_mates(ring, read, tmp_path):
    """Mates are clamped together; those that are need not be listed."""
    part = ring("casing")
    left, right = part.node_sets["left"], part.node_sets["right"]
    both = np.concatenate([left[:5], right[:5]])
    found, _ = read(part, left=left[5:], right=right[5:], fixed=both)
    assert len(found.node_sets["left"]) == len(left) - 5
    for fixed, face in ((left[:3], left), (right[:3], right)):
        line = refusal(lambda fixed=fixed: read(part, fixed=fixed))
        assert f", fixed: at 3 of {len(left)} pairs of the cut faces one node is clamped" in line
        mesh = read_mesh(tmp_path / "sector.inp", "mm")
        number = int(line.split("such as node ")[1].split()[0])
        clamped = mesh.points[mesh.numbers == number][0]
        assert np.linalg.norm(part.points[face[:3]] - clamped, axis=1).min() < 1e-7
