"""Contact rows of rigid motions, stiffness per area, diameters united, joined loads at rest."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp

from benchmarks.unreduced import unreduced_segment as unreduced
from tests.refusals import refused
from tests.rom.block_in_rim import BLOCK, HOOK, LOCK, RIM, N
from vanelock import fem, rom
from vanelock.common.errors import InputError
from vanelock.nonlinear import Options, frequency_response
from vanelock.rom.component import Masters
from vanelock.rom.joining.assembly import merged
from vanelock.rom.joining.connections import properties
from vanelock.stages.parts.segment import Joint, Segment


def ring_motion(points, kind, sectors):
    """Sector 0's coefficients of a rigid motion of the ring, and its nodal diameter.

    A translation along the fixed direction e_x - i e_y, seen by sector j in its own frame (turned
    by 2πj/N), is sector 0's times e^{-2πij/N}: nodal diameter 1.
    """
    u = np.zeros((len(points), 3), complex)
    if kind == "axial translation":
        u[:, 2] = 1.0
        return u, 0
    if kind == "turn about the axis":
        u[:, 0], u[:, 1] = -points[:, 1], points[:, 0]
        return u, 0
    turning = np.array([1.0, -1.0j, 0.0])
    for j in (1, 2):  # the claim above, by rotating the direction into sector j's frame
        a = 2 * np.pi * j / sectors
        back = np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]])
        np.testing.assert_allclose(back @ turning, turning * np.exp(-1j * a), atol=1e-14)
    if kind == "lateral translation":
        return u + turning, 1
    tilt = np.cross(turning, points)
    return u + tilt, 1


@pytest.mark.parametrize(
    "kind", ["axial translation", "turn about the axis", "lateral translation", "tilt"]
)
def test_rigid_motion_of_the_ring_moves_no_contact(masters_alone, kind):
    vane, casing, system = masters_alone.vane, masters_alone.casing, masters_alone.system
    x_vane, k = ring_motion(vane.masters.points, kind, system.sectors)
    x_casing, _ = ring_motion(casing.masters.points, kind, system.sectors)
    x = np.zeros(len(system.at(k).K), complex)
    joined = masters_alone.joined_dofs
    x[joined[vane.dofs(vane.masters.nodes).ravel()]] = x_vane.ravel()
    x[casing.dofs(casing.masters.nodes).ravel()] = x_casing.ravel()
    relative = system.contact_rows(k) @ x
    assert np.abs(relative).max() < 1e-12 * np.abs(x).max()
    # ... but the next sector's rows matter: without them the interlock would seem to slide.
    interlock = np.array([name == "interlock" for name in system.contacts.joint])
    assert np.abs(system.at(k).own[interlock] @ x).max() > 0.1 * np.abs(x).max()


def test_vane_moved_towards_its_mates_closes_the_contacts(masters_alone):
    """A pure outward motion of the vane closes the roof bands and opens the lip bands."""
    vane, system = masters_alone.vane, masters_alone.system
    points = vane.masters.points
    radial = points * [1, 1, 0] / np.hypot(points[:, 0], points[:, 1])[:, None]
    x = np.zeros(len(system.at(0).K))
    x[masters_alone.joined_dofs[vane.dofs(vane.masters.nodes)]] = radial
    hook = np.array([name == "hook" for name in system.contacts.joint])
    v = (system.contact_rows(0) @ x)[hook, 0]
    np.testing.assert_allclose(v, np.tile(np.repeat([1.0, -1.0], 14), 2), atol=1e-12)


def test_neighbours_pressed_together_close_the_interlock(masters_alone):
    """A vane whose right face alone moves towards the neighbour gains its normal component."""
    vane, system = masters_alone.vane, masters_alone.system
    right = vane.masters.node_sets["interlock_right"]
    frames = vane.masters.frames["interlock_right"]
    x = np.zeros(len(system.at(0).K))
    x[masters_alone.joined_dofs[vane.dofs(right)]] = frames[:, 0]
    interlock = np.array([name == "interlock" for name in system.contacts.joint])
    relative = (system.contact_rows(0) @ x)[interlock]
    np.testing.assert_allclose(relative, np.tile([1.0, 0.0, 0.0], (10, 1)), atol=1e-12)


AREAS = {"hook_front": np.array([1e-6, 2e-6, 4e-6]), "hook_rear": np.array([3e-6])}


def side(name, areas):
    points = np.array([[1.0, 0, 0], [1, 0.1, 0], [1, 0.2, 0], [1, 0, 0.1]])
    frames = np.tile(np.eye(3), (4, 1, 1))
    return Masters(
        part=name,
        sectors=8,
        nodes=np.arange(4),
        points=points,
        node_sets={"hook_front": np.arange(3), "hook_rear": np.array([3]), "key": np.array([1])},
        frames={"hook_front": frames[:3], "hook_rear": frames[:1]},
        areas=areas,
    )


def stiffness(areas, **options):
    joint = Joint("hook", kn=7.0, kt=5.0, mu=0.3, interference=0.0, **options)
    vane, casing = side("vane", areas), side("casing", {})
    pairs = joint.pairs(SimpleNamespace(masters=vane), SimpleNamespace(masters=casing))
    return properties(list(pairs))


def test_each_pair_has_its_nodes_area():
    """The second node of the front hook is tied and has no contact."""
    found = stiffness(AREAS, kn_area=1e12)
    assert found.kn == pytest.approx([1e6, 4e6, 3e6], rel=1e-15)
    assert (found.kt == 5.0).all()
    found = stiffness(AREAS, kt_area=1e11)
    assert (found.kn == 7.0).all()
    assert found.kt == pytest.approx(np.array([[1e5] * 2, [4e5] * 2, [3e5] * 2]), rel=1e-15)


def test_sets_without_areas_are_refused():
    assert (stiffness({}).kn == 7.0).all()
    with pytest.raises(InputError, match='joint "hook": a stiffness per area needs contact sets'):
        stiffness({"hook_front": AREAS["hook_front"]}, kn_area=1e12)


JOINTS = HOOK, LOCK
BAND = 1e4


@pytest.fixture(scope="module")
def one_by_one(ring_scene):
    """Systems at the nodal diameters 2, 0 and 1, the casing prepared once."""
    model = ring_scene.casing_model
    prepared = rom.prepare(model, RIM)
    systems = []
    for k in (2, 0, 1):
        casing = rom.reduce(model, RIM, nodal_diameters=[k], band=BAND, prepared=prepared)
        systems.append(Segment(JOINTS, 1, 30.0, damping_ratio=0.003).join(ring_scene.vane, casing))
    return systems


def test_a_prepared_part_reduces_as_an_unprepared_one(ring_scene, one_by_one):
    alone = rom.reduce(ring_scene.casing_model, RIM, nodal_diameters=[2], band=BAND)
    system = Segment(JOINTS, 1, 30.0, damping_ratio=0.003).join(ring_scene.vane, alone)
    for name in ("K", "M", "own", "next", "output"):
        expected, found = getattr(system.at(2), name), getattr(one_by_one[0].at(2), name)
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max())


def test_united_diameters_respond_as_those_reduced_together(ring_scene, one_by_one):
    united = rom.united(one_by_one)
    assert sorted(united.diameters) == [0, 1, 2]
    sizes = {len(found.K) for found in united.diameters.values()}
    assert len(sizes) > 1  # or this shows less than it says
    hertz = [1110.0, 1140.0]  # on both sides of the first two resonances
    found = frequency_response(united, hertz, Options(2))
    expected = frequency_response(ring_scene.system, hertz, Options(2))
    # Both are within the same accuracy of reduction, 1e-4 at most.
    np.testing.assert_allclose(found.amplitude, expected.amplitude, rtol=1e-4)


def test_the_load_comes_with_its_own_diameter(one_by_one):
    united = rom.united(one_by_one)
    assert len(united.force[1].vector) == len(united.at(1).K)
    assert not rom.united(one_by_one[:2]).force


def test_systems_of_different_scenes_do_not_unite(one_by_one):
    first, second, third = one_by_one
    refused("nodal diameter 2 comes twice", rom.united, [first, third, first])
    refused("differ in engine_order", rom.united, [first, second, replace(third, engine_order=2)])
    refused("no systems given", rom.united, [])


def test_another_model_or_other_masters_were_not_prepared(ring_scene):
    prepared = rom.prepare(ring_scene.casing_model, RIM)
    with pytest.raises(InputError, match="give the same model, masters and averaged sets"):
        rom.reduce(
            ring_scene.casing_model, RIM[:2], modes=2, nodal_diameters=[0], prepared=prepared
        )


@pytest.fixture(scope="module")
def loaded(ring_scene):
    """Loads of both parts, the parts that hold them, and the casing at other diameters."""
    loads = {
        "vane": {
            "gas": fem.centrifugal(ring_scene.vane_model, 100.0),
            "heat": fem.thermal(ring_scene.vane_model, 4e-3),
        },
        "casing": {"heat": fem.thermal(ring_scene.casing_model, 2e-3)},
    }
    vane = rom.reduce(ring_scene.vane_model, BLOCK, modes=10, loads=loads["vane"])
    prepared = rom.prepare(ring_scene.casing_model, RIM)

    def casing(k):
        return rom.reduce(
            ring_scene.casing_model,
            RIM,
            modes=10,
            nodal_diameters=[k],
            prepared=prepared,
            loads=loads["casing"] if k == 0 else None,
        )

    return loads, vane, {k: casing(k) for k in (0, 1)}


def test_joined_parts_move_at_rest_as_the_unreduced_sector(ring_scene, loaded):
    loads, vane, casings = loaded
    casing = casings[0]
    system = Segment(JOINTS, N, 30.0).join(vane, casing)
    K, _ = unreduced(ring_scene.vane_model, ring_scene.casing_model, JOINTS, 0)
    T = sp.csr_array(fem.cyclic_transform(ring_scene.casing_model, 0))
    f = {part: sum(each.values()) for part, each in loads.items()}
    mates, keys = casing.masters.node_sets["key"], vane.masters.node_sets["key"]
    mate = T.indices[T.indptr[ring_scene.casing_model.dofs[mates]]]
    own = T.shape[1] + ring_scene.vane_model.dofs[keys]
    places = merged(
        (T.shape[1], len(f["vane"])), [np.column_stack([mate.ravel(), own.ravel()])]
    ).places
    load = np.zeros(K.shape[0], complex)
    np.add.at(load, places[0], T.conj().T @ f["casing"])
    np.add.at(load, places[1], f["vane"])
    full = fem.factorise(K).solve(load)

    one = system.at(0)
    rows = system.contact_rows(0)
    held = one.K + np.einsum("cdi,cd,cdj->ij", rows.conj(), system.contacts.stiffness, rows)
    x = np.linalg.solve(held, system.force[0].vector)
    for part, q, model, u in (
        (vane, one.split(x)["block"], ring_scene.vane_model, full[places[1]]),
        (casing, one.split(x)["rim"], ring_scene.casing_model, T @ full[places[0]]),
    ):
        found = rom.recovery(part, model).displacement(q, 0)
        assert np.abs(found - model.field(u)).max() < 1e-10 * np.abs(full).max()

    # Forces of contacts and ties on the vane balance what loads it: along the axis, and about it.
    q = one.split(x)["block"]
    reaction = vane.at(0).K @ q - sum(vane.loads.values())
    nodes = vane.masters.nodes
    force = reaction[vane.dofs(nodes)].real
    applied = ring_scene.vane_model.field(f["vane"])
    points, places = ring_scene.vane_model.part.points, vane.masters.points
    scale = np.abs(applied).sum()
    assert np.abs(force.sum(axis=0) + applied.sum(axis=0)).max() < 1e-9 * scale
    turning = np.cross(places, force).sum(axis=0) + np.cross(points, applied).sum(axis=0)
    assert np.abs(turning).max() < 1e-9 * scale


def test_loads_are_those_of_nodal_diameter_0_however_diameters_come(loaded):
    _, vane, casings = loaded
    alone = {k: Segment(JOINTS, 1, 30.0).join(vane, casing) for k, casing in casings.items()}
    assert set(alone[0].force) == {0}
    assert set(alone[1].force) == {1}
    by_name = Segment(JOINTS).assembly(vane, casings[0]).rest_loads()
    assert list(by_name) == ["heat", "gas"]
    for order in ((0, 1), (1, 0)):
        united = rom.united([alone[k] for k in order])
        assert np.array_equal(united.force[0].vector, by_name["heat"] + by_name["gas"])
        assert np.array_equal(united.force[1].vector, alone[1].force[1].vector)
