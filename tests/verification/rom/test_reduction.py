"""Reduced models of vane and casing against the unreduced sector, and of a whole bladed ring."""

from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as sl

from benchmarks.rom.direct import direct
from benchmarks.unreduced import unreduced_segment as unreduced
from tests.conftest import FULL
from tests.verification.conftest import whole_ring
from vanelock import fem, rom
from vanelock.stages.parts.segment import Segment

STEEL = fem.Material(E=170e9, nu=0.3, rho=8200)
SHARED = ("hook_front", "hook_rear", "key", "output")
VANE = (*SHARED, "interlock_left", "interlock_right")
CASING = (*SHARED, "force")
DIAMETERS = (0, 1, 3) if FULL else (1,)
COUNT = 10
CLEAR = 0.0 if FULL else 400.0
"""Hz; of the sample's small parts lower frequencies are rounded by more."""


@pytest.fixture(scope="module")
def both_parts(scene):
    """Both models, their reductions, and frequencies of the unreduced sector."""
    vane, casing = scene.vane_model, scene.casing_model
    joints = {"free": scene.joints[:1], "stuck": scene.joints}

    @lru_cache
    def truth(k, interlock):
        K, M = unreduced(vane, casing, joints[interlock], k)
        return np.sqrt(fem.eigenpairs(K, M, COUNT)[0]) / (2 * np.pi)

    @lru_cache
    def by_accuracy(accuracy):
        blade = rom.reduce(vane, VANE, accuracy=accuracy)
        shell = rom.reduce(
            casing, CASING, nodal_diameters=DIAMETERS, accuracy=accuracy, band=blade.band
        )
        return blade, shell, Segment(joints["stuck"], 1, force=1.0).join(blade, shell)

    @lru_cache
    def vane_by_modes(modes):
        return rom.reduce(vane, VANE, modes)

    return SimpleNamespace(
        vane=vane,
        casing=casing,
        joints=joints,
        truth=truth,
        by_accuracy=by_accuracy,
        vane_by_modes=vane_by_modes,
    )


def rounding(frequencies):
    """Relative, of frequencies, Hz."""
    return np.where(frequencies > CLEAR, 1e-9, 1e-7)


def closed(system, interlock):
    chosen = np.array([name == "hook" for name in system.contacts.joint])
    return chosen if interlock == "free" else np.ones_like(chosen)


@pytest.mark.parametrize("interlock", ["free", "stuck"])
@pytest.mark.parametrize("k", DIAMETERS)
@pytest.mark.parametrize("accuracy", [None, 1e-6])
def test_ten_frequencies_and_their_estimates(both_parts, accuracy, k, interlock, record):
    """Default settings within 1e-4, an accuracy of 1e-6 within that; estimates near the truth."""
    *parts, system = both_parts.by_accuracy(accuracy)
    parts = {part.masters.part: part for part in parts}
    truth = both_parts.truth(k, interlock)
    errors = rom.frequency_errors(system, parts, k, COUNT, closed(system, interlock))
    found = errors.frequency / truth - 1
    record("coordinates", len(system.at(k).K))
    record("worst error", f"{found.max():.1e}")
    seen = found > rounding(truth)
    ratio = errors.total[seen] / found[seen]
    if seen.any():
        record("estimate / error", f"{ratio.min():.2f} to {ratio.max():.2f}")
    assert np.all(found > -rounding(truth))
    assert np.all(found < (accuracy or 1e-4))
    assert np.all(ratio > 0.5)
    assert np.all(ratio < 10)


def orthonormal(model, x):
    """M-orthonormal basis of the columns of x, by Gram's matrix of scaled columns, twice."""
    for _ in range(2):
        gram = x.conj().T @ (model.M @ x)
        scale = 1 / np.sqrt(np.diagonal(gram).real)
        values, V = sl.eigh(scale[:, None] * gram * scale)
        x = x @ (scale[:, None] * V / np.sqrt(values))
    return x


@pytest.mark.parametrize("k", DIAMETERS)
def test_paper_and_direct_are_the_same_model(both_parts, k, below):
    """Of the route "paper" and of the way that forms no column for a node of the faces."""
    model = both_parts.casing
    bases, values = [], []
    paper = casing_by_modes(both_parts, "paper", 10, 10)
    for part in (paper, direct(model, CASING, 10, DIAMETERS)):
        values.append(sl.eigvalsh(part.at(k).K, part.at(k).M))
        u = rom.recovery(part, model).displacement(np.eye(part.size), k)
        x = u[model.dofs[:, 0] >= 0].reshape(model.K.shape[0], -1)
        bases.append(orthonormal(model, x))
    a, b = bases
    left = a - b @ (b.conj().T @ (model.M @ a))
    sine = np.sqrt(np.linalg.eigvalsh(left.conj().T @ (model.M @ left))[-1].clip(0))
    difference = np.abs(np.sqrt(values[1] / values[0]) - 1)
    below("largest principal angle", sine, 1e-9)
    below("frequencies", difference.max(), 1e-9)


