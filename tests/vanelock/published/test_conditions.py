"""The three loops against closed forms and against the element marched by itself."""

import numpy as np
import pytest

from vanelock.published import conditions as module
from vanelock.published.conditions import NORMAL, SLIDING, conditions

KN, KT, MU, V0 = 1.3e6, 0.9e6, 0.35, 2e-6


def test_energies_agree_with_marching():
    for loop in conditions(KN, KT, MU, V0):
        assert loop.energy == pytest.approx(loop.marched, rel=1e-5)
        assert loop.energy > 0


def test_friction_stays_within_its_bounds_and_reaches_both():
    for loop in conditions(KN, KT, MU, V0):
        bound = MU * loop.force[:, 0]
        assert np.all(np.abs(loop.force[:, 1]) <= bound + 1e-9 * bound.max())
        on = np.isclose(np.abs(loop.force[:, 1]), bound, rtol=1e-9) & (bound > 0)
        assert {1.0, -1.0} <= set(np.sign(loop.force[on, 1]))


def test_only_the_second_lifts_off_and_for_as_long_as_the_motion_says():
    first, second, third = conditions(KN, KT, MU, V0)
    assert first.opened == third.opened == 0
    assert second.opened == pytest.approx(np.arccos(1 / NORMAL[1]) / np.pi, abs=1e-3)
    apart = second.displacement[:, 0] < 0
    assert not second.force[apart].any()


def test_with_a_steady_normal_force_the_loop_is_a_parallelogram(monkeypatch):
    # 4 mu n0 (U - mu n0 / kt) a cycle, the classical result for an elastic slider.
    monkeypatch.setattr(module, "NORMAL", (0.0, 0.0, 0.0))
    n0 = KN * V0
    U = SLIDING * MU * n0 / KT
    for loop in conditions(KN, KT, MU, V0):
        assert loop.energy == pytest.approx(4 * MU * n0 * (U - MU * n0 / KT), rel=2e-5)
