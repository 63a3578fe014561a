"""The routes against one another and dense definitions; loads at rest against the full model."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sl
import scipy.sparse as sp

from benchmarks.rom.direct import direct
from tests.refusals import refused
from vanelock import fem, rom
from vanelock.common.errors import InputError
from vanelock.fem import factorise, schur_complement
from vanelock.rom.routes import condensed, tran

N = 8
DIAMETERS = (0, 1, N // 2, N - 1)


def fields(component, model, k):
    """Displacements (free dofs, n) of unit reduced coordinates."""
    u = rom.recovery(component, model).displacement(np.eye(component.size), k)
    return u[model.dofs[:, 0] >= 0].reshape(model.K.shape[0], -1)


def orthonormal(x, M):
    """M-orthonormal basis of the columns of x."""
    L = np.linalg.cholesky(M.toarray())
    return np.linalg.qr(L.T @ (x / np.linalg.norm(x, axis=0)))[0]


def frequencies(component, k):
    reduced = component.at(k)
    return np.sqrt(sl.eigvalsh(reduced.K, reduced.M).clip(0)) / (2 * np.pi)


@pytest.mark.parametrize("k", DIAMETERS)
@pytest.mark.parametrize("count", [1, 6, 36], ids=["one", "some", "all"])
def test_paper_spans_the_subspace_of_a_second_way(ring_sector, k, count):
    """Largest principal angle in the metric of the mass, and every frequency."""
    model = ring_sector(sectors=N)
    paper, other = by_both_ways(model, 5, k, count)
    a, b = (orthonormal(fields(part, model, k), model.M) for part in (paper, other))
    assert np.abs(a - b @ (b.conj().T @ a)).max() < 1e-9
    np.testing.assert_allclose(frequencies(paper, k), frequencies(other, k), rtol=1e-9)
    assert np.isrealobj(other.at(k).K) == (k in (0, N // 2))


def by_both_ways(model, modes, k, count):
    """Reduced by the route "paper", and without the faces' columns."""
    given = {"modes": modes, "nodal_diameters": [k], "interface_modes": count}
    return rom.reduce(model, ("force",), route="paper", **given), direct(model, ("force",), **given)


@pytest.mark.parametrize("interface", ["published", "followed"])
def test_tran_by_its_definition(ring_sector, exact, interface):
    """The subspace of the second way, built from dense matrices of the sector alone."""
    model, k, count = ring_sector(sectors=N), 1, 4
    part = direct(model, ("force",), 0, [k], interface, count)
    K, M, t = exact.dense(model, "force", k)
    T = exact.transform(model, k).tocsr()
    b = T.indices[T.indptr[model.dofs[model.part.node_sets["left"]].ravel()[free(model)]]]
    if interface == "published":
        s = np.setdiff1d(np.arange(len(K)), b)
        Psi = np.zeros((len(K), len(b)), complex)
        Psi[b], Psi[s] = np.eye(len(b)), -np.linalg.solve(K[np.ix_(s, s)], K[np.ix_(s, b)])
    held = np.concatenate([b, t])
    s = np.setdiff1d(np.arange(len(K)), held)
    static = np.zeros((len(K), len(held)), complex)
    static[held] = np.eye(len(held))
    static[s] = -np.linalg.solve(K[np.ix_(s, s)], K[np.ix_(s, held)])
    onto_face, onto_masters = static[:, : len(b)], static[:, len(b) :]
    if interface == "published":
        # Guyan to the faces: the modes of the auxiliary model, then lifted with masters at rest.
        values = sl.eigh(Psi.conj().T @ K @ Psi, Psi.conj().T @ M @ Psi)[1][:, :count]
        basis = np.hstack([onto_face @ values, onto_masters])
    else:
        G, H = (onto_face.conj().T @ A @ onto_face for A in (K, M))
        values = sl.eigh(G, H)[1][:, :count]
        follow = -np.linalg.solve(G, onto_face.conj().T @ K @ onto_masters)
        basis = np.hstack([onto_face @ values, onto_masters + onto_face @ follow])
    a = orthonormal(T @ basis, model.M)
    c = orthonormal(fields(part, model, k), model.M)
    assert a.shape == c.shape
    assert np.abs(a - c @ (c.conj().T @ a)).max() < 1e-8


def free(model):
    """Which dofs of the left face are free."""
    return model.dofs[model.part.node_sets["left"]].ravel() >= 0


