"""Eigenpairs against closed forms and dense solutions; cyclic symmetry against the ring."""

import dataclasses

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

from tests.fem.conftest import STEEL
from tests.verification.conftest import whole_ring
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.fem import Material, Modes, assemble, cyclic_transform, eigenpairs, factorise, modes
from vanelock.mesh import FileMesh


def chain(n, phase=None):
    """Stiffness and mass of n unit masses on unit springs: between walls, or a ring if `phase`.

    The ring's unit cell is all of it; its ends meet with e^{-i phase}.
    """
    off = -np.ones(n - 1)
    K = sp.diags_array([off, np.full(n, 2.0), off], offsets=[-1, 0, 1]).tolil()
    if phase is not None:
        K = K.astype(complex)
        K[n - 1, 0] = -np.exp(1j * phase)
        K[0, n - 1] = -np.exp(-1j * phase)
    return K.tocsc(), sp.eye_array(n, format="csc")


@pytest.mark.parametrize("n", [30, 1000])  # dense and Lanczos
def test_chain_of_masses(n):
    values, vectors = eigenpairs(*chain(n), 6)
    k = np.arange(1, 7)
    np.testing.assert_allclose(values, 2 - 2 * np.cos(k * np.pi / (n + 1)), rtol=1e-9)
    exact = np.sin(np.outer(np.arange(1, n + 1), k) * np.pi / (n + 1)) * np.sqrt(2 / (n + 1))
    np.testing.assert_allclose(abs(vectors.T @ exact), np.eye(6), atol=1e-9)


@pytest.mark.parametrize("n", [30, 1000])
@pytest.mark.parametrize("phase", [0.7, np.pi, 0.0])
def test_ring_of_masses_with_a_phase(n, phase):
    # Waves e^{iθj} with n θ = phase + 2πm; pairs of equal eigenvalues at 0 and π.
    K, M = chain(n, phase)
    values, vectors = eigenpairs(K, M, 7, shift=-1e-5)
    angles = (phase + 2 * np.pi * np.arange(-6, 7)) / n
    exact = np.sort(2 - 2 * np.cos(angles))[:7]
    np.testing.assert_allclose(values, exact, rtol=1e-9, atol=1e-13)
    assert np.iscomplexobj(vectors)
    np.testing.assert_allclose(vectors.conj().T @ vectors, np.eye(7), atol=1e-12)
    np.testing.assert_allclose(K @ vectors, vectors * values, atol=1e-10)


def test_repeated_eigenvalues_are_all_found(lattice):
    # The free cube's symmetry makes many frequencies double or triple, beside six rigid motions.
    model = assemble(lattice((3, 3, 3)), Material(E=1.0, nu=0.3, rho=1.0))
    assert model.K.shape[0] > 800
    exact = scipy.linalg.eigh(
        model.K.toarray(), model.M.toarray(), eigvals_only=True, subset_by_index=[0, 39]
    )
    for count in range(7, 41, 3):
        values, vectors = eigenpairs(model.K, model.M, count, shift=-0.01)
        np.testing.assert_allclose(values, exact[:count], rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(vectors.T @ model.M @ vectors, np.eye(40), atol=1e-11)
    stiffness = vectors.T @ model.K @ vectors
    np.testing.assert_allclose(stiffness, np.diag(values), atol=1e-10 * values[-1])
    assert np.all(vectors.max(axis=0) > -vectors.min(axis=0))  # the largest component is positive


def test_result_is_the_same_to_the_last_bit():
    for phase in (None, 0.7):
        K, M = chain(500, phase)
        first, second = eigenpairs(K, M, 5), eigenpairs(K, M, 5)
        np.testing.assert_array_equal(first[0], second[0])
        np.testing.assert_array_equal(first[1], second[1])


def test_given_factor_is_used():
    K, M = chain(400)
    shift = -0.5
    values, _ = eigenpairs(K, M, 4, shift, factor=factorise(K - shift * M, "superlu"))
    k = np.arange(1, 5)
    np.testing.assert_allclose(values, 2 - 2 * np.cos(k * np.pi / 401), rtol=1e-9)


def test_impossible_request_is_refused():
    K, M = chain(30)
    for count in (0, 31):
        with pytest.raises(InputError, match=f"count = {count}: a model of 30 dofs"):
            eigenpairs(K, M, count)
    assert len(eigenpairs(K, M, 30)[0]) == 30
    with pytest.raises(InputError, match="not positive definite"):
        eigenpairs(K, M, 3, shift=1.0)


def wedge(lattice, sectors, counts=(1, 2, 1), fixed=None):
    """Sector of a ring of lopsided blades: no symmetry but the rotation."""

    def place(p):
        x, y, z = p.T
        angle = 2 * np.pi / sectors * y + 0.2 * z  # a helical cut, and so slanted faces
        r = 0.3 + 0.1 * x + 0.02 * np.sin(2 * np.pi * y) * (x + 0.5 * z)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.05 * z + 0.02 * x * x])

    part = lattice(counts, place, sectors=sectors)
    sets = {"left": part.node_sets["y0"], "right": part.node_sets["y1"]}
    if fixed is not None:
        sets["fixed"] = part.node_sets[fixed]
    return dataclasses.replace(part, node_sets=sets)


