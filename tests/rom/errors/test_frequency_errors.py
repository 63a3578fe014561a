"""A-posteriori errors against the truth that they do without."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sl

from vanelock import fem, rom
from vanelock.common.errors import InputError
from vanelock.rom.joining.vane_and_casing import joined_dofs

STEEL = fem.Material(E=200e9, nu=0.3, rho=7800.0)
N = 8
HOOK = rom.Joint("hook", kn=2e8, kt=1e8, mu=0.3, interference=1e-6)
LOCK = rom.Joint("interlock", kn=1e7, kt=1e7, mu=0.3, interference=1e-6)


@pytest.fixture(scope="module")
def small_ring(lattice):
    """Two models of a small ring: a block that hangs in a clamped rim, with all node sets."""

    def wedge(radii, turned=0.1):
        def place(p):
            r = radii[0] + (radii[1] - radii[0]) * p[:, 0]
            angle = 2 * np.pi / N * (p[:, 1] - 0.5) + turned * np.sin(3 * p[:, 2])
            return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.2 * p[:, 2]])

        return lattice((1, 3, 2), place, "tetra10", curved=True, sectors=N)

    block, rim = wedge((0.42, 0.5)), wedge((0.5, 0.56))
    inner = np.setdiff1d(
        block.node_sets["x1"],
        np.concatenate([block.node_sets[name] for name in ("y0", "y1")]),
    )
    pairs = [(a, b) for a in inner for b in mates(block, rim, a)]
    own, mate = np.array(pairs).T
    clamped = np.concatenate([rim.node_sets["z0"], rim.node_sets["z1"]])
    inside = ~np.isin(mate, clamped)
    own, mate = own[inside], mate[inside]
    key, front, rear = slice(0, 3), slice(3, 6), slice(6, None)
    lock = [
        np.setdiff1d(block.node_sets[name], block.node_sets["x1"])[::3] for name in ("y0", "y1")
    ]
    frames = {
        "hook_front": np.tile(np.eye(3), (len(own[front]), 1, 1)),
        "hook_rear": np.tile(np.eye(3), (len(own[rear]), 1, 1)),
        "interlock_right": np.tile(np.eye(3)[[1, 0, 2]], (len(lock[1]), 1, 1)),
    }
    sets = {"key": own[key], "hook_front": own[front], "hook_rear": own[rear]}
    vane = replace(
        block,
        name="block",
        frames=frames,
        node_sets=sets
        | {"interlock_left": lock[0], "interlock_right": lock[1], "output": lock[0][:1]},
    )
    sets = {"key": mate[key], "hook_front": mate[front], "hook_rear": mate[rear]}
    outside = np.setdiff1d(
        rim.node_sets["x1"],
        np.concatenate([clamped, rim.node_sets["y0"], rim.node_sets["y1"]]),
    )
    casing = replace(
        rim,
        name="rim",
        node_sets=sets
        | {
            "left": rim.node_sets["y0"],
            "right": rim.node_sets["y1"],
            "z": clamped,
            "force": outside[:2],
            "output": outside[-1:],
        },
    )
    return fem.assemble(vane, STEEL, fixed=None), fem.assemble(casing, STEEL, fixed="z")


def mates(block, rim, node):
    return np.flatnonzero(np.linalg.norm(rim.points - block.points[node], axis=1) < 1e-12)


VANE = ("key", "hook_front", "hook_rear", "interlock_left", "interlock_right", "output")
CASING = ("key", "hook_front", "hook_rear", "force", "output")
DIAMETERS = (0, 1, 3, 4)


def reduced(small_ring, *, joints=(HOOK, LOCK), ratio=None, engine_order=1, **options):
    vane = rom.reduce(small_ring[0], VANE, **options)
    casing = rom.reduce(small_ring[1], CASING, nodal_diameters=DIAMETERS, **options)
    excitation = rom.Excitation(engine_order, force=10.0)
    return rom.join(vane, casing, joints, excitation, ratio), vane, casing


def truth(small_ring, k, joints=(HOOK, LOCK)):
    K, M = (A.toarray() for A in rom.unreduced(*small_ring, joints, k))
    return np.sqrt(sl.eigvalsh(K, M)) / (2 * np.pi)


@pytest.mark.parametrize("k", DIAMETERS)
@pytest.mark.parametrize("modes", [4, 8, 16, 40])
@pytest.mark.parametrize("stuck", [True, False], ids=["stuck", "free"])
def test_frequency_errors_against_the_sector(small_ring, k, modes, stuck):
    system, vane, casing = reduced(small_ring, modes=modes)
    closed = None if stuck else np.array([name == "hook" for name in system.contacts.joint])
    errors = rom.frequency_errors(system, vane, casing, k, 10, closed)
    exact = truth(small_ring, k, (HOOK, LOCK) if stuck else (HOOK,))[:10]
    found = errors.frequency / exact - 1
    assert np.all(found > -1e-9)
    np.testing.assert_allclose(errors.total, errors.vane + errors.casing)
    complete = min(vane.at(k).complete, casing.at(k).complete)
    compared = np.isfinite(errors.total) & (errors.frequency < 0.7 * complete) & (found > 1e-10)
    ratio = errors.total[compared] / found[compared]
    assert np.all(ratio > 0.95)
    assert np.all(ratio < 2)
    if modes >= 16:
        assert compared.sum() >= 5
    # Beyond the modes that a part keeps in full nothing is promised.
    assert np.all(np.isinf(errors.total[errors.frequency > complete]))


@pytest.mark.parametrize("accuracy", [1e-2, 1e-4, 1e-6])
def test_errors_of_an_accuracy_are_within_it(small_ring, accuracy):
    system, vane, casing = reduced(small_ring, accuracy=accuracy, band=6000.0)
    for k in DIAMETERS:
        exact = truth(small_ring, k)
        count = int(np.sum(exact < 6000.0))
        assert count >= 3
        errors = rom.frequency_errors(system, vane, casing, k, count)
        found = errors.frequency / exact[:count] - 1
        assert np.all(found < accuracy)
        assert np.all(errors.total < 2 * accuracy)  # each part brings its own
        seen = found > 1e-10
        assert np.all(errors.total[seen] > 0.95 * found[seen])
        assert np.all(errors.total[seen] < 2 * found[seen])


def beams(bar, modes, spring=0.0, seed=0):
    """Two equal bars, each reduced in its own way, and the dense truth."""
    model = bar(masters=5, seed=seed)
    part = model.part
    held = part.node_sets["held"]
    none = np.empty(0, np.int64)
    sets = {"held": held, "key": none, "hook_front": held[:4], "hook_rear": none}
    sets |= {"force": held[:1]}
    frames = {"hook_front": np.tile(np.eye(3), (4, 1, 1)), "hook_rear": np.empty((0, 3, 3))}
    model = replace(model, part=replace(part, node_sets=sets, frames=frames))
    names = ("held", "key", "hook_front", "hook_rear", "force")
    first, second = (rom.reduce(model, names, count) for count in modes)
    joints = (rom.Joint("hook", spring, spring, 0.3, 0.0),) if spring else ()
    system = rom.join(first, second, joints, rom.Excitation(0, force=1.0))
    rows = model.dofs[held[:4]].ravel()
    K, M = (sl.block_diag(A.toarray(), A.toarray()) for A in (model.K, model.M))
    n = model.K.shape[0]
    for row in rows:
        K[np.ix_([row, n + row], [row, n + row])] += spring * np.array([[1, -1], [-1, 1]])
    return system, first, second, K, M


@pytest.mark.parametrize("modes", [(12, 12), (12, 18), (30, 14)])
@pytest.mark.parametrize("spring", [0.0, 1e2, 1e5, 1e8])
def test_free_bodies_with_repeated_and_close_modes(bar, exact, modes, spring):
    """Zero frequencies have no error; equal and nearly equal ones have theirs, in order."""
    system, first, second, K, M = beams(bar, modes, spring)
    errors = rom.frequency_errors(system, first, second, 0, 20)
    expected = exact.frequencies(K, M, 20)
    rigid = errors.frequency < 1.0
    assert rigid.sum() == (12 if spring == 0 else np.sum(expected < 1.0))
    assert np.all(errors.total[rigid] < 1e-6)
    found = errors.frequency[~rigid] / expected[~rigid] - 1
    estimate = errors.total[~rigid]
    complete = min(first.at(0).complete, second.at(0).complete)
    # Far below the highest frequency the dense solution is no better than this.
    known = (found > 1e-8) & (errors.frequency[~rigid] > 20.0)
    seen = known & (errors.frequency[~rigid] < 0.7 * complete)
    assert seen.sum() >= 3
    assert np.all(estimate[seen] > 0.95 * found[seen])
    assert np.all(estimate[seen] < 2 * found[seen])


def test_infinite_where_modes_are_left_out_below(bar):
    system, first, second, _, _ = beams(bar, (0, 2))
    errors = rom.frequency_errors(system, first, second, 0, 16)
    elastic = errors.frequency > 1.0
    assert elastic.sum() == 4
    assert np.all(np.isinf(errors.vane[elastic]))
    assert np.all(errors.casing[elastic][errors.frequency[elastic] > second.at(0).complete] > 1)
    assert not np.any(np.isnan(errors.total))


def test_nothing_is_left_out_of_a_whole_part(lattice, exact):
    """All fixed-interface modes: no error to estimate, and none there."""
    part = lattice((1, 1, 1), lambda p: p * 0.1)
    none = np.empty(0, np.int64)
    held = part.node_sets["x0"]
    part = replace(part, node_sets={"held": held, "key": none, "force": held[:1]})
    model = fem.assemble(part, STEEL, fixed=None)
    whole = rom.reduce(model, ("held", "key", "force"), cutoff=1e9)
    assert whole.at(0).complete == np.inf
    system = rom.join(whole, whole, (), rom.Excitation(0, force=1.0))
    errors = rom.frequency_errors(system, whole, whole, 0, 20)
    expected = np.repeat(exact.frequencies(model.K.toarray(), model.M.toarray(), 10), 2)
    np.testing.assert_allclose(errors.frequency[12:], expected[12:20], rtol=1e-8)
    assert np.all(errors.total < 1e-6)
    assert np.all(errors.total[12:] < 1e-9)


@pytest.mark.parametrize("modes", [6, 12, 24])
@pytest.mark.parametrize("stuck", [True, False], ids=["stuck", "free"])
def test_response_errors_against_the_sector(small_ring, exact, modes, stuck):
    """Output and estimate against a dense solution of the sector with the model's damping."""
    ratio = 0.01
    system, vane, casing = reduced(small_ring, modes=modes, ratio=ratio)
    joints = (HOOK, LOCK)
    K_all, M = (A.toarray() for A in rom.unreduced(*small_ring, joints, 1))
    K = K_all if stuck else rom.unreduced(*small_ring, joints[:1], 1)[0].toarray()
    closed = None if stuck else np.array([name == "hook" for name in system.contacts.joint])
    resonance = truth(small_ring, 1)[:4]
    frequencies = np.sort(np.concatenate([resonance[:3], 0.5 * (resonance[1:] + resonance[:-1])]))
    output, error = rom.response_errors(system, vane, casing, frequencies, closed)
    # Nodes of loads and outputs in the sector's coordinates.
    casing_model, n = small_ring[1], K.shape[0]
    T = exact.transform(casing_model, 1).tocsr()
    vane_model = small_ring[0]
    keys = vane_model.dofs[vane_model.part.node_sets["key"]].ravel()
    rest = np.setdiff1d(np.arange(vane_model.K.shape[0]), keys)
    load = np.zeros(n, complex)
    rows = []
    points = casing_model.part.points

    def place(model, node):
        dofs = model.dofs[node]
        if model is casing_model:
            return T.indices[T.indptr[dofs]]
        return T.shape[1] + np.searchsorted(rest, dofs)

    for node in casing_model.part.node_sets["force"]:
        angle = np.arctan2(points[node, 1], points[node, 0])
        radial = np.array([np.cos(angle), np.sin(angle), 0])
        load[place(casing_model, node)] = 10.0 * radial * np.exp(-1j * angle)
    for model in small_ring:
        for node in model.part.node_sets["output"]:
            x, y, _ = model.part.points[node] / np.hypot(*model.part.points[node][:2])
            turn = np.array([[x, y, 0], [-y, x, 0], [0, 0, 1]])
            row = np.zeros((3, n))
            row[:, place(model, node)] = turn
            rows.append(row)
    squared, V = sl.eigh(K_all, M)
    MV = M @ V
    C = (MV * (2 * ratio * np.sqrt(squared))) @ MV.conj().T
    whole = []
    for omega in 2 * np.pi * frequencies:
        x = np.linalg.solve(K - omega**2 * M + 1j * omega * C, load)
        whole.append([row @ x for row in rows])
    missing = np.array(whole) - output
    size = np.abs(whole).max(axis=2)
    true = np.abs(missing).max(axis=2) / size
    estimated = np.abs(error).max(axis=2) / size
    seen = true > 1e-7
    assert seen.any()
    assert np.all(estimated[seen] > 0.75 * true[seen])
    assert np.all(estimated[seen] < 1.5 * true[seen])
    # The estimate has a direction and a phase: with it the output is closer to the truth.
    left = np.abs(missing - error).max(axis=2) / size
    assert np.all(left[seen] < 0.7 * true[seen])


