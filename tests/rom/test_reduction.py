"""Craig-Bampton, cyclic symmetry and Tran against the unreduced sector."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sl

from vanelock import fem, rom
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.stages.parts.segment import Segment


@pytest.mark.parametrize("route", ["cyclic", "paper"])
def test_static_answer_to_master_loads_is_exact(ring_scene, route):
    """Constraint modes reproduce statics: x_m = (K⁻¹)_mm f_m of the full model."""
    model, casing = ring_scene.casing_model, ring_scene.casing
    nodes = casing.masters.node_sets["force"]
    f = np.zeros(model.K.shape[0])
    f[model.dofs[nodes, 0]] = 1.0
    T = fem.cyclic_transform(model, 0)
    full = T @ fem.factorise((T.conj().T @ model.K @ T).tocsc()).solve(np.asarray(T.conj().T @ f))
    # With every face dof kept the route that reduces the face spans all static answers, too.
    faces = 3 * int(np.sum(model.dofs[model.part.node_sets["left"], 0] >= 0))
    options = {} if route == "cyclic" else {"interface_modes": faces}
    whole = rom.reduce(
        model, ("hook_front", "force"), 0, nodal_diameters=[0], route=route, **options
    )
    g = np.zeros(whole.size)
    g[whole.dofs(nodes)[:, 0]] = 1.0
    x = np.linalg.solve(whole.at(0).K, g)
    expected = full[model.dofs[nodes]]
    np.testing.assert_allclose(x[whole.dofs(nodes)], expected.real, atol=1e-9 * abs(expected).max())
    # ... and the recovered field is the full one everywhere.
    field = rom.recovery(whole, model).displacement(x, 0)
    free = model.dofs >= 0
    assert np.abs(field[free] - full[model.dofs[free]]).max() < 1e-9 * np.abs(full).max()


@pytest.mark.parametrize(("k", "interlock"), [(0, "closed"), (1, "free"), (4, "free")])
def test_frequencies_against_the_unreduced_sector(ring_scene, k, interlock):
    """A ROM is a Ritz model: never below the truth, and close to it for the first six modes."""
    truth, _ = ring_scene.truth(k, interlock)
    closed = ~ring_scene.interlock if interlock == "free" else None
    found, _ = rom.linear_modes(ring_scene.system, k, 6, closed)
    error = found / truth - 1
    assert np.all(error > -1e-9)
    assert error[1] < 0.02  # ten face modes by the published basis
    assert np.all(error < 0.1)


def test_published_face_modes_by_their_definition(ring_scene):
    """The face coordinates' block of the cyclic Guyan model is diagonal: its own modes."""
    masters = tuple(ring_scene.casing.masters.node_sets)
    part = rom.reduce(ring_scene.casing_model, masters, 0, nodal_diameters=[1], route="paper")
    casing, b = part.at(1), part.interface_modes
    m = 3 * len(part.masters.nodes)
    K = casing.K[: b + m, : b + m]
    # Condense the other masters: what is left is Φᴴ S Φ = Ω², positive and ascending.
    S = K[:b, :b] - K[:b, b:] @ np.linalg.solve(K[b:, b:], K[b:, :b])
    off = S - np.diag(np.diag(S))
    assert np.abs(off).max() < 1e-7 * np.abs(np.diag(S)).max()
    assert np.all(np.diff(np.diag(S).real) > 0)


def test_conjugate_diameters(ring_scene):
    """ND k and N-k have the same frequencies and conjugate matrices."""
    a, b = ring_scene.system.at(1), ring_scene.system.at(7)
    np.testing.assert_array_equal(a.K, b.K.conj())
    masters = tuple(ring_scene.casing.masters.node_sets)
    casing = rom.reduce(ring_scene.casing_model, masters, 4, nodal_diameters=[1, 7])
    system = Segment(ring_scene.joints, -1, force=30.0, damping_ratio=0.003).join(
        ring_scene.vane, casing
    )
    forward, backward = (sl.eigvalsh(system.at(k).K, system.at(k).M) for k in (1, 7))
    np.testing.assert_allclose(backward, forward, rtol=1e-7, atol=1e-6 * forward[5])
    assert system.nodal_diameter(1) == 7
    assert np.isrealobj(ring_scene.system.at(0).K)
    assert np.isrealobj(ring_scene.system.at(4).K)


def test_recovered_mode_is_the_unreduced_one(ring_scene):
    """Mode 2 of ND 1, recovered on every node, has a MAC of 1 with the unreduced eigenvector."""
    _, vectors = ring_scene.truth(1, "free")
    _, shapes = rom.linear_modes(ring_scene.system, 1, 2, ~ring_scene.interlock)
    own = ring_scene.system.at(1).split(shapes[:, 1])
    fields = {}
    for model, component, q in (
        (ring_scene.vane_model, ring_scene.vane, own["block"]),
        (ring_scene.casing_model, ring_scene.casing, own["rim"]),
    ):
        fields[component.masters.part] = rom.recovery(component, model).displacement(q, 1)
        nodes = component.masters.nodes
        np.testing.assert_allclose(
            fields[component.masters.part][nodes], q[component.dofs(nodes)], rtol=1e-12
        )
    # Kinetic energy of the recovered fields is that of the reduced coordinates (normalised to 1).
    energy = 0.0
    for model in (ring_scene.vane_model, ring_scene.casing_model):
        u = fields[model.part.name][model.dofs >= 0]
        x = np.zeros(model.K.shape[0], complex)
        x[model.dofs[model.dofs >= 0]] = u
        energy += (x.conj() @ (model.M @ x)).real
    assert energy == pytest.approx(1.0, abs=1e-9)
    # The cyclic face condition holds on all nodes.
    part = ring_scene.casing_model.part
    u = fields["rim"]
    turned = u[part.node_sets["left"]] @ turn(8).T * np.exp(-2j * np.pi / 8)
    np.testing.assert_allclose(u[part.node_sets["right"]], turned, atol=1e-12 * np.abs(u).max())
    # Vane part of the eigenvector: the vane's free coordinates follow the casing's.
    vane = ring_scene.vane_model
    merged = vane.dofs[vane.part.node_sets["key"]].ravel()
    rest = np.setdiff1d(np.arange(vane.K.shape[0]), merged)
    expected = vectors[-len(rest) :, 1]
    found = np.zeros(vane.K.shape[0], complex)
    found[vane.dofs] = fields["block"]
    a, b = expected, found[rest]
    assert abs(np.vdot(a, b)) ** 2 / (np.vdot(a, a) * np.vdot(b, b)).real > 0.9999


def test_sets_that_cannot_be_masters_are_refused(ring_scene):
    with pytest.raises(InputError, match="no node set 'hooks'"):
        rom.reduce(ring_scene.vane_model, ("hooks",))
    with pytest.raises(InputError, match="is clamped"):
        rom.reduce(ring_scene.casing_model, ("z",))


def test_faces_that_do_not_match_are_refused(ring_scene):
    model = ring_scene.casing_model
    sets = model.part.node_sets
    shuffled = replace(model.part, node_sets={**sets, "right": sets["right"][::-1]})
    with pytest.raises(InputError, match="must match node by node"):
        rom.reduce(replace(model, part=shuffled), ("force",), nodal_diameters=[0])
    other = replace(model.part, sectors=10)
    with pytest.raises(InputError, match="must match node by node"):
        rom.reduce(replace(model, part=other), ("force",), nodal_diameters=[0])
