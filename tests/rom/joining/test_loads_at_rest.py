"""Loads at rest of vane and casing, joined: displacements, reactions, nodal diameters in turn."""

import numpy as np
import pytest
import scipy.sparse as sp

from benchmarks.unreduced import unreduced_segment as unreduced
from tests.rom.block_in_rim import BLOCK, HOOK, LOCK, RIM, N
from vanelock import fem, rom
from vanelock.rom.joining.assembly import merged
from vanelock.stages.parts.segment import Segment

JOINTS = HOOK, LOCK


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
