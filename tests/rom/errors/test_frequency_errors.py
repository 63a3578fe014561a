"""A-posteriori errors against the truth that they do without."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.linalg as sl

from benchmarks.unreduced import unreduced_segment as unreduced
from tests.rom.block_in_rim import BLOCK, HOOK, LOCK, RIM
from vanelock import fem, rom
from vanelock.common.errors import InputError
from vanelock.stages.parts.segment import Joint, Segment

N = 8
STEEL = fem.Material(E=200e9, nu=0.3, rho=7800.0)
DIAMETERS = (0, 1, 3, 4)


@pytest.fixture(scope="module")
def reduced(small_ring):
    """Function that reduces the ring and joins it, once for the same options."""

    @cache
    def build(*, ratio=None, **options):
        vane = rom.reduce(small_ring[0], BLOCK, **options)
        casing = rom.reduce(small_ring[1], RIM, nodal_diameters=DIAMETERS, **options)
        segment = Segment((HOOK, LOCK), 1, 10.0, damping_ratio=ratio)
        return segment.join(vane, casing), {"block": vane, "rim": casing}

    return build


def truth(small_ring, k, joints=(HOOK, LOCK)):
    K, M = (A.toarray() for A in unreduced(*small_ring, joints, k))
    return np.sqrt(sl.eigvalsh(K, M, subset_by_index=[0, 39])) / (2 * np.pi)


@pytest.mark.parametrize("k", DIAMETERS)
@pytest.mark.parametrize("stuck", [True, False], ids=["stuck", "free"])
def test_frequency_errors_against_the_sector(small_ring, reduced, k, stuck):
    exact = truth(small_ring, k, (HOOK, LOCK) if stuck else (HOOK,))[:10]
    for modes in (4, 16, 40):
        system, parts = reduced(modes=modes)
        assert_errors(system, parts, exact, k, modes, stuck)


def assert_errors(system, parts, exact, k, modes, stuck):
    closed = None if stuck else np.array([name == "hook" for name in system.contacts.joint])
    errors = rom.frequency_errors(system, parts, k, 10, closed)
    found = errors.frequency / exact - 1
    assert np.all(found > -1e-9)
    np.testing.assert_allclose(errors.total, sum(errors.parts.values()))
    complete = min(each.at(k).complete for each in parts.values())
    compared = np.isfinite(errors.total) & (errors.frequency < 0.7 * complete) & (found > 1e-10)
    ratio = errors.total[compared] / found[compared]
    assert np.all(ratio > 0.95)
    assert np.all(ratio < 2)
    if modes >= 16:
        assert compared.sum() >= 5
    # Beyond the modes that a part keeps in full nothing is promised.
    assert np.all(np.isinf(errors.total[errors.frequency > complete]))


@pytest.mark.parametrize("accuracy", [1e-2, 1e-4, 1e-6])
def test_errors_of_an_accuracy_are_within_it(small_ring, reduced, accuracy):
    system, parts = reduced(accuracy=accuracy, band=6000.0)
    for k in DIAMETERS:
        exact = truth(small_ring, k)
        count = int(np.sum(exact < 6000.0))
        assert count >= 3
        errors = rom.frequency_errors(system, parts, k, count)
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
    first, second = (
        rom.reduce(replace(model, part=replace(model.part, name=name)), names, count)
        for name, count in zip(("first", "second"), modes, strict=True)
    )
    joints = (Joint("hook", spring, spring, 0.3, 0.0),) if spring else ()
    system = Segment(joints, 0, force=1.0).join(first, second)
    rows = model.dofs[held[:4]].ravel()
    K, M = (sl.block_diag(A.toarray(), A.toarray()) for A in (model.K, model.M))
    n = model.K.shape[0]
    for row in rows:
        K[np.ix_([row, n + row], [row, n + row])] += spring * np.array([[1, -1], [-1, 1]])
    return system, {"first": first, "second": second}, K, M


@pytest.mark.parametrize("modes", [(12, 12), (30, 14)])
@pytest.mark.parametrize("spring", [0.0, 1e2, 1e8])
def test_free_bodies_with_repeated_and_close_modes(bar, exact, modes, spring):
    """Zero frequencies have no error; equal and nearly equal ones have theirs, in order."""
    system, parts, K, M = beams(bar, modes, spring)
    errors = rom.frequency_errors(system, parts, 0, 20)
    expected = exact.frequencies(K, M, 20)
    rigid = errors.frequency < 1.0
    assert rigid.sum() == (12 if spring == 0 else np.sum(expected < 1.0))
    assert np.all(errors.total[rigid] < 1e-6)
    found = errors.frequency[~rigid] / expected[~rigid] - 1
    estimate = errors.total[~rigid]
    complete = min(each.at(0).complete for each in parts.values())
    # Far below the highest frequency the dense solution is no better than this.
    known = (found > 1e-8) & (errors.frequency[~rigid] > 20.0)
    seen = known & (errors.frequency[~rigid] < 0.7 * complete)
    assert seen.sum() >= 3
    assert np.all(estimate[seen] > 0.95 * found[seen])
    assert np.all(estimate[seen] < 2 * found[seen])


def test_infinite_where_modes_are_left_out_below(bar):
    system, parts, _, _ = beams(bar, (0, 2))
    errors = rom.frequency_errors(system, parts, 0, 16)
    elastic = errors.frequency > 1.0
    assert elastic.sum() == 4
    for name, found in errors.parts.items():
        beyond = elastic & (errors.frequency > parts[name].at(0).complete)
        assert beyond.any()
        assert np.all(np.isinf(found[beyond]))
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
    other = replace(whole, masters=replace(whole.masters, part="other"))
    system = Segment((), 0, force=1.0).join(whole, other)
    errors = rom.frequency_errors(system, {part.name: whole, "other": other}, 0, 20)
    expected = np.repeat(exact.frequencies(model.K.toarray(), model.M.toarray(), 10), 2)
    np.testing.assert_allclose(errors.frequency[12:], expected[12:20], rtol=1e-8)
    assert np.all(errors.total < 1e-6)
    assert np.all(errors.total[12:] < 1e-9)


@pytest.mark.parametrize(("modes", "stuck"), [(6, False), (12, True), (24, False)])
def test_response_errors_against_the_sector(small_ring, reduced, exact, modes, stuck):
    """Output and estimate against a dense solution of the sector with the model's damping."""
    ratio = 0.01
    system, parts = reduced(modes=modes, ratio=ratio)
    joints = (HOOK, LOCK)
    K_all, M = (A.toarray() for A in unreduced(*small_ring, joints, 1))
    K = K_all if stuck else unreduced(*small_ring, joints[:1], 1)[0].toarray()
    closed = None if stuck else np.array([name == "hook" for name in system.contacts.joint])
    resonance = truth(small_ring, 1)[:4]
    frequencies = np.sort(np.concatenate([resonance[:3], 0.5 * (resonance[1:] + resonance[:-1])]))
    output, error = rom.response_errors(system, parts, frequencies, closed)
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
    vane = rom.reduce(small_ring[0], BLOCK, 4)
    casing = rom.reduce(model, RIM, 4, nodal_diameters=[1], route="paper", interface_modes=5)
    system, parts = (
        Segment((HOOK,), 1, force=1.0).join(vane, casing),
        {"block": vane, "rim": casing},
    )
    with pytest.raises(InputError, match="rim: reduced by a route that gives no estimate"):
        rom.frequency_errors(system, parts, 1, 3)
    with pytest.raises(InputError, match="rim: reduced by a route that gives no estimate"):
        rom.response_errors(system, parts, np.array([100.0]))


def test_more_modes_than_there_are_are_refused(reduced):
    system, parts = reduced(modes=2)
    n = len(system.at(0).K)
    assert len(rom.frequency_errors(system, parts, 0, n).total) == n
    for count in (0, -1, n + 1):
        with pytest.raises(InputError, match=f"{count} modes of a system of {n} coordinates"):
            rom.frequency_errors(system, parts, 0, count)


def test_conjugate_diameter_has_the_same_errors(reduced):
    system, parts = reduced(modes=8)
    a, b = (rom.frequency_errors(system, parts, k, 6).total for k in (3, N - 3))
    np.testing.assert_allclose(a, b, rtol=1e-6)


def test_key_coordinates_are_shared(reduced):
    system, parts = reduced(modes=2)
    places = system.at(1).parts
    assert np.array_equal(places["rim"], np.arange(parts["rim"].size))
    assert np.isin(places["block"], places["rim"]).sum() == 9
