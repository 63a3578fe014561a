"""The error of a point by neglected harmonics against the same point with many of them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import sliding_system
from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock.common.errors import InputError
from vanelock.nonlinear import Options, frequency_response, neglected_harmonics


@pytest.mark.parametrize("coupling", ["coupled", "uncoupled"])
@pytest.mark.parametrize("harmonics", [1, 3])
def test_estimate_is_the_change_by_many_more(coupling, harmonics):
    system, hertz = sliding_system(preload=0.5), np.linspace(0.17, 0.19, 5)
    found, best = (
        frequency_response(system, hertz, Options(H, coupling), find_jumps=False)
        for H in (harmonics, 15)
    )
    own = [neglected_harmonics(system, found, point, (0, 0)) for point in range(5)]
    made = np.abs(best.amplitude[:, 0, 0] / found.amplitude[:, 0, 0] - 1)
    assert made.max() > 1e-5
    assert 0.5 < max(own) / made.max() < 2


def test_where_the_first_step_leads_astray_the_balance_is_solved():
    """Near a fold, where it would change the amplitude 169 times over."""
    system = loaded(spring_ring(4), 2 * worst_of(4)["slip"][1])
    few, more = (frequency_response(system, [0.18619], Options(H)) for H in (1, 3))
    made = abs(more.amplitude[0, 0, 0] / few.amplitude[0, 0, 0] - 1)
    assert neglected_harmonics(system, few, 0, (0, 0)) == pytest.approx(made, rel=1e-6)


def test_what_sticks_neglects_nothing_and_what_is_lost_is_not_judged():
    system = sliding_system(preload=50.0)
    found = frequency_response(system, [0.17], Options(3))
    assert neglected_harmonics(system, found, 0, (0, 0)) == pytest.approx(0.0, abs=1e-12)
    lost = replace(found, converged=np.zeros(1, bool))
    assert np.isnan(neglected_harmonics(system, lost, 0, (0, 0)))
    with pytest.raises(InputError, match="points: given 1: there are 1"):
        neglected_harmonics(system, found, 1, (0, 0))


def test_nodal_diameters_that_the_system_lacks_take_the_nearest():
    system = sliding_system(preload=0.5)
    fewer = replace(
        system, diameters={k: d for k, d in system.diameters.items() if k in (0, 1, 2, 3)}
    )
    found = frequency_response(fewer, [0.18], Options(3))
    all_own, nearest = (neglected_harmonics(each, found, 0, (0, 0)) for each in (system, fewer))
    assert nearest == pytest.approx(all_own, rel=0.5)
