"""Patch means as degrees of freedom against constraint equations, and stiffness that meshes add."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as sl
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from benchmarks.unreduced import unreduced_segment
from tests.refusals import refused
from tests.rom.block_in_rim import patched
from vanelock import fem, rom
from vanelock.common.errors import InputError
from vanelock.mesh.contact_patches import _averages, _Patch, _plane
from vanelock.rom.component import choose
from vanelock.rom.joining.connections import tied_nodes
from vanelock.rom.joining.mesh_excess import _FRICTIONLESS, MeshExcess, _ModalExcess
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


def test_a_node_without_a_patch_is_refused(block):
    refused("tetra10: contact node 0 has no patch", _patch_weights, block.model.part, np.array([0]))
    with pytest.raises(InputError, match="no contact patches of 'corner'; it has contact"):
        choose(block.model.part, ("corner",), ("corner",))


def test_patches_that_the_mesh_cannot_tell_apart_are_refused(block):
    model = block.model
    same = sp.csc_array(model.part.patches["contact"].toarray()[[0, 1, 1]])
    model = replace(model, part=replace(model.part, patches={"contact": same}))
    refused("tetra10: the mesh is too coarse to resolve", _patch_transform, model, block.contact)


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
        refused(f"{name}: a patch on one side and a node on the", list, STIFF[joint].pairs(*pieces))
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


@pytest.mark.parametrize(("keep", "how", "close"), [
    ({"accuracy": 1e-4}, {}, 1e-4), (FORTY, PAPER, 2e-3)
], ids=["cyclic", "paper"])  # fmt: skip
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


MODES = 6
SHARES = (0.05, 0.03)
"""Of the strain energy of vane and casing, in the combination of modes that loses least."""


def excess_of(ring_scene, k):
    """A Hermitian excess of both parts that couples the modes: shares of their strain energy."""
    hertz, shapes = rom.linear_modes(ring_scene.system, k, MODES)
    random = np.random.default_rng(k)
    parts, forces = [], []
    one = ring_scene.system.at(k)
    for part, share in zip((ring_scene.vane, ring_scene.casing), SHARES, strict=True):
        K = one.joined(part.masters.part, part.at(k).K.astype(complex))
        turned = random.normal(size=(MODES, MODES)) + 1j * random.normal(size=(MODES, MODES))
        root = sl.cholesky(shapes.conj().T @ K @ shapes + 1e-9 * np.eye(MODES))
        unitary = np.linalg.qr(turned.real if k == 4 else turned)[0]
        energy = (unitary * (share * (1 + np.arange(MODES)))) @ unitary.conj().T
        parts.append(root.conj().T @ energy @ root)
        forces.append(K @ shapes)
    return shapes, rom.modal_excess(shapes, hertz, parts, forces)


@pytest.fixture(scope="module")
def taken(ring_scene):
    return MeshExcess({k: excess_of(ring_scene, k)[1] for k in (1, 2)})


def test_the_energy_of_the_modes_is_less_by_the_excess(ring_scene, taken):
    found = taken.taken_off(ring_scene.system)
    for k in (1, 2):
        shapes, one = excess_of(ring_scene, k)
        K, lowered = ring_scene.system.at(k).K, found.at(k).K
        np.testing.assert_allclose(lowered, lowered.conj().T, atol=1e-9 * np.abs(K).max())
        expected = shapes.conj().T @ K @ shapes - one.parts.sum(axis=0)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(shapes.conj().T @ lowered @ shapes, expected, atol=1e-8 * scale)


def test_no_shape_loses_more_of_its_energy_than_the_modes(ring_scene, taken):
    """Whatever contacts do: so a structure that is held stays so, with all of them open too."""
    found = taken.taken_off(ring_scene.system)
    least = 1 - max(SHARES) * MODES
    for k in (1, 2):
        values = sl.eigh(found.at(k).K - least * ring_scene.system.at(k).K, eigvals_only=True)
        assert values[0] > -1e-9 * values[-1]
        none = np.zeros(ring_scene.system.contacts.count, bool)
        as_it_is, lowered = (
            rom.linear_modes(system, k, 3, none)[0] for system in (ring_scene.system, found)
        )
        assert np.all(lowered > as_it_is * least**0.5)
        assert np.all(lowered < as_it_is)


def test_frequencies_fall_by_half_the_share_of_the_excess(ring_scene, taken):
    found, k = taken.taken_off(ring_scene.system), 1
    one = excess_of(ring_scene, k)[1]
    omega2 = (2 * np.pi * one.frequency) ** 2
    small = sl.eigvalsh(np.diag(omega2) - one.parts.sum(axis=0))
    lowered, _ = rom.linear_modes(found, k, 3)
    # Shapes outside of the modes' span change them a little, always downwards.
    np.testing.assert_allclose(lowered, np.sqrt(small[:3]) / (2 * np.pi), rtol=5e-3)


def test_the_excess_of_a_part_goes_with_its_modulus(ring_scene, taken):
    both, vane, casing = (
        taken.taken_off(ring_scene.system, factors).at(1).K - ring_scene.system.at(1).K
        for factors in ((2.0, 3.0), (1.0, 0.0), (0.0, 1.0))
    )
    np.testing.assert_allclose(both, 2 * vane + 3 * casing, atol=1e-12 * np.abs(both).max())
    shell = np.setdiff1d(np.arange(len(vane)), ring_scene.joined_dofs)
    assert not vane[shell].any()
    assert np.abs(vane).max() > 0
    assert np.abs(casing).max() > 0


def test_no_more_than_half_of_the_stiffness_is_taken_off():
    shapes, omega2 = np.eye(3), np.array([1.0, 4.0, 9.0])
    given = shapes, np.sqrt(omega2) / (2 * np.pi)
    share = np.array([0.6, 0.3, 0.5])
    found = rom.modal_excess(*given, [np.diag(share * omega2)], [np.diag(omega2)])
    np.testing.assert_allclose(found.stiffness[0], np.diag(share.clip(max=0.5) * omega2))
    assert found.share == pytest.approx(0.6)


def test_answers_to_interference_are_held_by_it_alone(ring_scene):
    """Of each joint, with contacts that stick and with contacts that hardly do so tangentially."""
    system, contacts = ring_scene.system, ring_scene.system.contacts
    joints = list(dict.fromkeys(contacts.joints))
    answers = rom.rest_shapes(system, joints)
    assert answers.shape == (len(system.at(0).K), 2 * len(joints))
    rows, held = system.contact_rows(0), contacts.stiffness.copy()
    for number, shape in enumerate(answers.T):
        joint = joints[number % len(joints)]
        held[:, 1:] = contacts.kt * (1.0 if number < len(joints) else _FRICTIONLESS)
        moved = np.einsum("cdi,i->cd", rows, shape)
        force = system.at(0).K @ shape + np.einsum("cdi,cd->i", rows.conj(), held * moved)
        push = np.einsum("ci,c->i", rows[:, 0].conj(), contacts.kn * contacts.of(joint))
        size = np.vdot(push, force) / np.vdot(push, push)
        np.testing.assert_allclose(force, size * push, atol=1e-7 * np.abs(force).max())
        assert np.vdot(shape, system.at(0).M @ shape).real == pytest.approx(1)


def test_it_survives_a_file(taken, tmp_path):
    taken.save(tmp_path / "excess.h5")
    again = MeshExcess.load(tmp_path / "excess.h5")
    assert list(again.diameters) == [1, 2]
    assert isinstance(again.diameters[1], _ModalExcess)
    np.testing.assert_array_equal(again.diameters[1].parts, taken.diameters[1].parts)
