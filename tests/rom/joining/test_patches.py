"""Patch means as degrees of freedom against constraint equations, and in the vane."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from benchmarks.unreduced import unreduced_segment
from tests.rom.block_in_rim import patched
from vanelock import fem, rom
from vanelock.common.errors import InputError
from vanelock.mesh.contact_patches import _averages, _Patch, _plane
from vanelock.rom.component import choose
from vanelock.rom.joining.connections import tied_nodes
from vanelock.rom.routes.problem import _patch_transform, _patch_weights, with_means
from vanelock.stages.parts.segment import Joint, Segment

HOOKS = ("hook_front", "hook_rear")
INTERLOCK = ("interlock_left", "interlock_right")
STEEL = fem.Material(E=170e9, nu=0.3, rho=8200.0)


def strip(start, end):
    """0 to 1 in y between two places in x."""
    planes = np.array([[-1, 0, 0, -start], [1, 0, 0, end], [0, -1, 0, 0], [0, 1, 0, 1]], float)
    return _Patch(planes, end - start, np.array([(start + end) / 2, 0.5, 0.0]))


@pytest.fixture(scope="module")
def block(lattice):
    """A clamped cube and three contact nodes on its top, whose patches cut through elements."""
    part = lattice((3, 2, 2))
    places = np.array([[x, 0.5, 0.0] for x in (1 / 6, 0.5, 5 / 6)])
    contact = np.argmin(np.linalg.norm(part.points[:, None] - places, axis=2), axis=0)
    top = _plane(part.points, part.cells, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    patches = [strip(0.0, 0.3), strip(0.3, 0.7), strip(0.7, 1.0)]
    weights = _averages("block", part.points, part.cells, top, patches)
    sets = {"fixed": part.node_sets["z1"], "contact": contact, "corner": np.array([0])}
    part = replace(part, node_sets=sets, patches={"contact": sp.csc_array(weights)})
    model = fem.assemble(part, STEEL)
    W = sp.kron(weights[:, model.dofs[:, 0] >= 0], sp.eye_array(3)).tocsc()
    return SimpleNamespace(model=model, W=W, contact=contact)


def test_the_dofs_of_contact_nodes_become_means(block):
    model, n = block.model, block.model.K.shape[0]
    T = _patch_transform(model, block.contact)
    z = np.random.default_rng(0).standard_normal(n)
    u = model.field(T @ z)
    means = _patch_weights(model.part, block.contact) @ u
    np.testing.assert_allclose(means, z[model.dofs[block.contact]], atol=1e-13)
    # A change of variables: nothing is lost, and most displacements stay what they are.
    assert np.linalg.cond(T.toarray()) < 1e3
    kept = np.all(u == np.concatenate([z, [0.0]])[model.dofs], axis=1)
    assert np.sum(~kept) <= 2 * len(block.contact)
    assert np.array_equal(u[0], z[model.dofs[0]])  # a node of another set


def test_statics_with_held_means_are_those_of_lagrange_multipliers(block):
    """[K Wᵀ; W 0] with prescribed means and a load: displacements, and the force on each mean."""
    model, W, n = block.model, block.W, block.model.K.shape[0]
    rng = np.random.default_rng(1)
    load, prescribed = rng.standard_normal(n), rng.standard_normal(W.shape[0]) * 1e-11
    saddle = sp.block_array([[model.K, W.T], [W, None]], format="csc")
    exact = spsolve(saddle, np.concatenate([load, prescribed]))
    T, K, _ = with_means(model, block.contact)
    held = model.dofs[block.contact].ravel()
    free = np.setdiff1d(np.arange(n), held)
    z = np.zeros(n)
    z[held] = prescribed
    assert T is not None
    f = T.T @ load
    z[free] = fem.factorise(K[free][:, free]).solve((f - K @ z)[free])
    np.testing.assert_allclose(T @ z, exact[:n], atol=1e-11 * np.abs(exact[:n]).max())
    reaction = (K @ z - f)[held]
    np.testing.assert_allclose(reaction, -exact[n:], atol=1e-9 * np.abs(exact[n:]).max())


def test_frequencies_with_held_means_are_those_of_the_null_space(block):
    """Modes of the cube among all displacements whose means vanish: ZᵀKZ, W Z = 0."""
    model = block.model
    Z = scipy.linalg.null_space(block.W.toarray())
    exact = scipy.linalg.eigh(Z.T @ (model.K @ Z), Z.T @ (model.M @ Z), eigvals_only=True)
    _, K, M = with_means(model, block.contact)
    free = np.setdiff1d(np.arange(K.shape[0]), model.dofs[block.contact].ravel())
    found, _ = fem.eigenpairs(K[free][:, free], M[free][:, free], 6)
    np.testing.assert_allclose(found, exact[:6], rtol=1e-9)


def test_matrices_without_means_are_the_model_s(block):
    T, K, M = with_means(block.model, np.empty(0, np.int64))
    assert T is None
    assert K is block.model.K
    assert M is block.model.M


def test_matrices_with_means_are_symmetric(block):
    _, K, M = with_means(block.model, block.contact)
    for A in (K, M):
        assert abs(A - A.T).max() == 0.0


def test_a_node_without_a_patch_is_refused(block):
    with pytest.raises(InputError, match="tetra10: contact node 0 has no patch"):
        _patch_weights(block.model.part, np.array([0]))
    with pytest.raises(InputError, match="no contact patches of 'corner'; it has contact"):
        choose(block.model.part, ("corner",), ("corner",))


def test_patches_that_the_mesh_cannot_tell_apart_are_refused(block):
    model = block.model
    same = sp.csc_array(model.part.patches["contact"].toarray()[[0, 1, 1]])
    model = replace(model, part=replace(model.part, patches={"contact": same}))
    with pytest.raises(InputError, match="tetra10: the mesh is too coarse to resolve"):
        _patch_transform(model, block.contact)


@pytest.fixture(scope="module")
def parts(coarse):
    # Their facets differ off the bands.
    return SimpleNamespace(vane=coarse[0], casing=coarse[1])


STIFF = [Joint(name, 1e7, 1e7, 0.3, 1e-5) for name in ("hook", "interlock")]


def with_masters(parts, of_vane, of_casing):
    means = (parts.vane, of_vane), (parts.casing, of_casing)
    return [SimpleNamespace(masters=choose(p, tuple(p.node_sets), of)) for p, of in means]


def test_mates_stand_at_their_patches_centroids(parts):
    """There the pairs of both parts coincide to round-off, 1 mm from the band."""
    pieces = with_masters(parts, HOOKS + INTERLOCK, HOOKS)
    vane = pieces[0].masters
    pairs = [each for joint in STIFF for each in joint.pairs(*pieces)]
    assert sum(len(each.own_nodes) for each in pairs) == 66
    front = vane.node_sets["hook_front"]
    assert vane.position(front)[:, 2] == pytest.approx(np.full(30, 0.075))
    assert parts.vane.points[front, 2] == pytest.approx(np.full(30, 0.074))
    assert len(vane.averaged) == 80


def test_patches_on_one_side_of_a_joint_are_refused(parts):
    for of_vane, of_casing, joint, name in (
        (HOOKS, (), 0, "hook_front"),
        (HOOKS, HOOKS[:1], 0, "hook_rear"),
        ((), HOOKS[1:], 0, "hook_rear"),
        (INTERLOCK[:1], (), 1, "interlock_right"),
    ):
        pieces = with_masters(parts, of_vane, of_casing)
        with pytest.raises(InputError, match=f"{name}: a patch on one side and a node on the"):
            list(STIFF[joint].pairs(*pieces))
    vane, casing = with_masters(parts, HOOKS[:1], HOOKS[1:])
    with pytest.raises(InputError, match="key: a patch on one side and a node on the other"):
        tied_nodes(vane, "key", casing, "key")


@pytest.fixture(scope="module")
def small(lattice):
    """A block in a rim: their facets differ everywhere."""
    vane, casing = patched(lattice)
    return SimpleNamespace(vane=vane, casing=casing)


@pytest.mark.parametrize("k", [0, 1])
def test_unreduced_means_move_rigidly(small, k):
    """Springs between means leave the ring's translations along and across its axis free."""
    free = replace(small.casing, node_sets={**small.casing.node_sets, "fixed": np.empty(0, int)})
    models = fem.assemble(small.vane, STEEL), fem.assemble(free, STEEL)
    joints = [Joint(name, 1e9, 1e9, 0.3, 1e-5) for name in ("hook", "interlock")]
    K, M = unreduced_segment(*models, joints, k, HOOKS + INTERLOCK)
    values, _ = fem.eigenpairs(K, M, 4, shift=-1e4)
    # ND 0: translation along the axis and rotation about it; ND 1: across it, and tilt.
    assert np.abs(values[:2]).max() < 1e-2  # (rad/s)²
    assert values[2] > 1e5


