"""Eigenpairs against closed forms and chosen spectra; cyclic symmetry."""

import dataclasses

import numpy as np
import pytest
import scipy.sparse as sp

from tests.fem.conftest import STEEL
from tests.refusals import refused
from vanelock.common.errors import InputError
from vanelock.fem import Modes, assemble, cyclic_transform, eigenpairs, factorise, modes
from vanelock.fem.block_lanczos import BLOCK, KrylovSpace, lowest_modes
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
        refused(f"count = {count}: a model of 30 dofs", eigenpairs, K, M, count)
    assert len(eigenpairs(K, M, 30)[0]) == 30
    refused("not positive definite", eigenpairs, K, M, 3, shift=1.0)


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
    refused("sectors = 1: cyclic symmetry needs at least 2", cyclic_transform, model, 1, sectors=1)

    def without(**sets):
        return dataclasses.replace(model, part=dataclasses.replace(part, node_sets=sets))

    left, right = part.node_sets["left"], part.node_sets["right"]
    refused("needs a node set 'right'", cyclic_transform, without(left=left), 1)
    with pytest.raises(InputError, match=r"nodes in `left`, .* in `right`: they must match"):
        cyclic_transform(without(left=left, right=right[1:]), 1)
    refused("right node .* lies", cyclic_transform, without(left=left, right=right[::-1]), 1)


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


def pencil(values, is_complex=False, seed=0):
    """K⁻¹, M and mass-normalised vectors of a dense pencil with the given eigenvalues."""
    rng, n = np.random.default_rng(seed), len(values)
    A, B = rng.standard_normal((2, n, n))
    Q = np.linalg.qr(A + 1j * B if is_complex else A)[0]
    L = np.tril(rng.uniform(-0.1, 0.1, (n, n)), -1) + np.diag(rng.uniform(0.5, 2.0, n))
    X = np.linalg.solve(L.T, Q)
    return (X / values) @ X.conj().T, L @ L.T, X


def found(values, count, start=None, seed=0, is_complex=False, **options):
    """What Lanczos finds, and its vectors' components in the exact ones."""
    inverse, M, X = pencil(values, is_complex, seed)
    n = len(values)
    if start is None:
        start = np.random.default_rng(seed + 1).standard_normal((n, min(n, BLOCK)))

    space = KrylovSpace(lambda b: inverse @ b, lambda x: M @ x, start.astype(inverse.dtype))
    modes = lowest_modes(space, count, **options)
    squared, vectors = modes.omega_squared, modes.vectors
    assert np.all(np.diff(squared) >= 0)
    gram = vectors.conj().T @ M @ vectors
    np.testing.assert_allclose(gram, np.eye(gram.shape[0]), atol=1e-12)
    return squared, X.conj().T @ M @ vectors


SPREAD = np.geomspace(1.0, 1e8, 140)
SPECTRA = {
    "spread": SPREAD,
    "cluster of 6": np.r_[1 + 1e-9 * np.arange(6), SPREAD[1:] + 1],
    "8 copies": np.r_[np.ones(8), SPREAD[1:] + 1], "9 copies": np.r_[np.ones(9), SPREAD[1:] + 1],
    "30 copies, but for 1e-12": np.r_[1 + 1e-12 * np.arange(30), SPREAD[1:] + 1],
    "9 copies higher up": np.sort(np.r_[SPREAD, np.full(8, SPREAD[5])]),
    "two values alone": np.repeat([1.0, 2.0], 60), "one value alone": np.ones(60),
}  # fmt: skip


@pytest.mark.parametrize("is_complex", [False, True], ids=["real", "Hermitian"])
@pytest.mark.parametrize("name", SPECTRA)
def test_lowest_values_with_all_their_copies(name, is_complex):
    values = SPECTRA[name]
    for count in (1, 9, 33):
        squared, components = found(values, count, is_complex=is_complex)
        assert len(squared) == count
        np.testing.assert_allclose(squared, np.sort(values)[:count], rtol=1e-10)
        # The vectors have no part in modes that are not their own.
        foreign = np.abs(values[:, None] - squared) > 1e-3 * squared
        assert np.abs(components[foreign]).max(initial=0.0) < 1e-8


