"""Panels of a sparse factor against dense triangular solutions."""

import numpy as np
import pytest
import scipy.linalg as sl
import scipy.sparse as sp

from vanelock.fem.solvers.supernodal import panels_of

WIDTHS = (3, 1, 4, 2, 5)


def factor(rng, is_complex):
    """A lower triangle of panels whose columns have the same rows, each a child of the next."""
    n = sum(WIDTHS)
    L, start = np.zeros((n, n), complex if is_complex else float), 0
    for width in WIDTHS:
        stop = start + width
        rows = np.r_[start:stop, np.flatnonzero(rng.random(n - stop) < 0.6) + stop]
        block = rng.standard_normal((len(rows), width))
        L[np.ix_(rows, range(start, stop))] = block + 1j * block[::-1] if is_complex else block
        start = stop
    L = np.tril(L)
    L[np.diag_indices(n)] = 2 + rng.random(n)
    return L


@pytest.mark.parametrize("columns", [3, 7, 10, 15])
@pytest.mark.parametrize(("is_complex", "complex_sides"), [
    (False, False), (False, True), (True, True),
], ids=["real", "real factor", "complex"])  # fmt: skip
@pytest.mark.parametrize("filled", [-1, 5, 1000])
def test_sweeps_are_those_of_the_dense_factor(columns, is_complex, complex_sides, filled):
    rng = np.random.default_rng(columns)
    L = factor(rng, is_complex)
    n = len(L)
    panels = panels_of(sp.csc_array(L), columns, filled)
    assert len(panels.panels) == 1 or filled < 1000
    assert sum(p.columns.stop - p.columns.start for p in panels.panels) == columns
    ends = {p.columns.stop for p in panels.panels}
    assert ends <= {columns, *np.cumsum(WIDTHS).tolist()}  # columns of one structure stay together
    B = rng.standard_normal((n, 6)) + 1j * complex_sides * rng.standard_normal((n, 6))
    B = B if complex_sides else B.real
    top, rest = L[:columns, :columns], L[columns:, :columns]
    Y = sl.solve_triangular(top, B[:columns], lower=True)
    for inner, under in ((False, B[columns:] - rest @ Y), (True, B[columns:])):
        X = np.array(B, order="C")
        panels.forward(X, inner)
        np.testing.assert_allclose(X, np.vstack([Y, under]), rtol=1e-11, atol=1e-11)
        X = np.array(B, order="C")
        panels.backward(X, inner)
        known = 0 if inner else rest.conj().T @ B[columns:]
        up = sl.solve_triangular(top, B[:columns] - known, lower=True, trans=2)
        np.testing.assert_allclose(X[:columns], up, rtol=1e-11, atol=1e-11)
