"""Schur complements against dense elimination, on every installed backend."""

import numpy as np
import pytest
import scipy.sparse as sp
from sksparse.cholmod import analyze

from vanelock.common.errors import InputError
from vanelock.fem import (
    Material,
    SingularError,
    assemble,
    backends,
    cyclic_transform,
    schur_complement,
)
from vanelock.fem.solvers.panels import _FILLED, panels_of
from vanelock.fem.solvers.schur import _trailing_factor

every_backend = pytest.mark.parametrize("backend", backends())


def matrices(lattice, is_complex, free=False):
    """Stiffness of a block, clamped or free; or the same in a wave that couples its rows."""
    part = lattice((3, 3, 2), lambda p: p * [0.3, 0.1, 0.05])
    model = assemble(part, Material(E=1.0, nu=0.3, rho=1.0), fixed=None if free else "x0")
    K = model.K
    if not is_complex:
        return K
    phase = sp.diags_array(np.exp(0.7j * np.arange(K.shape[0])))
    return sp.csc_array(phase.conj() @ K @ phase)


def eliminated(A, kept, rest):
    A = A.toarray()
    Psi = -np.linalg.solve(A[np.ix_(rest, rest)], A[np.ix_(rest, kept)])
    return A[np.ix_(kept, kept)] + A[np.ix_(kept, rest)] @ Psi, Psi


@every_backend
@pytest.mark.parametrize("is_complex", [False, True], ids=["real", "Hermitian"])
@pytest.mark.parametrize("free", [False, True], ids=["clamped", "free"])
@pytest.mark.parametrize("filled", [-1, 5, _FILLED])
def test_equals_dense_elimination(lattice, monkeypatch, backend, is_complex, free, filled):
    """However few columns the panels of CHOLMOD's factor have."""
    monkeypatch.setattr(panels_of, "__defaults__", (filled,))
    A = matrices(lattice, is_complex, free)
    n = A.shape[0]
    rng = np.random.default_rng(2)
    kept = rng.permutation(n)[:40]
    S, interior = schur_complement(A, kept, backend)
    exact, Psi = eliminated(A, kept, interior.rest)
    size = abs(A).max()
    np.testing.assert_allclose(S, exact, atol=1e-12 * size)
    assert np.array_equal(S, S.conj().T)
    assert interior.is_complex == is_complex
    assert np.array_equal(interior.kept_rows, kept)
    assert np.array_equal(np.sort(np.r_[kept, interior.rest]), np.arange(n))
    v, z = rng.standard_normal((40, 3)), rng.standard_normal((n - 40, 3)) * 1j
    np.testing.assert_allclose(interior.extend(v), Psi @ v, atol=1e-11)
    np.testing.assert_allclose(interior.extend(v[:, 0]), Psi @ v[:, 0], atol=1e-11)
    np.testing.assert_allclose(interior.restrict(z), Psi.conj().T @ z, atol=1e-10)
    A_ss = A[interior.rest][:, interior.rest]
    np.testing.assert_allclose(A_ss @ interior.solve(z), z, atol=1e-11)


@every_backend
def test_sectors_at_nodal_diameters(lattice, backend):
    def bend(p):
        angle = (p[:, 1] - 0.5) * 2 * np.pi / 9
        radius = 1 + 0.3 * p[:, 0]
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0.4 * p[:, 2]])

    part = lattice((2, 3, 2), bend)
    part.node_sets.update(left=part.node_sets["y0"], right=part.node_sets["y1"])
    model = assemble(part, Material(E=1.0, nu=0.3, rho=1.0), fixed="x0")
    for diameter in (1, 2, 3):
        T = cyclic_transform(model, diameter, sectors=9)
        A = sp.csc_array(T.conj().T @ model.K @ T)
        kept = np.arange(5, A.shape[0], 7)
        S, interior = schur_complement(A, kept, backend)
        exact, _ = eliminated(A, kept, interior.rest)
        np.testing.assert_allclose(S, exact, atol=1e-12 * abs(exact).max())


@every_backend
def test_indefinite_complement(lattice, backend):
    A = matrices(lattice, False)
    kept = np.arange(30)
    lowered = A - sp.diags_array(np.r_[np.full(30, 5.0), np.zeros(A.shape[0] - 30)])
    S, interior = schur_complement(sp.csc_array(lowered), kept, backend)
    exact, _ = eliminated(lowered, kept, interior.rest)
    assert np.linalg.eigvalsh(exact)[0] < -1
    np.testing.assert_allclose(S, exact, atol=1e-12)


@every_backend
def test_free_rest_and_bad_rows_are_refused(lattice, backend):
    A = matrices(lattice, False, free=True)
    with pytest.raises(SingularError, match="3 motions are free"):
        schur_complement(A, [0, 1, 2], backend)  # one node held leaves three rotations
    for rows in ([0, 0], [-1], [A.shape[0]], np.arange(A.shape[0])):
        with pytest.raises(InputError, match="rows to keep"):
            schur_complement(A, rows, backend)
    S, interior = schur_complement(A + sp.eye_array(A.shape[0]), [], backend)
    assert S.shape == (0, 0)
    assert interior.size == A.shape[0]


def test_rows_of_a_node_are_ordered_together(lattice):
    K = matrices(lattice, False)
    nodes = np.setdiff1d(np.arange(K.shape[0] // 3), [4, 9])
    rest = (3 * nodes[:, None] + np.arange(3)).ravel()
    kept = np.setdiff1d(np.arange(K.shape[0]), rest)
    order = _trailing_factor(K, kept, rest).order.reshape(-1, 3)
    assert np.array_equal(order, order[:, :1] + np.arange(3))


def test_rows_that_are_not_of_nodes_are_ordered_one_by_one():
    side = 30  # of a grid with one row a point: threes of them are links of nothing
    one = sp.diags_array([2.0, -1.0, -1.0], offsets=[0, 1, -1], shape=(side, side))
    A = sp.csc_array(sp.kronsum(one, one))
    found = _trailing_factor(A, np.arange(0), np.arange(side**2))
    own = analyze(A, mode="simplicial", ordering_method="nesdis")
    assert np.array_equal(found.order, own.P())
