"""Shift-invert Lanczos against closed forms and dense solutions."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

from vanelock.common.errors import InputError
from vanelock.fem import Material, assemble, eigenpairs, factorise


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