cache: dict[tuple[object, ...], rom.Component] = {}


def casing_by_modes(parts, route, modes, interface_modes):
    """The casing at all diameters, kept for the next test."""
    key = (route, modes, interface_modes)
    if key not in cache:
        cache[key] = rom.reduce(
            parts.casing, CASING, modes, DIAMETERS, route, interface_modes=interface_modes
        )
    return cache[key]


@pytest.mark.parametrize("route", ["cyclic", "paper"])
@pytest.mark.parametrize("k", DIAMETERS)
def test_no_frequency_rises_as_modes_are_added(both_parts, route, k, record):
    """Rayleigh and Ritz: more of anything lowers every frequency, and none below the truth."""
    steps = [(5, 5, 5), (10, 10, 5), (10, 10, 10), (20, 20, 10), (20, 20, 40), (40, 40, 40)]
    if not FULL:
        steps = [(5, 5, 10), (10, 10, 10), (10, 10, 20)]
    if route == "cyclic":
        steps = [(5, 5, 0), (10, 10, 0), (20, 20, 0), (40, 40, 0)][: 4 if FULL else 2]
    truth = both_parts.truth(k, "stuck")
    last, second = np.full(COUNT, np.inf), []
    for blade_modes, shell_modes, faces in steps:
        blade = both_parts.vane_by_modes(blade_modes)
        shell = casing_by_modes(both_parts, route, shell_modes, faces or None)
        system = Segment(both_parts.joints["stuck"], 1, force=1.0).join(blade, shell)
        found = rom.linear_modes(system, k, COUNT)[0]
        second.append(found[1] / truth[1] - 1)
        assert np.all(found < last * (1 + rounding(truth)))
        assert np.all(found > truth * (1 - rounding(truth)))
        last = found
    record("second frequency's error", ", ".join(f"{error:.1e}" for error in second))


@pytest.mark.parametrize("interlock", ["free", "stuck"] if FULL else ["free"])
@pytest.mark.parametrize("accuracy", [1e-2, None] if FULL else [None])
def test_response_and_its_estimated_error(both_parts, accuracy, interlock, record):
    """Outputs around the lowest resonances at ND 1 against the unreduced sector's."""
    *parts, system = both_parts.by_accuracy(accuracy)
    parts = {part.masters.part: part for part in parts}
    K, M = unreduced(both_parts.vane, both_parts.casing, both_parts.joints[interlock], 1)
    resonance = both_parts.truth(1, interlock)[0 if FULL else 1 : 3]
    frequencies = np.concatenate([resonance * 0.99, resonance * 1.02, resonance * 1.2])
    chosen = closed(system, interlock)
    output, error = rom.response_errors(system, parts, frequencies, chosen)
    load, rows = load_and_outputs(both_parts)
    # The lowest modes by themselves, what is left by iteration on statics: all of it definite.
    factor = fem.factorise(K)
    squared, V = fem.eigenpairs(K, M, 24, factor=factor)
    push, omega2 = load[:, None], (2 * np.pi * frequencies) ** 2
    rest, x = push - M @ (V @ (V.conj().T @ push)), np.zeros((len(load), len(omega2)), complex)
    for _ in range(16):
        x = factor.solve(rest + omega2 * (M @ x))
        x -= V @ (V.conj().T @ (M @ x))
    x += V @ (V.conj().T @ push / (squared[:, None] - omega2))
    # The residual as a displacement; a static response is that of a frequency far below.
    wrong = factor.solve(K @ x - omega2 * (M @ x) - push)
    assert np.all(np.linalg.norm(wrong, axis=0) < 1e-9 * np.linalg.norm(x, axis=0))
    exact = (rows @ x).T.reshape(len(omega2), -1, 3)
    missing = exact - output
    size = np.abs(exact).max(axis=2)
    true, estimated = (np.abs(a).max(axis=2) / size for a in (missing, error))
    record("worst error", f"{true.max():.1e}")
    seen = true > 1e-8
    ratio = estimated[seen] / true[seen]
    record("estimate / error", f"{ratio.min():.2f} to {ratio.max():.2f}")
    assert np.all(ratio > 0.3)
    assert np.all(ratio < 3)