SPRINGS = (Joint("hook", 1.67e7, 1.67e7, 0.3, 2e-5), Joint("interlock", 1e6, 1e6, 0.3, 0))


@pytest.fixture(scope="module")
def unreduced(small):
    """Models of both parts, and six frequencies of the sector, rad/s."""
    models = fem.assemble(small.vane, STEEL), fem.assemble(small.casing, STEEL)
    squared, _ = fem.eigenpairs(*unreduced_segment(*models, SPRINGS, 1, HOOKS + INTERLOCK), 6)
    return models, np.sqrt(squared)


FORTY = {"modes": 40}
PAPER = {"route": "paper", "interface_modes": 40}


@pytest.mark.parametrize(
    ("keep", "how", "close"),
    [({"accuracy": 1e-4}, {}, 1e-4), (FORTY, PAPER, 2e-3)],
    ids=["cyclic", "paper"],
)
def test_reduced_sector_with_means_matches_the_unreduced_one(unreduced, keep, how, close):
    """Frequencies of the joined sector; and the recovered field has the means that masters say."""
    models, exact = unreduced
    masters = (*HOOKS, *INTERLOCK, "key"), (*HOOKS, "key", "force")
    vane = rom.reduce(models[0], masters[0], **keep, averaged=HOOKS + INTERLOCK)
    casing = rom.reduce(models[1], masters[1], **keep, **how, nodal_diameters=[1], averaged=HOOKS)
    system = Segment(SPRINGS, 1, force=1.0).join(vane, casing)
    found, shapes = rom.linear_modes(system, 1, 6)
    error = found / (exact / (2 * np.pi)) - 1
    assert np.all(error > -1e-9)
    assert np.all(error < close)
    own = system.at(1).split(shapes)
    for component, model in zip((vane, casing), models, strict=True):
        q = own[component.masters.part]
        recovery = rom.recovery(component, model)
        u = recovery.displacement(q, 1)
        contact = component.masters.averaged
        means = _patch_weights(model.part, contact) @ u.reshape(len(u), -1)
        np.testing.assert_allclose(
            means.reshape(len(contact), 3, -1), q[component.dofs(contact)], atol=1e-9 * abs(u).max()
        )
        # Functionals of the field are the same by their rows: the displacement of ten nodes.
        nodes = np.arange(0, len(u), len(u) // 10)
        G = sp.eye_array(3 * len(u), format="csr")[(3 * nodes[:, None] + np.arange(3)).ravel()]
        rows = recovery.rows(G, 1) @ q
        np.testing.assert_allclose(rows, u[nodes].reshape(len(rows), -1), atol=1e-9 * abs(u).max())
