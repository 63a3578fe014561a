"""Block Lanczos on matrices whose spectrum is chosen."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.fem.block_lanczos import BLOCK, KrylovSpace, lowest_modes


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


@pytest.mark.parametrize("n", [1, 2, 7, 8, 9, 17, 40])
def test_whole_spectrum_of_a_small_problem(n):
    values = np.linspace(1.0, 1e3, n) ** 2
    for count in {max(1, n - 1), n}:
        np.testing.assert_allclose(found(values, count)[0], values[:count], rtol=1e-9)


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
    with pytest.raises(InputError, match="51 modes: the part has 50"):
        found(SPREAD[:50], 51)


@pytest.mark.parametrize("rank", [1, 3])
def test_start_of_dependent_columns(rank):
    rng = np.random.default_rng(3)
    start = rng.standard_normal((len(SPREAD), rank)) @ rng.standard_normal((rank, BLOCK))
    start[:, 1] = 0.0
    squared, _ = found(SPREAD, 15, start)
    np.testing.assert_allclose(squared, SPREAD[:15], rtol=1e-11)


def test_no_answer_is_no_silent_one(monkeypatch):
    monkeypatch.setattr("vanelock.fem.block_lanczos._LARGEST", 2)
    with pytest.raises(InputError, match="did not converge"):
        found(SPREAD, 30)


def test_a_mistyped_limit_is_refused_early():
    values = np.linspace(1.0, 2.0, 520)
    with pytest.raises(InputError, match="more than 500 fixed-interface modes below 1.592 Hz"):
        found(values, None, below=100.0)
    with pytest.raises(InputError, match=r"the lowest at 0\.1592 Hz: are densities and moduli in"):
        found(values, None, below=1e12)
