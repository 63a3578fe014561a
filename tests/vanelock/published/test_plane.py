"""Planes of peaks: each cell is the response that it says, in one process or in several."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vanelock import parse_study
from vanelock.input.cases.sweep import Case
from vanelock.nonlinear import Options, System, frequency_response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor.background import in_background
from vanelock.pipeline.executor.processes import Processes
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages, step
from vanelock.published.maps.maps import Maps, PeakMap, thinned
from vanelock.published.maps.plane import Method
from vanelock.stages.response.limits import Limits, limits
from vanelock.stages.sweep.graph import CaseWork, bundle

METHODS = (Method(1), Method(1, "constant-load"), Method(3))
RANGE = (100.0, 190.0)
MU, V0 = (0.1, 0.4), (1e-6, 3e-6)
STUDY = """
[response]
range = [100, 190]
[campaign]
map_mu = {mu}
map_interference = {v0}
map_load = [0.5, 2]
"""


@dataclass(frozen=True)
class Sector(CaseWork):
    """A case whose system is a sector of masses and springs."""

    system: System | None = None

    def planned(self):
        """Its system and limits."""
        given: Any = {"kept": False, "quick": True}
        own = step("system", "nonlinear", {}, System, (), lambda: self.system, **given)
        modes = step("limits", "nonlinear", {}, Limits, (own,), lambda s: limits(s, 2), **given)
        return SimpleNamespace(system=own, linear=SimpleNamespace(limits=modes), case=self.case)


def map_of(system, mu, methods):
    study = parse_study(STUDY.format(mu=list(mu), v0=list(V0)))
    scene = Sector(Case("sector", {}, study), (), system=system)
    return PeakMap("sector", scene, "interference", methods, (0, 2))


@pytest.fixture
def small(sector):
    """A map of two by two points."""
    return map_of(sector, MU, METHODS)


@pytest.fixture
def wide(sector):
    """A map of five by two points."""
    return map_of(sector, (0.1, 0.2, 0.3, 0.4, 0.5), METHODS[:1])


def solved(peak_map, folder, progress=lambda *progress: None):
    """The plane, and how many of its points were computed."""
    stages = Stages(Cache(folder, print), silent)
    found = stages.get(peak_map.plane(progress))
    return found, sum(not stages.done[point.key].cached for point in peak_map.steps())


def alone(system, mu, v0, factor, method):
    contacts = replace(system.contacts, mu=np.array([0.3, mu]), v0=np.array([4e-4, v0]))
    force = {1: replace(system.force[1], vector=factor * system.force[1].vector)}
    changed = replace(system, contacts=contacts, force=force)
    found = frequency_response(changed, RANGE, Options(method.harmonics, coupling=method.coupling))
    assert found.converged.all()
    amplitude = found.amplitude[:, 0, 2]
    return amplitude.max(), found.frequency[amplitude.argmax()]


def test_cells_are_responses_of_the_changed_system(small, tmp_path):
    found, _ = solved(small, tmp_path)
    for i, j in ((0, 1), (1, 0)):
        for k, method in enumerate(METHODS):
            expected = alone(small.scene.system, MU[i], V0[j], 1.0, method)
            got = found.amplitude[i, j, k], found.frequency[i, j, k]
            assert got == pytest.approx(expected, rel=1e-9)
    assert not found.lost.any()
    assert np.ptp(found.amplitude) > 0.05 * found.amplitude.max()


def test_load_scales_the_excitation(small, tmp_path):
    found, _ = solved(replace(small, other="load"), tmp_path)
    system = small.scene.system
    expected = alone(system, 0.4, system.contacts.v0[1], 2.0, METHODS[2])
    assert (found.amplitude[1, 1, 2], found.frequency[1, 1, 2]) == pytest.approx(expected, rel=1e-9)


def same(one, two):
    """Whether two planes agree to the bit, but for times."""
    for name in ("amplitude", "frequency", "opening", "slipping", "lost", "points"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()


@pytest.mark.system
def test_several_processes_find_the_same(wide, tmp_path):
    one, _ = solved(wide, tmp_path / "one")
    cache, heard, made = Cache(tmp_path / "two", print), [], []
    stages = Stages(cache, silent)

    def executor():
        made.append(Processes(2))
        return made[0]

    def divide():
        return bundle(Maps({"": wide}, {}, ()).jobs(cache), cache)

    more = stages, cache, silent, lambda: 0.0, lambda: None
    with in_background(executor, divide, *more):
        two = stages.get(wide.plane(lambda *each: heard.append(each)))
    assert made
    assert not any(stages.done[point.key].seconds == 0 for point in wide.steps())
    same(one, two)
    assert [each[:2] for each in heard] == [(i + 1, 10) for i in range(10)]
    assert not Maps({"": wide}, {}, ()).jobs(cache)


def test_points_that_were_solved_before_a_kill_are_not_solved_again(wide, tmp_path):
    expected, computed = solved(wide, tmp_path / "whole")
    assert computed == 10

    def killed(done, total, peak):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solved(wide, tmp_path / "killed", killed)
    third = wide.steps()[2].key
    (path,) = (tmp_path / "killed").rglob(f"*{third}*")
    path.write_bytes(path.read_bytes()[:-5])  # in the middle of writing the third
    found, computed = solved(wide, tmp_path / "killed")
    assert computed == 8
    same(found, expected)


def test_a_peak_beside_a_lost_point_is_not_known(small, tmp_path, monkeypatch):
    def lost(*arguments, **options):
        found = frequency_response(*arguments, **options)
        top = int(found.amplitude[:, 0, 2].argmax())
        known = np.ones(found.points, bool)
        known[top] = False
        return replace(found, converged=known)

    monkeypatch.setattr("vanelock.nonlinear.frequency_response", lost)
    found, _ = solved(replace(small, chosen=METHODS[:1]), tmp_path)
    assert np.isnan(found.amplitude).all()
    assert (found.lost == 1).all()


def test_thinned_keeps_both_ends():
    assert thinned((1, 2, 3, 4, 5, 6), 2) == (1, 3, 4, 6)
    assert thinned((1, 2, 3), 1) == (1, 2, 3)
    assert thinned((1, 2), 2) == (1, 2)