def load_and_outputs(parts):
    """Radial travelling load on the force nodes, and output rows, of the unreduced sector."""
    T = fem.cyclic_transform(parts.casing, 1).tocsr()
    keys = parts.vane.dofs[parts.vane.part.node_sets["key"]].ravel()
    rest = np.setdiff1d(np.arange(parts.vane.K.shape[0]), keys)
    n = T.shape[1] + len(rest)
    load, rows = np.zeros(n, complex), []
    for node in parts.casing.part.node_sets["force"]:
        x, y, _ = parts.casing.part.points[node]
        angle = np.arctan2(y, x)
        radial = np.array([np.cos(angle), np.sin(angle), 0])
        load[T.indices[T.indptr[parts.casing.dofs[node]]]] = radial * np.exp(-1j * angle)
    for model in (parts.vane, parts.casing):
        for node in model.part.node_sets["output"]:
            dofs = model.dofs[node]
            if model is parts.vane:
                place = T.shape[1] + np.searchsorted(rest, dofs)
            else:
                place = T.indices[T.indptr[dofs]]
            x, y, _ = model.part.points[node] / np.hypot(*model.part.points[node][:2])
            row = np.zeros((3, n))
            row[:, place] = [[x, y, 0], [-y, x, 0], [0, 0, 1]]
            rows.append(row)
    return load, np.vstack(rows)


@pytest.fixture(scope="module")
def bladed_ring(lattice):
    """A sector of a rim with one blade, and frequencies of the whole ring by a sparse assembly."""
    N = 9

    def place(p):
        r, angle = 0.4 + 0.2 * p[:, 0], 2 * np.pi / N * (p[:, 1] - 0.5)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.08 * p[:, 2]])

    part = lattice((4, 3, 2), place, "tetra10", curved=True, sectors=N)
    # The blade: of the three outer layers of boxes the middle one alone is left.
    middle = part.points[part.cells].mean(axis=1)
    radius, angle = np.hypot(middle[:, 0], middle[:, 1]), np.arctan2(middle[:, 1], middle[:, 0])
    kept = (radius < 0.45) | (np.abs(angle) < np.pi / N / 3)
    used, cells = np.unique(part.cells[kept], return_inverse=True)
    number = np.full(len(part.points), -1)
    number[used] = np.arange(len(used))
    sets = {name: number[nodes] for name, nodes in part.node_sets.items()}
    sets = {name: nodes[nodes >= 0] for name, nodes in sets.items()}
    # Both faces in one order: that of their places in the lattice.
    sets |= {"left": sets["y0"], "right": sets["y1"], "clamped": sets["x0"], "tip": sets["x1"]}
    part = replace(part, points=part.points[used], cells=cells.reshape(-1, 10), node_sets=sets)
    model = fem.assemble(part, STEEL, fixed="clamped")

    whole = fem.assemble(whole_ring(part)[0], STEEL, fixed="clamped")
    squared = fem.eigenpairs(whole.K, whole.M, 40)[0]
    return model, np.sqrt(squared) / (2 * np.pi), whole.K.shape[0]


@pytest.mark.parametrize("route", ["cyclic", "paper"])
def test_whole_ring_against_the_reduced_sector_at_every_diameter(bladed_ring, route, record, below):
    """Forty frequencies of the 360 degree assembly, each diameter 1 ... (N-1)/2 twice."""
    model, truth, size = bladed_ring
    N = model.part.sectors
    options = {"accuracy": 1e-9, "band": 1.05 * truth[-1]}
    if route == "paper":
        face = 3 * np.sum(model.dofs[model.part.node_sets["left"], 0] >= 0)
        options = {"cutoff": 40 * truth[-1], "interface_modes": int(face)}
    part = rom.reduce(model, ("tip",), nodal_diameters=range(N // 2 + 1), route=route, **options)
    found = []
    for k in range(N // 2 + 1):
        reduced = part.at(k)
        squared = sl.eigvalsh(reduced.K, reduced.M, subset_by_index=[0, 24])
        found += list(np.sqrt(squared) / (2 * np.pi)) * (1 if k == 0 else 2)
    difference = np.sort(found)[: len(truth)] / truth - 1
    record("dofs", f"{size} of the ring, {part.size} at each diameter")
    below("largest difference", np.abs(difference).max(), 1e-9 if route == "cyclic" else 1e-6)