@pytest.mark.parametrize("nodal_diameter", [0, 1, 2, 3, 4, 5, -1])
def test_wave_spread_over_the_ring_is_a_mode_of_it(lattice, nodal_diameter):
    part = wedge(lattice, 6, counts=(2, 2, 2), fixed="x0")
    whole, number = whole_ring(part)
    full = assemble(whole, STEEL)
    found = modes(assemble(part, STEEL), 4, nodal_diameter)
    assert found.nodal_diameter == nodal_diameter
    for f, shape in zip(found.frequency, found.shapes.transpose(2, 0, 1), strict=True):
        field = np.full((len(whole.points), 3), np.nan, complex)
        for j in range(6):
            here = shape @ turn(6, j).T * np.exp(-2j * np.pi * nodal_diameter * j / 6)
            known = ~np.isnan(field[number[j]])
            assert (
                abs(field[number[j]][known] - here[known]).max(initial=0) < 1e-9 * abs(here).max()
            )
            field[number[j]] = here
        free = full.dofs >= 0
        x = np.empty(full.K.shape[0], complex)
        x[full.dofs[free]] = field[free]
        force = full.M @ x * (2 * np.pi * f) ** 2
        np.testing.assert_allclose(full.K @ x, force, atol=1e-8 * abs(force).max())
        assert (x.conj() @ full.M @ x).real == pytest.approx(6, rel=1e-10)  # one a sector


def test_opposite_waves_are_conjugate(lattice):
    model = assemble(wedge(lattice, 5), STEEL)
    assert abs(cyclic_transform(model, 2) - cyclic_transform(model, 3).conj()).max() < 1e-15
    assert abs(cyclic_transform(model, 2) - cyclic_transform(model, 7)).max() == 0
    assert abs(cyclic_transform(model, -2) - cyclic_transform(model, 3)).max() == 0


def test_clamped_nodes_on_the_faces(lattice):
    part = wedge(lattice, 6, counts=(2, 2, 2))
    left, right = part.node_sets["left"], part.node_sets["right"]
    both = np.concatenate([left[:4], right[:4]])
    found = []
    for clamped in (both, left[:4], right[:4]):  # holding one of two mates holds the other
        sets = part.node_sets | {"fixed": clamped}
        found.append(modes(assemble(dataclasses.replace(part, node_sets=sets), STEEL), 3, 2))
        np.testing.assert_allclose(found[-1].frequency, found[0].frequency, rtol=1e-10)
        assert abs(found[-1].shapes[both]).max() == 0
    free = modes(assemble(part, STEEL), 3, 2).frequency
    assert free[0] < 0.9 * found[0].frequency[0]


def test_modes_survive_their_file(lattice, tmp_path):
    found = modes(assemble(wedge(lattice, 6), STEEL), 3, 1)
    found.save(tmp_path / "modes.h5")
    again = Modes.load(tmp_path / "modes.h5")
    np.testing.assert_array_equal(again.frequency, found.frequency)
    np.testing.assert_array_equal(again.shapes, found.shapes)
    assert again.nodal_diameter == 1


def test_faces_that_do_not_match_are_refused(lattice):
    part = wedge(lattice, 6)
    model = assemble(part, STEEL)
    with pytest.raises(InputError, match="turned by 2π/7: the faces must match node by node"):
        cyclic_transform(model, 1, sectors=7)
    with pytest.raises(InputError, match="sectors = 1: cyclic symmetry needs at least 2"):
        cyclic_transform(model, 1, sectors=1)

    def without(**sets):
        return dataclasses.replace(model, part=dataclasses.replace(part, node_sets=sets))

    left, right = part.node_sets["left"], part.node_sets["right"]
    with pytest.raises(InputError, match="needs a node set 'right'"):
        cyclic_transform(without(left=left), 1)
    with pytest.raises(InputError, match=r"nodes in `left`, .* in `right`: they must match"):
        cyclic_transform(without(left=left, right=right[1:]), 1)
    with pytest.raises(InputError, match="right node .* lies"):
        cyclic_transform(without(left=left, right=right[::-1]), 1)


def test_a_mesh_from_a_file_is_one_sector_once_their_number_is_given(lattice):
    part = wedge(lattice, 5, fixed="x0")
    numbers = (np.arange(n) + 1 for n in (len(part.points), len(part.cells)))
    mesh = FileMesh(
        source="wedge.inp", points=part.points, numbers=next(numbers), cells=part.cells,
        elements=next(numbers), cell_type=part.cell_type, node_sets=part.node_sets, face_sets={},
        absent={},
    )  # fmt: skip
    model = assemble(mesh, STEEL)
    expected = modes(assemble(part, STEEL), 3, nodal_diameter=2).frequency
    found = modes(model, 3, nodal_diameter=2, sectors=5).frequency
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    with pytest.raises(InputError, match=r"wedge.inp: sectors = 1: cyclic symmetry needs at le"):
        modes(model, 3, nodal_diameter=2)
    whole = dataclasses.replace(mesh, node_sets={})
    with pytest.raises(InputError, match=r"wedge.inp: cyclic symmetry needs a node set 'left'"):
        modes(assemble(whole, STEEL), 3, nodal_diameter=2, sectors=5)
