"""A-posteriori errors against the truth that they do without."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as sl

from benchmarks.unreduced import unreduced_segment as unreduced
from tests.rom.block_in_rim import BLOCK, HOOK, LOCK, RIM
from tests.verification.rom.test_reduction import load_and_outputs
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


@pytest.mark.parametrize(("modes", "stuck"), [(6, False), (12, True), (24, False)])
def test_response_errors_against_the_sector(small_ring, reduced, modes, stuck):
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
    vane, casing = small_ring
    load, rows = load_and_outputs(SimpleNamespace(vane=vane, casing=casing))
    squared, V = sl.eigh(K_all, M)
    MV = M @ V
    C = (MV * (2 * ratio * np.sqrt(squared))) @ MV.conj().T
    whole = []
    for omega in 2 * np.pi * frequencies:
        x = np.linalg.solve(K - omega**2 * M + 1j * omega * C, 10.0 * load)
        whole.append((rows @ x).reshape(-1, 3))
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
