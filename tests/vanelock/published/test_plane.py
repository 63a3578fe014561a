"""Planes of peaks: each cell is the response that it says, in one process or in several."""

from dataclasses import replace

import numpy as np
import pytest

from vanelock.nonlinear import Options, frequency_response
from vanelock.pipeline.journal import journal
from vanelock.published.maps.maps import thinned
from vanelock.published.maps.plane import Method, PlaneTask, plane

METHODS = (Method(1), Method(1, "constant-load"), Method(3))
RANGE = (100.0, 190.0)


@pytest.fixture
def task(sector):
    return PlaneTask(sector, "interference", (0.1, 0.4), (1e-6, 3e-6), METHODS, RANGE, (0, 2))


def alone(system, mu, v0, factor, method):
    contacts = replace(system.contacts, mu=np.array([0.3, mu]), v0=np.array([4e-4, v0]))
    force = {1: replace(system.force[1], vector=factor * system.force[1].vector)}
    changed = replace(system, contacts=contacts, force=force)
    found = frequency_response(changed, RANGE, Options(method.harmonics, coupling=method.coupling))
    assert found.converged.all()
    amplitude = found.amplitude[:, 0, 2]
    return amplitude.max(), found.frequency[amplitude.argmax()]


def test_cells_are_responses_of_the_changed_system(task):
    found = plane(task)
    for i, mu in enumerate(task.mu):
        for j, v0 in enumerate(task.value):
            for k, method in enumerate(METHODS):
                expected = alone(task.system, mu, v0, 1.0, method)
                got = found.amplitude[i, j, k], found.frequency[i, j, k]
                assert got == pytest.approx(expected, rel=1e-9)
    assert not found.lost.any()
    assert np.ptp(found.amplitude) > 0.05 * found.amplitude.max()


def test_load_scales_the_excitation(task):
    found = plane(replace(task, other="load", value=(0.5, 2.0)))
    v0 = task.system.contacts.v0[1]
    expected = alone(task.system, 0.4, v0, 2.0, METHODS[2])
    assert (found.amplitude[1, 1, 2], found.frequency[1, 1, 2]) == pytest.approx(expected, rel=1e-9)


def test_several_processes_find_the_same(task):
    wide = replace(task, mu=(0.1, 0.2, 0.3, 0.4), methods=METHODS[:1])
    one = plane(wide)
    heard = []
    two = plane(wide, lambda *told: heard.append(told), workers=2)
    np.testing.assert_array_equal(one.amplitude, two.amplitude)
    np.testing.assert_array_equal(one.frequency, two.frequency)
    assert [told[:2] for told in heard] == [(i + 1, 8) for i in range(8)]


@pytest.mark.parametrize("workers", [1, 2])
def test_points_that_were_solved_before_a_kill_are_not_solved_again(task, tmp_path, workers):
    wide = replace(task, mu=(0.1, 0.2, 0.3, 0.4, 0.5), methods=METHODS[:1])
    expected, path = plane(wide), tmp_path / "map.journal"

    def killed(done, total, peak):
        if done == 3:
            raise KeyboardInterrupt

    with journal(path) as opened, pytest.raises(KeyboardInterrupt):
        plane(wide, killed, opened, workers)
    path.write_bytes(path.read_bytes()[:-5])  # in the middle of writing the third
    heard = []
    with journal(path) as opened:
        found = plane(wide, lambda *told: heard.append(told[0]), opened, workers)
    assert heard == list(range(3, 11))
    for name in ("amplitude", "frequency", "opening", "slipping", "lost", "points"):
        assert getattr(found, name).tobytes() == getattr(expected, name).tobytes()


def test_a_peak_beside_a_lost_point_is_not_known(task, monkeypatch):
    def lost(*arguments, **options):
        found = frequency_response(*arguments, **options)
        top = int(found.amplitude[:, 0, 2].argmax())
        known = np.ones(found.points, bool)
        known[top] = False
        return replace(found, converged=known)

    monkeypatch.setattr("vanelock.nonlinear.frequency_response", lost)
    found = plane(replace(task, mu=(0.1,), value=(1e-6,)))
    assert np.isnan(found.amplitude).all()
    assert (found.lost == 1).all()


def test_thinned_keeps_both_ends():
    assert thinned((1, 2, 3, 4, 5, 6), 2) == (1, 3, 4, 6)
    assert thinned((1, 2, 3), 1) == (1, 2, 3)
    assert thinned((1, 2), 2) == (1, 2)