def test_errors_that_no_route_estimates_are_refused(small_ring):
    model = small_ring[1]
    vane = rom.reduce(small_ring[0], VANE, 4)
    for route in ("direct", "paper"):
        casing = rom.reduce(model, CASING, 4, nodal_diameters=[1], route=route, interface_modes=5)
        system = rom.join(vane, casing, (HOOK,), rom.Excitation(1, force=1.0))
        with pytest.raises(InputError, match=f'rim: reduced by the route "{route}", which gives'):
            rom.frequency_errors(system, vane, casing, 1, 3)
        with pytest.raises(InputError, match=f'rim: reduced by the route "{route}", which gives'):
            rom.response_errors(system, vane, casing, np.array([100.0]))


def test_more_modes_than_there_are_are_refused(small_ring):
    system, vane, casing = reduced(small_ring, modes=2)
    n = len(system.at(0).K)
    assert len(rom.frequency_errors(system, vane, casing, 0, n).total) == n
    for count in (0, -1, n + 1):
        with pytest.raises(InputError, match=f"{count} modes of a system of {n} coordinates"):
            rom.frequency_errors(system, vane, casing, 0, count)


def test_conjugate_diameter_has_the_same_errors(small_ring):
    system, vane, casing = reduced(small_ring, modes=8)
    a, b = (rom.frequency_errors(system, vane, casing, k, 6).total for k in (3, N - 3))
    np.testing.assert_allclose(a, b, rtol=1e-6)


def test_key_coordinates_are_shared(small_ring):
    _, vane, casing = reduced(small_ring, modes=2)
    shared = joined_dofs(vane, casing)
    assert np.sum(shared < casing.size) == 9