@pytest.mark.parametrize("count", [3, None])
def test_a_free_ring_by_both_ways(ring_sector, count):
    """Nothing holds the ring but its masters: two rigid-body motions at ND 0 and ND 1."""
    model = ring_sector(sectors=N, clamped=False)
    count = count or 3 * len(model.part.node_sets["left"])
    for k in (0, 1, 2):
        found = by_both_ways(model, 8, k, count)
        a, b = (orthonormal(fields(part, model, k), model.M) for part in found)
        assert np.abs(a - b @ (b.conj().T @ a)).max() < 1e-8
        paper, other = (frequencies(part, k) for part in found)
        rigid = 2 if k < 2 else 0
        assert paper[:rigid].max(initial=0) < 1.0
        assert other[:rigid].max(initial=0) < 1.0
        np.testing.assert_allclose(other[rigid:], paper[rigid:], rtol=1e-8)


@pytest.mark.parametrize("options", [
    {"accuracy": 1e-4, "band": 8000.0},
    {"modes": 6},
    {"modes": 6, "route": "paper", "interface_modes": 5},
], ids=["accuracy", "cyclic", "paper"])  # fmt: skip
def test_other_solvers_give_the_same_model(ring_sector, monkeypatch, options):
    """Without CHOLMOD the factors stand in for a condensed matrix by one solve a column."""
    model = ring_sector(sectors=N)

    def reduced():
        return rom.reduce(model, ("force",), nodal_diameters=[0, 1], **options)

    used = []

    def by_solves(K, rows):
        used.append(rows)
        return schur_complement(K, rows, backend="superlu")

    def by_superlu(K):
        used.append(K)
        return factorise(K, backend="superlu")

    usual = reduced()
    monkeypatch.setattr(condensed, "schur_complement", by_solves)
    monkeypatch.setattr(tran, "factorise", by_superlu)
    other = reduced()
    assert len(used) == 1  # one factorisation for both diameters
    assert other.size == usual.size
    for k in (0, 1):
        np.testing.assert_allclose(frequencies(other, k), frequencies(usual, k), rtol=1e-9)
        m = slice(usual.interface_modes, usual.interface_modes + 12)
        scale = np.abs(usual.at(k).K).max()
        np.testing.assert_allclose(other.at(k).K[m, m], usual.at(k).K[m, m], atol=1e-11 * scale)


OPTIONS = ({"accuracy": 1e-4, "band": 3e3}, {"modes": 0}, {"modes": 7})


def three(model):
    """Pressure, heat that varies, rotation."""
    part = model.part
    side = "z1" if "z1" in part.node_sets else "top"
    heat = 1e-3 * (1 + 5 * part.points[:, 2] + part.points[:, 0] ** 2)
    return {
        "gas": fem.pressure(model, side, 2e5),
        "heat": fem.thermal(model, heat),
        "rotation": fem.centrifugal(model, 300.0),
    }


