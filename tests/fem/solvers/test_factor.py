"""Factors and Schur complements against dense solutions on every backend; free motions in words."""

import dataclasses
import pickle
import re
import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp

from tests.fem.conftest import STEEL
from tests.refusals import refused
from vanelock.fem import (
    Material,
    SingularError,
    assemble,
    backends,
    factorise,
    free_motion,
    schur_complement,
)
from vanelock.fem.solvers import backend as solver_backend
from vanelock.fem.solvers.panels import _FILLED, panels_of

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
        refused("not positive definite", factorise, A - shift * sp.eye_array(216), backend)
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
    refused(r"backend = 'mumps': the installed solvers are", factorise, A, "mumps")
    refused(r"shape \(27, 20\): it must be square", factorise, A[:, :20])
    broken = A.copy()
    broken.data[5] = np.nan
    refused("not finite", factorise, broken)
    empty = A.tolil()
    empty[4, 4] = 0
    refused(r"not positive definite.*row 4", factorise, empty.tocsc())
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
        refused("not Hermitian", factorise, wrong, backend)


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
    alone = SingularError(caught.value.motions)  # without the library's error before it
    error = pickle.loads(pickle.dumps(alone))  # as from a process of its own
    assert str(error) == str(caught.value)
    assert set(order[error.rows]) == set(range(125, 135))
    assert error.count == 2
    motions = error.motions[np.argsort(order)]
    moved = np.zeros((135, 2), complex)
    moved[125:131, 0] = np.exp(-1j * phase * np.arange(6)) / np.sqrt(6)
    moved[131:, 1] = np.exp(-1j * phase * np.arange(4)) / 2
    cosines = np.linalg.svd(moved.conj().T @ motions)[1]
    assert cosines == pytest.approx([1, 1], abs=1e-12)


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
        refused("rows to keep", schur_complement, A, rows, backend)
    S, interior = schur_complement(A + sp.eye_array(A.shape[0]), [], backend)
    assert S.shape == (0, 0)
    assert interior.size == A.shape[0]


def words(model, rows=None, backend=None):
    """What is said of the model's stiffness over some rows, or transformed by a matrix."""
    K = model.K
    if sp.issparse(rows):
        K = rows.conj().T @ K @ rows
    elif rows is not None:
        K = K[rows][:, rows]
    with pytest.raises(SingularError) as caught:
        factorise(K, backend)
    refused("rows: 1 of them; the matrix has", free_motion, model, caught.value, np.arange(1))
    return free_motion(model, caught.value, rows)


def without(part, keep):
    """The cells of a part that are kept, and their nodes."""
    cells = part.cells[keep]
    used = np.unique(cells)
    number = np.full(len(part.points), -1)
    number[used] = np.arange(len(used))
    sets = {k: number[np.intersect1d(v, used)] for k, v in part.node_sets.items()}
    return dataclasses.replace(part, points=part.points[used], cells=number[cells], node_sets=sets)


@every_backend
def test_free_part_has_six_rigid_motions(lattice, backend):
    model = assemble(lattice((3, 2, 2), lambda p: p * [0.3, 0.2, 0.1] + 5), STEEL)
    assert words(model, backend=backend) == (
        "tetra10: free to move as a rigid body: 6 motions not held; "
        "hold a set of nodes or give a negative shift"
    )


@every_backend
def test_hinge_leaves_one_rigid_motion(lattice, backend):
    # Held along the edge x = y = 0: it turns about the axis z, and the far edge moves most.
    part = lattice((3, 2, 2), lambda p: p * [0.3, 0.1, 0.1])
    part.node_sets["edge"] = np.intersect1d(part.node_sets["x0"], part.node_sets["y0"])
    clamped = words(assemble(part, STEEL, fixed="edge"), backend=backend)
    model = assemble(part, STEEL)
    held = model.rows("edge").ravel()
    rows = np.setdiff1d(np.arange(model.K.shape[0]), held)
    for said in (clamped, words(model, rows, backend)):
        assert "free to move as a rigid body: 1 motion not held, node " in said
        assert re.search(r"\(x = 0.3, y = 0.1, z = [\d.]+\) in x, y the most; hold a set", said)
        assert "without stiffness" not in said


@every_backend
def test_two_bodies_that_hang_at_an_edge_are_a_mechanism(lattice, backend):
    # Of 2 x 2 boxes in the plane two opposite ones: they share the edge x = y = 0.5.
    part = lattice((2, 2, 1))
    centre = part.points[part.cells].mean(axis=1)
    part = without(part, (centre[:, 0] < 0.5) == (centre[:, 1] < 0.5))
    said = words(assemble(part, STEEL, fixed="x0"), backend=backend)
    swinging = np.sum((part.points[:, :2] > 0.5).any(axis=1) & (part.points[:, 0] >= 0.5))
    named = re.search(
        r"^tetra10: 1 motion of some nodes without stiffness: node \d+ \(x = 1, y = 1, z = \S+\) "
        r"in x, y, node .* and (\d+) other nodes; join or hold these nodes$",
        said,
    )
    assert named is not None
    assert int(named.group(1)) == swinging - 3
    free = words(assemble(part, STEEL), backend=backend)
    assert "rigid body: 6 motions not held; 1 motion of some nodes without stiffness" in free


def softened(model, gone):
    """The model without any stiffness in some dofs."""
    K = model.K.tolil()
    K[gone, :] = 0
    K[:, gone] = 0
    return dataclasses.replace(model, K=K.tocsc())


@every_backend
def test_node_without_stiffness_is_named(lattice, backend):
    part = lattice((2, 1, 1), lambda p: p * [0.3, 0.1, 0.1])
    model = assemble(part, STEEL, fixed="x0")
    node = int(part.node_sets["x1"][4])
    said = words(softened(model, model.dofs[node][[0, 2]]), backend=backend)
    x, y, z = part.points[node]
    assert said == (
        f"tetra10: 2 motions of some nodes without stiffness: node {node} (x = {x:g}, y = {y:g}, "
        f"z = {z:g}) in x, z; join or hold these nodes"
    )


@pytest.mark.parametrize(("count", "others"), [(4, "1 other node"), (5, "2 other nodes")])
def test_nodes_beyond_the_third_are_counted(lattice, count, others):
    part = lattice((2, 1, 1), lambda p: p * [0.3, 0.1, 0.1])
    model = assemble(part, STEEL, fixed="x0")
    said = words(softened(model, model.dofs[part.node_sets["x1"][:count], 0]))
    assert f"{count} motions of some nodes without stiffness" in said
    assert said.count(" in x") == 3
    assert said.endswith(f" and {others}; join or hold these nodes")