@pytest.mark.parametrize("name", SPECTRA)
def test_all_below_an_eigenvalue_and_none_above(name):
    """Exactly those, and the next one is no lower than what is promised."""
    values = np.sort(SPECTRA[name])
    inverse, M, _ = pencil(values)
    start = np.random.default_rng(0).standard_normal((len(values), BLOCK))
    for last in (0, 1, 9, 33, 60):
        if last < len(values) - 1 and values[last] > 1.0001 * values[max(last - 1, 0)]:
            below = np.sqrt(values[last - 1] * values[last]) if last else 0.5 * values[0]
        else:  # not between two that are equal
            below = 0.9 * values[0] if last == 0 else 1.5
        space = KrylovSpace(lambda b: inverse @ b, lambda x: M @ x, start)
        modes = lowest_modes(space, below=below)
        inside = int(np.sum(values < below))
        assert modes.vectors.shape == (len(values), inside)
        np.testing.assert_allclose(modes.omega_squared, values[:inside], rtol=1e-10)
        assert below < modes.beyond
        assert modes.beyond <= values[inside:].min(initial=np.inf) * (1 + 1e-9)


@pytest.mark.parametrize("name", SPECTRA)
def test_a_search_goes_on_where_another_ended(name):
    values = np.sort(SPECTRA[name])
    inverse, M, X = pencil(values)
    start = np.random.default_rng(0).standard_normal((len(values), BLOCK))

    def space():
        solves = []

        def solve(b):
            solves.append(b.shape[1])
            return inverse @ b

        return KrylovSpace(solve, lambda x: M @ x, start), solves

    one, spent = space()
    lowest_modes(one, 5, tolerance=0.03)
    rough = len(spent)
    modes = lowest_modes(one, 20)
    np.testing.assert_allclose(modes.omega_squared, values[:20], rtol=1e-10)
    foreign = np.abs(values[:, None] - modes.omega_squared) > 1e-3 * modes.omega_squared
    assert np.abs((X.T @ M @ modes.vectors)[foreign]).max(initial=0.0) < 1e-8
    alone, all_of_them = space()
    lowest_modes(alone, 20)
    assert len(spent) <= max(len(all_of_them), rough) + 2  # a last step each, and one to begin with


def test_all_there_are():
    """Who asks for all modes below a frequency beyond the highest one gets every mode."""
    inverse, M, _ = pencil(SPREAD[:50])
    start = np.random.default_rng(0).standard_normal((50, BLOCK))
    modes = lowest_modes(KrylovSpace(lambda b: inverse @ b, lambda x: M @ x, start))
    assert modes.vectors.shape == (50, 50)
    assert modes.beyond == np.inf
    np.testing.assert_allclose(modes.omega_squared, SPREAD[:50], rtol=1e-9)
    refused("51 modes: the part has 50", found, SPREAD[:50], 51)


@pytest.mark.parametrize("rank", [1, 3])
def test_start_of_dependent_columns(rank):
    rng = np.random.default_rng(3)
    start = rng.standard_normal((len(SPREAD), rank)) @ rng.standard_normal((rank, BLOCK))
    start[:, 1] = 0.0
    squared, _ = found(SPREAD, 15, start)
    np.testing.assert_allclose(squared, SPREAD[:15], rtol=1e-11)


def test_no_answer_is_no_silent_one(monkeypatch):
    monkeypatch.setattr("vanelock.fem.block_lanczos._LARGEST", 2)
    refused("did not converge", found, SPREAD, 30)


def test_a_mistyped_limit_is_refused_early():
    values = np.linspace(1.0, 2.0, 520)
    refused("more than 500 fixed-interface modes below 1.592 Hz", found, values, None, below=100.0)
    with pytest.raises(InputError, match=r"the lowest at 0\.1592 Hz: are densities and moduli in"):
        found(values, None, below=1e12)
