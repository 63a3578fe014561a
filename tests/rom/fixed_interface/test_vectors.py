"""Which fixed-interface vectors are kept, against dense solutions of joined structures."""

import numpy as np
import pytest
import scipy.linalg as sl

from vanelock import rom

BANDS = (1500.0, 6000.0)


def structure(rng, K, M, kind):
    """A random structure on masters of stiffness K and mass M: its tie, stiffness and mass.

    Positive springs to the ground and between coordinates, masses, rigid ties of the masters to
    fewer coordinates, and a part with dofs of its own; sizes over several decades.
    """
    m = len(K)
    k, mass = np.trace(K) / m, np.trace(M) / m
    tie = np.eye(m)
    if kind == "ties":
        tie = rng.standard_normal((m, int(rng.integers(1, m + 1))))
    r, own = tie.shape[1], int(rng.integers(1, 4)) if kind in ("part", "all") else 0
    n = r + own
    Kx, Mx = np.zeros((n, n)), np.zeros((n, n))
    if kind in ("springs", "all"):
        for _ in range(int(rng.integers(1, 10))):
            b = np.zeros(n)
            ends = rng.choice(n, min(n, int(rng.integers(1, 3))), replace=False)
            b[ends] = rng.standard_normal(len(ends))
            Kx += np.outer(b, b) * k * 10 ** rng.uniform(-6, 2)
    if kind in ("masses", "all"):
        Mx += np.diag(mass * 10 ** rng.uniform(-4, 3, n))
    if own:
        A = rng.standard_normal((n, n))
        Kx += A @ A.T * k * 10 ** rng.uniform(-5, 1) / n
        Mx += np.diag(np.r_[np.zeros(r), mass * 10 ** rng.uniform(-3, 3, own)])
    return tie, Kx, Mx


@pytest.mark.parametrize("accuracy", [0.1, 1e-5])
@pytest.mark.parametrize("kind", ["springs", "masses", "ties", "part", "all"])
def test_every_frequency_of_every_structure_is_within_the_accuracy(bar, exact, kind, accuracy):
    worst = 0.0
    for seed in range(3):
        band = BANDS[seed % 2]
        model = bar(masters=(3, 6, 9)[seed % 3], seed=seed, counts=(4, 1, 1))
        component = rom.reduce(model, ("held",), accuracy=accuracy, band=band)
        reduced, m = component.at(0), 3 * len(component.masters.nodes)
        K, M, rows = exact.dense(model, "held")
        rng = np.random.default_rng(100 + seed)
        for _ in range(3):
            added = structure(rng, reduced.K[:m, :m], reduced.M[:m, :m], kind)
            truth = exact.frequencies(*exact.joined(K, M, rows, *added), 40)
            small = exact.joined(reduced.K, reduced.M, np.arange(m), *added)
            found = exact.frequencies(*small, 40)
            count = int(np.sum(truth < band))
            assert count <= len(found)
            # A free body's zero frequencies are zero to round-off alone.
            low = truth[:count] < 5.0
            assert np.all(found[:count][low] < 5.0)
            error = (found[:count] / np.where(low, 1, truth[:count]) - 1)[~low]
            assert np.all(error > -1e-7)
            worst = max(worst, error.max(initial=0.0))
    assert worst < accuracy


def fixed_frequencies(exact, model, masters, nodal_diameter=None):
    K, M, rows = exact.dense(model, masters, nodal_diameter)
    rest = np.setdiff1d(np.arange(len(K)), rows)
    omega2 = sl.eigh(K[np.ix_(rest, rest)], M[np.ix_(rest, rest)], eigvals_only=True)
    return np.sqrt(omega2) / (2 * np.pi)


def test_cutoff_keeps_exactly_the_modes_below(bar, exact):
    model = bar()
    truth = fixed_frequencies(exact, model, "held")
    for count in (0, 1, 7, 8, 9, 30):
        cutoff = np.mean(truth[[count - 1, count]]) if count else truth[0] / 2
        component = rom.reduce(model, ("held",), cutoff=cutoff)
        reduced = component.at(0)
        assert component.fixed_modes == count
        own = np.sqrt(np.diagonal(reduced.K)[component.size - count :]) / (2 * np.pi)
        np.testing.assert_allclose(own, truth[:count], rtol=1e-9)
        assert reduced.complete == pytest.approx(truth[count], rel=1e-4)