def on_springs(model, masters, seed=3):
    """(n, n) stiffness that holds and couples the masters, and its rows."""
    rows = model.dofs[model.part.node_sets[masters]].ravel()
    G = np.random.default_rng(seed).standard_normal((len(rows), len(rows)))
    A = 1e6 * (G @ G.T + np.eye(len(rows)))
    n = model.K.shape[0]
    S = sp.csr_array((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(n, len(rows)))
    return sp.csc_array(S @ sp.csr_array(A) @ S.T), A


@pytest.mark.parametrize("options", OPTIONS, ids=["accuracy", "statics", "modes"])
@pytest.mark.parametrize("fixed", [None, "x0"], ids=["free", "clamped"])
def test_a_part_in_one_piece_answers_loads_at_rest_exactly(bar, options, fixed):
    model = bar(fixed=fixed)
    loads, (springs, A) = three(model), on_springs(model, "held")
    component = rom.reduce(model, ("held",), loads=loads, **options)
    recovery = rom.recovery(component, model)
    K = component.at(0).K.copy()
    rows = component.dofs(component.masters.set("held")).ravel()
    K[np.ix_(rows, rows)] += A
    factor = fem.factorise((model.K + springs).tocsc())
    assert list(component.loads) == ["gas", "heat", "rotation"]
    for name, load in loads.items():
        full = model.field(factor.solve(load))
        found = recovery.displacement(np.linalg.solve(K, component.loads[name]), 0)
        assert np.abs(found - full).max() < 1e-10 * np.abs(full).max(), name


@pytest.mark.parametrize("options", OPTIONS, ids=["accuracy", "statics", "modes"])
def test_a_ring_answers_loads_at_rest_exactly(ring_sector, options):
    model = ring_sector()
    part = model.part
    sets = {**part.node_sets, "top": np.flatnonzero(part.points[:, 2] > 0.2 - 1e-9)}
    model = replace(model, part=replace(part, node_sets=sets))
    loads, (springs, A) = three(model), on_springs(model, "force")
    component = rom.reduce(model, ("force",), nodal_diameters=[0, 1, 3], loads=loads, **options)
    recovery = rom.recovery(component, model)
    K = component.at(0).K.copy()
    rows = component.dofs(component.masters.set("force")).ravel()
    K[np.ix_(rows, rows)] += A
    T = fem.cyclic_transform(model, 0)
    factor = fem.factorise((T.conj().T @ (model.K + springs) @ T).tocsc())
    for name, load in loads.items():
        full = model.field(T @ factor.solve(np.asarray(T.conj().T @ load)))
        found = recovery.displacement(np.linalg.solve(K, component.loads[name]), 0)
        assert np.abs(found - full).max() < 1e-10 * np.abs(full).max(), name
    bare = rom.reduce(model, ("force",), nodal_diameters=[0, 1, 3], **options)
    assert component.size <= bare.size + 3
    assert bare.loads is None


@pytest.mark.parametrize("cyclic", [False, True], ids=["bar", "ring"])
def test_stress_of_heat_is_that_of_the_full_model(bar, ring_sector, cyclic):
    model, name = (ring_sector(), "force") if cyclic else (bar(fixed="x0"), "held")
    growth = 1e-3 * (1 + 5 * model.part.points[:, 2])
    load, (springs, A) = fem.thermal(model, growth), on_springs(model, name)
    kept = {"nodal_diameters": [0]} if cyclic else {}
    component = rom.reduce(model, (name,), modes=4, loads={"heat": load}, **kept)
    K = component.at(0).K.copy()
    rows = component.dofs(component.masters.set(name)).ravel()
    K[np.ix_(rows, rows)] += A
    x = np.linalg.solve(K, component.loads["heat"])
    found = rom.recovery(component, model).stress(x, 0, growth=growth)
    T = sp.csc_array(fem.cyclic_transform(model, 0)) if cyclic else sp.eye_array(len(load))
    factor = fem.factorise(sp.csc_array(T.conj().T @ (model.K + springs) @ T))
    u = np.real(T @ factor.solve(np.asarray(T.conj().T @ load)))
    expected = fem.stress(model, model.field(u), growth)
    inside = np.ones(len(found), bool)
    if cyclic:  # where sectors meet, the mean is over elements of both
        inside[model.part.node_sets["left"]] = inside[model.part.node_sets["right"]] = False
    assert np.abs(found - expected)[inside].max() < 1e-9 * np.abs(expected).max()


def test_loads_that_are_combinations_of_others_take_no_vector(bar):
    model = bar(fixed="x0")
    gas, heat, _ = three(model).values()
    both = rom.reduce(model, ("held",), modes=4, loads={"gas": gas, "heat": heat})
    more = {"gas": gas, "heat": heat, "sum": gas + heat, "none": 0 * gas}
    component = rom.reduce(model, ("held",), modes=4, loads=more)
    assert component.size == both.size
    given = component.loads
    scale = np.abs(given["sum"]).max()
    np.testing.assert_allclose(given["sum"], given["gas"] + given["heat"], atol=1e-11 * scale)


def test_heat_grows_with_the_modulus_and_displacements_stay(bar):
    model = bar(fixed="x0")
    loads = three(model)
    component = rom.reduce(model, ("held",), modes=4, loads=loads)
    softer = rom.stiffened(component, 0.7, strained=("heat",))
    metal = replace(model.material, E=0.7 * model.material.E)
    other = fem.assemble(model.part, metal, fixed="x0")
    expected = rom.reduce(other, ("held",), modes=4, loads=three(other))
    for name in expected.loads:
        x = [
            rom.recovery(each, other).displacement(
                np.linalg.solve(each.at(0).K, each.loads[name]), 0
            )
            for each in (softer, expected)
        ]
        assert np.abs(x[0] - x[1]).max() < 1e-9 * np.abs(x[1]).max()


def test_what_cannot_be_answered_is_refused(bar, ring_sector):
    model = bar(fixed="x0")
    good = three(model)["gas"]
    for load, words in (
        (good[:-1], r"loads\['gas'\]: shape .*: needed is .*, the free dofs"),
        (good * np.nan, r"loads\['gas'\]: must be finite"),
    ):
        refused(words, rom.reduce, model, ("held",), loads={"gas": load})
    ring = ring_sector()
    loads = {"rotation": fem.centrifugal(ring, 10.0)}
    with pytest.raises(InputError, match="act at nodal diameter 0, not at 1, 2"):
        rom.reduce(ring, ("force",), nodal_diameters=[1, 2], loads=loads)
    with pytest.raises(InputError, match='the route "paper" keeps no static answers'):
        rom.reduce(ring, ("force",), nodal_diameters=[0], route="paper", loads=loads)


def test_loads_are_saved_with_the_part(bar, tmp_path):
    model = bar(fixed="x0")
    component = rom.reduce(model, ("held",), modes=4, loads=three(model))
    component.save(tmp_path / "part.h5")
    found = rom.Component.load(tmp_path / "part.h5")
    assert all(np.array_equal(found.loads[k], load) for k, load in component.loads.items())
