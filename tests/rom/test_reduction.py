"""Reduced parts: static answers, another modulus, arguments that cannot be used."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sl
import scipy.sparse as sp

from tests.refusals import refused
from vanelock import fem, rom
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


N = 8
FACTOR = 0.71
ROUTES = [
    {},
    {"modes": 6},
    {"accuracy": 1e-3},
    {"modes": 6, "route": "paper", "interface_modes": 5},
]


def hotter(model):
    """The model assembled anew with another modulus."""
    metal = model.material
    fixed = "z0" if "z0" in model.part.node_sets and (model.dofs < 0).any() else None
    softer = fem.Material(FACTOR * metal.E, metal.nu, metal.rho)
    return fem.assemble(model.part, softer, fixed=fixed)


def answers(component, k):
    """What no choice of basis changes: frequencies, Hz, and the masters' dynamic compliance.

    The compliance is that of springs at the masters, at three frequencies.
    """
    reduced, first = component.at(k), component.interface_modes
    masters = slice(first, first + 3 * len(component.masters.nodes))
    squared = sl.eigvalsh(reduced.K, reduced.M)
    K = np.array(reduced.K)
    K[masters, masters] += 1e8 * np.eye(masters.stop - masters.start)
    found = []
    for ratio in (0.0, 0.3, 1.1):
        D = K - ratio * squared[7] * reduced.M
        found.append(np.linalg.inv(D)[masters, masters])
    return np.sqrt(squared.clip(0)) / (2 * np.pi), np.array(found)


def same(a, b, k):
    (f, x), (g, y) = answers(a, k), answers(b, k)
    np.testing.assert_allclose(f, g, rtol=1e-8, atol=1e-6 * f[-1])
    np.testing.assert_allclose(x, y, rtol=0, atol=1e-8 * np.abs(x).max())


@pytest.mark.parametrize("options", ROUTES, ids=str)
def test_a_sector_reduced_again_is_the_same(ring_sector, options):
    """At real and complex nodal diameters, by every route and choice of vectors."""
    model, diameters = ring_sector(sectors=N), (0, 1, N // 2)
    scaled = rom.stiffened(
        rom.reduce(model, ("force",), nodal_diameters=diameters, **options), FACTOR
    )
    again = rom.reduce(hotter(model), ("force",), nodal_diameters=diameters, **options)
    assert scaled.size == again.size
    for k in (*diameters, N - 1):
        same(scaled, again, k)
    if again.band is not None:
        assert scaled.band == pytest.approx(again.band, rel=1e-3)  # of rough modes
    if again.at(1).complete is not None:
        assert scaled.at(1).complete == pytest.approx(again.at(1).complete, rel=1e-8)


def test_what_is_left_out_scales_too(ring_sector):
    """ε = qᴴ (G₀ - θ G₁ + θ² G₂) q at the reduced modes, of the part reduced again."""
    model = ring_sector(sectors=N)
    scaled, again = (
        rom.reduce(each, ("force",), 4, nodal_diameters=[1]) for each in (model, hotter(model))
    )
    scaled = rom.stiffened(scaled, FACTOR)
    left = []
    for part in (scaled, again):
        reduced = part.at(1)
        theta, q = sl.eigh(reduced.K, reduced.M)
        G = [np.einsum("ij,ik,kj->j", q.conj(), each, q).real for each in reduced.neglected]
        left.append(G[0] - theta * G[1] + theta**2 * G[2])
    assert left[0][:8].max() > 0
    np.testing.assert_allclose(left[0], left[1], rtol=1e-7, atol=1e-9 * left[1].max())


@pytest.mark.parametrize("options", [{}, {"modes": 5}, {"cutoff": 3000.0}], ids=str)
def test_a_part_in_one_piece(bar, options):
    model = bar()
    given = dict(options)
    scaled = rom.stiffened(rom.reduce(model, ("held",), **given), FACTOR)
    if "cutoff" in given:
        given["cutoff"] *= FACTOR**0.5
    same(scaled, rom.reduce(hotter(model), ("held",), **given), 0)


def test_recovered_shapes_stay(ring_sector):
    """The same coordinates are the same displacements of the hotter part, at s times the stress."""
    model = ring_sector(sectors=N)
    part = rom.reduce(model, ("force",), 6, nodal_diameters=[1])
    q = np.random.default_rng(1).standard_normal(part.size) + 0j
    cold, hot = (
        rom.recovery(each, other)
        for each, other in ((part, model), (rom.stiffened(part, FACTOR), hotter(model)))
    )
    u = cold.displacement(q, 1)
    np.testing.assert_allclose(hot.displacement(q, 1), u, atol=1e-9 * np.abs(u).max())
    stress = cold.stress(q, 1)
    expected = FACTOR * stress
    np.testing.assert_allclose(hot.stress(q, 1), expected, atol=1e-9 * np.abs(stress).max())


@pytest.mark.parametrize("factor", [0.0, -1.0, np.inf, np.nan])
def test_a_factor_that_is_none(bar, factor):
    with pytest.raises(InputError, match="factor = .*: Young's modulus must stay > 0"):
        rom.stiffened(rom.reduce(bar(), ("held",), 3), factor)


CYCLIC = {"nodal_diameters": [0, 1]}
PAPER = {**CYCLIC, "route": "paper"}


def refusal(model, *arguments, **options):
    text = refused(".", rom.reduce, model, *arguments, **options)
    assert len(text) < 250
    return text


@pytest.mark.parametrize(("masters", "options", "message"), [
    (("forces",), CYCLIC, "ring: no node set 'forces'; it has force, inner"),
    (("left",), CYCLIC, "is a master and on a cyclic face"),
    (("z0",), CYCLIC, "is clamped"),
    (("inner",), CYCLIC, "ring: no node is left beside masters and cyclic faces"),
    (("force",), {**CYCLIC, "averaged": ("force",)}, "no contact patches of 'force'"),
    (("force",), {"nodal_diameters": []}, "nodal_diameters: given none: needs one"),
    (("force",), {**CYCLIC, "modes": -1}, "modes = -1: allowed are 0 and more"),
    (("force",), {**CYCLIC, "modes": 205}, "205 fixed-interface modes of 204 slave dofs"),
    (("force",), {"modes": 10**6}, "1000000 fixed-interface modes of 240 slave dofs"),
    (("force",), {**PAPER, "modes": 169}, "169 fixed-interface modes of 168 slave dofs"),
    (("force",), {"cutoff": 0}, "cutoff = 0 Hz: must be > 0"),
    (("force",), {"cutoff": float("inf")}, "cutoff = inf Hz: must be > 0 and finite"),
    (("force",), {"accuracy": 0.0}, "accuracy = 0: allowed are 1e-9 to 1"),
    (("force",), {"accuracy": 1e-12}, "accuracy = 1e-12: allowed are 1e-9 to 1"),
    (("force",), {"accuracy": 1.0}, "accuracy = 1: allowed are 1e-9 to 1"),
    (("force",), {"band": 0.0}, "band = 0 Hz: must be > 0"),
    (("force",), {"band": -5.0}, "band = -5 Hz: must be > 0"),
    (("force",), {"route": "paper"}, 'route = "paper": a part in one piece has none'),
    (("force",), {"modes": 3, "band": 5.0}, "band = 5 Hz: goes with accuracy only"),
    (("force",), {"cutoff": 9.0, "band": 5.0}, "band = 5 Hz: goes with accuracy only"),
    (("force",), {**PAPER, "band": 5.0}, "band = 5 Hz: goes with accuracy only"),
    (("force",), {"modes": 3, "cutoff": 5.0, "accuracy": 0.1},
     "modes = 3 and cutoff = 5 and accuracy = 0.1: give one of modes, cutoff and accuracy"),
    (("force",), {**PAPER, "accuracy": 0.1}, 'accuracy needs route = "cyclic"'),
    (("force",), {**CYCLIC, "route": "quick"}, "route: given 'quick': needs 'cyclic' or"),
    (("force",), {**PAPER, "interface_modes": 0}, "interface_modes = 0: allowed are 1"),
    (("force",), {**PAPER, "interface_modes": 37}, "allowed are 1 to 36, the dofs of a face"),
    (("force",), {**CYCLIC, "interface_modes": 5}, 'the route "cyclic" has no interface'),
    (("force",), {"interface_modes": 5}, "a part in one piece has no interface"),
])  # fmt: skip
def test_message_names_argument_value_and_what_is_allowed(ring_sector, masters, options, message):
    refused(message, rom.reduce, ring_sector(), masters, **options)
    refusal(ring_sector(), masters, **options)


@pytest.mark.parametrize("masters", [(), ("force",)])
def test_what_is_not_held_is_named(ring_sector, masters):
    """A free ring: without masters nothing holds it, at each diameter of a rigid-body motion."""
    ring = ring_sector(clamped=False)
    if masters:
        assert rom.reduce(ring, masters, 3, nodal_diameters=range(4)).fixed_modes == 3
        return
    for k in (0, 1):
        text = refusal(ring, masters, 3, nodal_diameters=[k])
        assert "ring: free to move as a rigid body: 2 motions not held" in text
        assert f"(at nodal diameter {k}, the masters held)" in text
    assert rom.reduce(ring, masters, 3, nodal_diameters=[2, 3]).fixed_modes == 3
    text = refusal(ring, masters, 3)
    assert "ring: free to move as a rigid body: 6 motions not held" in text


@pytest.mark.parametrize("route", ["cyclic", "paper"])
def test_a_node_without_stiffness_is_named_by_every_route(ring_sector, route):
    model = ring_sector()
    node = model.part.node_sets["inner"][-1]
    kept = np.ones(model.K.shape[0])
    kept[model.dofs[node]] = 0
    K = sp.csc_array(sp.diags_array(kept) @ model.K @ sp.diags_array(kept))
    with pytest.raises(InputError, match=f"ring: 3 motions of some nodes .*: node {node} "):
        rom.reduce(replace(model, K=K), ("force",), 2, nodal_diameters=[1], route=route)
