"""The routes against one another, dense definitions, and solvers of another kind."""

from functools import partial

import numpy as np
import pytest
import scipy.linalg as sl

from benchmarks.rom.direct import direct
from vanelock import rom
from vanelock.fem import factorise, schur_complement
from vanelock.rom.routes import condensed, tran
from vanelock.rom.routes.condensed import definite_factor

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


@pytest.mark.parametrize("route", ["cyclic", "paper"])
def test_no_route_falls_below_the_sector(ring_sector, exact, route):
    """Ritz models: above the sector's dense frequencies, and nearer with every mode added."""
    model = ring_sector(sectors=N)
    for k in (0, 1):
        K, M, _ = exact.dense(model, "force", k)
        truth = exact.frequencies(K, M, 10)
        last = np.full(10, np.inf)
        for modes in (0, 4, 32):
            found = frequencies(
                rom.reduce(model, ("force",), modes, nodal_diameters=[k], route=route), k
            )[:10]
            assert np.all(found > truth * (1 - 1e-9))
            assert np.all(found < last * (1 + 1e-9))
            last = found


@pytest.mark.parametrize(
    "options",
    [
        {"accuracy": 1e-4, "band": 8000.0},
        {"modes": 6},
        {"modes": 6, "route": "paper", "interface_modes": 5},
    ],
    ids=["accuracy", "cyclic", "paper"],
)
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


def test_a_part_in_one_piece_by_another_solver(bar, exact, monkeypatch):
    model = bar()
    usual = rom.reduce(model, ("held",), accuracy=1e-5, band=3000.0).at(0)
    monkeypatch.setattr(condensed, "schur_complement", partial(schur_complement, backend="superlu"))
    other = rom.reduce(model, ("held",), accuracy=1e-5, band=3000.0).at(0)
    a, b = (exact.frequencies(part.K, part.M, 20) for part in (usual, other))
    np.testing.assert_allclose(a[6:], b[6:], rtol=1e-9)
    for G, H in zip(usual.neglected, other.neglected, strict=True):
        # The sign of each vector is free; the masters' block is not.
        np.testing.assert_allclose(G[:18, :18], H[:18, :18], atol=1e-9 * np.abs(G).max())


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e9])
def test_what_only_round_off_holds_has_no_factor(unit):
    scale = unit * np.outer([1, 1e3], [1, 1e3])
    for left, held in ((1e-14, False), (-1.0, False), (1e-9, True), (1.0, True)):
        A = scale * np.array([[1, 1], [1, 1 + left]])
        factor = definite_factor(A)
        assert (factor is not None) == held
        if factor is not None:
            np.testing.assert_allclose(factor @ factor.T, A, rtol=1e-12)
