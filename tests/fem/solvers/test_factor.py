"""Sparse factorisation against dense solutions and closed forms, on every installed backend."""

import pickle
import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp

from vanelock.common.errors import InputError
from vanelock.fem import Material, SingularError, assemble, backends, factorise
from vanelock.fem.solvers import backend as solver_backend

BACKENDS = backends()
both_kinds = pytest.mark.parametrize("is_complex", [False, True], ids=["real", "Hermitian"])
every_backend = pytest.mark.parametrize("backend", BACKENDS)


def grid(n, phase=0.0):
    """Laplacian of an n x n x n grid whose layers are coupled with a phase, n³ rows."""
    one = sp.diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1])
    last = one
    if phase:
        step = np.full(n - 1, np.exp(1j * phase))
        last = sp.diags_array([-step.conj(), np.full(n, 2.0), -step], offsets=[-1, 0, 1])
    i = sp.eye_array(n)
    return sp.csc_array(
        sp.kron(sp.kron(one, i), i) + sp.kron(sp.kron(i, one), i) + sp.kron(sp.kron(i, i), last)
    )


def chain(n, phase=0.0):
    """Springs of stiffness one between n masses, held nowhere, n rows."""
    step = np.full(n - 1, np.exp(1j * phase) if phase else 1.0)
    middle = np.r_[1.0, np.full(n - 2, 2.0), 1.0]
    return sp.diags_array([-step.conj(), middle, -step], offsets=[-1, 0, 1])


def sides(n, k, seed=1):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((n, k)) + 1j * rng.standard_normal((n, k))


@every_backend
@both_kinds
def test_solution_equals_the_dense_one(backend, is_complex):
    A = grid(6, 0.7 if is_complex else 0.0)
    factor = factorise(A, backend)
    assert (factor.backend, factor.size, factor.is_complex) == (backend, 216, is_complex)
    b = sides(216, 5)
    for side in (b, b.real, b[:, 0], b[:, 0].real, b.real.astype(np.float32)):
        x = factor.solve(side)
        exact = np.linalg.solve(A.toarray(), side)
        assert x.shape == side.shape
        assert np.iscomplexobj(x) == (is_complex or np.iscomplexobj(side))
        np.testing.assert_allclose(x, exact, atol=1e-13 * abs(exact).max())


@every_backend
@both_kinds
def test_many_sides_are_solved_in_blocks(backend, is_complex, monkeypatch):
    A = grid(5, 0.3 if is_complex else 0.0)
    factor = factorise(A, backend)
    b = sides(125, 300)  # more than one block
    x = factor.solve(b)
    assert abs(A @ x - b).max() < 1e-13
    monkeypatch.setattr(solver_backend, "_BYTES", 1)  # a block of one column
    np.testing.assert_allclose(factor.solve(b), x, atol=1e-14)
    monkeypatch.undo()
    unit = sp.random_array((125, 200), density=0.02, rng=3, format="csr")
    np.testing.assert_allclose(A @ factor.solve(unit), unit.toarray(), atol=1e-14)


@every_backend
@pytest.mark.parametrize("index", [np.int32, np.int64])
def test_indices_of_either_width(backend, index):
    A = grid(6, 0.7)
    wide = sp.csc_array((A.data, A.indices.astype(index), A.indptr.astype(index)), shape=A.shape)
    b = sides(216, 2)
    np.testing.assert_allclose(A @ factorise(wide, backend).solve(b), b, atol=1e-13)
    np.testing.assert_allclose(A.real @ factorise(wide.real, backend).solve(b), b, atol=1e-13)


@every_backend
@both_kinds
def test_indefinite_matrix_is_refused(backend, is_complex):
    A = grid(6, 0.7 if is_complex else 0.0)
    lowest = 3 * (2 - 2 * np.cos(np.pi / 7))
    for shift in (1.01 * lowest, 3.0):
        with pytest.raises(InputError, match="not positive definite"):
            factorise(A - shift * sp.eye_array(216), backend)
    above = factorise(A - 0.99 * lowest * sp.eye_array(216), backend)
    assert np.linalg.norm(above.solve(np.ones(216))) > 1


@every_backend
def test_slender_but_clamped_part_is_not_refused(lattice, backend):
    # A strip 500 times as long as thick: the condition number is 1e13 and it is still regular.
    part = lattice((50, 2, 1), lambda p: p * [1.0, 0.05, 0.002])
    E, load = 210e9, 1.0
    model = assemble(part, Material(E=E, nu=0.0, rho=7850.0), fixed="x0")
    tip = model.rows("x1")
    weight = np.zeros(model.K.shape[0])
    middle = tip[len(tip) // 2]
    weight[middle[2]] = load
    deflection = factorise(model.K, backend).solve(weight)[middle[2]]
    inertia = 0.05 * 0.002**3 / 12
    assert deflection == pytest.approx(load / (3 * E * inertia), rel=0.01)


def test_bad_matrix_and_bad_request_are_refused():
    A = grid(3)
    with pytest.raises(InputError, match=r"backend = 'mumps': the installed solvers are"):
        factorise(A, "mumps")
    with pytest.raises(InputError, match=r"shape \(27, 20\): it must be square"):
        factorise(A[:, :20])
    broken = A.copy()
    broken.data[5] = np.nan
    with pytest.raises(InputError, match="not finite"):
        factorise(broken)
    empty = A.tolil()
    empty[4, 4] = 0
    with pytest.raises(InputError, match=r"not positive definite.*row 4"):
        factorise(empty.tocsc())
    with pytest.raises(ValueError, match=r"shape \(26,\) for a matrix of 27 rows"):
        factorise(A).solve(np.ones(26))


@pytest.mark.system
def test_factorisation_loads_neither_scikit_fem_nor_gmsh():
    code = (
        "import sys; from vanelock.fem import factorise, eigenpairs, cyclic_transform, modes; "
        "print(sorted({'skfem', 'gmsh', 'meshio', 'vtkmodules'} & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


@every_backend
def test_matrix_that_is_not_hermitian_is_refused(backend):
    A = grid(4, 0.7)
    for wrong in (sp.triu(A), A @ sp.diags_array(np.arange(1.0, 65)), A.real + 1j * A.real):
        with pytest.raises(InputError, match="not Hermitian"):
            factorise(wrong, backend)


@every_backend
@both_kinds
def test_singular_matrix_names_the_rows_that_move(backend, is_complex):
    # Beside a regular grid, two chains that nothing holds: each may slide as a whole.
    phase = 0.7 if is_complex else 0.0
    A = grid(5, phase)
    chains = [chain(6, phase), 0.3 * chain(4, phase)]
    order = np.random.default_rng(7).permutation(135)
    singular = sp.block_diag([A, *chains], format="csc")[order][:, order]
    with pytest.raises(SingularError, match="not positive definite: 2 motions are free") as caught:
        factorise(singular, backend)
    error = pickle.loads(pickle.dumps(caught.value))  # as from a process of its own
    assert str(error) == str(caught.value)
    assert set(order[error.rows]) == set(range(125, 135))
    assert error.count == 2
    motions = error.motions[np.argsort(order)]
    moved = np.zeros((135, 2), complex)
    moved[125:131, 0] = np.exp(-1j * phase * np.arange(6)) / np.sqrt(6)
    moved[131:, 1] = np.exp(-1j * phase * np.arange(4)) / 2
    cosines = np.linalg.svd(moved.conj().T @ motions)[1]
    assert cosines == pytest.approx([1, 1], abs=1e-12)