def test_cutoff_above_the_spectrum_keeps_every_mode_and_the_model_is_exact(bar, exact):
    model = bar(masters=3, counts=(2, 1, 1))
    K, M, rows = exact.dense(model, "held")
    slaves = len(K) - len(rows)
    truth = sl.eigh(K, M, eigvals_only=True)
    for option in ({"cutoff": 1e8}, {"modes": slaves}, {"accuracy": 1e-9, "band": 1e8}):
        component = rom.reduce(model, ("held",), **option)
        assert component.fixed_modes == slaves
        assert component.at(0).complete == np.inf
        found = sl.eigh(component.at(0).K, component.at(0).M, eigvals_only=True)
        np.testing.assert_allclose(found[6:], truth[6:], rtol=1e-8)


@pytest.mark.parametrize(("masters", "option"), [
    (1, {"accuracy": 1e-3, "band": 10000.0}),
    (4, {"accuracy": 1e-8, "band": 10000.0}),
    (1, {"cutoff": 20000.0}),
    (4, {}),
], ids=["accuracy", "fine", "cutoff", "default"])  # fmt: skip
def test_equally_many_vectors_at_all_diameters(ring_sector, exact, masters, option):
    """Some diameters keep more than they need, and every one what it needs."""
    model, diameters = ring_sector(masters=masters), range(5)
    component = rom.reduce(model, ("force",), nodal_diameters=diameters, **option)
    alone = [rom.reduce(model, ("force",), nodal_diameters=[k], **option) for k in diameters]
    assert component.fixed_modes == max(part.fixed_modes for part in alone)
    assert len({part.fixed_modes for part in alone}) > 1
    for k, part in zip(diameters, alone, strict=True):
        reduced = component.at(k)
        assert reduced.K.shape == (component.size, component.size)
        # More vectors never raise a frequency, and the full model's are below them all.
        K, M, _ = exact.dense(model, "force", k)
        truth = exact.frequencies(K, M, part.size)
        fewer = exact.frequencies(part.at(k).K, part.at(k).M, part.size)
        found = exact.frequencies(reduced.K, reduced.M, part.size)
        assert np.all(found < fewer * (1 + 1e-9))
        assert np.all(found > truth * (1 - 1e-9))
        # The vectors are what the matrices say: mass-normalised, Ω² their stiffness.
        f = component.fixed_modes
        np.testing.assert_array_equal(reduced.M[-f:, -f:], np.eye(f))
        assert np.all(np.diagonal(reduced.K)[-f:] > 0)
        recovered = rom.recovery(component, model).displacement(np.eye(component.size), k)
        u = recovered[model.dofs[:, 0] >= 0].reshape(model.K.shape[0], -1)
        M_full = u.conj().T @ (model.M @ u)
        K_full = u.conj().T @ (model.K @ u)
        scale = np.sqrt(np.diagonal(reduced.K).real)
        np.testing.assert_allclose(
            K_full / scale / scale[:, None], reduced.K / scale / scale[:, None], atol=1e-9
        )
        np.testing.assert_allclose(M_full, reduced.M, atol=1e-9 * abs(reduced.M).max())


def test_no_masters_leave_the_parts_own_modes(bar, ring_sector, exact):
    model = bar(fixed="x0")
    K, M, _ = exact.dense(model, "held")
    truth = exact.frequencies(K, M, 30)
    component = rom.reduce(model, (), accuracy=1e-4, band=3000.0)
    found = exact.frequencies(component.at(0).K, component.at(0).M, 30)
    np.testing.assert_allclose(found, truth[: len(found)], rtol=1e-9)
    assert component.fixed_modes == component.size == np.sum(truth < 6000.0)
    ring = ring_sector()
    component = rom.reduce(ring, (), 5, nodal_diameters=[2])
    K, M, _ = exact.dense(ring, "force", 2)
    found = exact.frequencies(component.at(2).K, component.at(2).M, 5)
    np.testing.assert_allclose(found, exact.frequencies(K, M, 5), rtol=1e-9)


def test_the_band_is_at_least_what_is_asked_for(bar, exact):
    """The receptance of a bar at its band's end, far beyond its tenth elastic mode."""
    model = bar(fixed="x0")
    own = rom.reduce(model, ["held"])
    asked = 3 * own.band
    wide = rom.reduce(model, ["held"], least=asked)
    assert wide.band == asked
    assert rom.reduce(model, ["held"], least=0.5 * own.band).band == own.band
    K, M, rows = exact.dense(model, "held")
    squared = (2 * np.pi * asked / 1.05) ** 2
    true = np.linalg.inv(K - squared * M)[np.ix_(rows, rows)]
    errors = []
    for part in (own, wide):
        at, held = part.at(0), part.dofs(model.part.node_sets["held"]).ravel()
        found = np.linalg.inv(at.K - squared * at.M)[np.ix_(held, held)]
        errors.append(np.abs(found - true).max() / np.abs(true).max())
    assert errors[1] < 1e-3 < errors[0]
