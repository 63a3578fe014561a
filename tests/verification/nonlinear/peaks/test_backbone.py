"""Peaks followed along force and friction, and hysteresis, on the vane."""

from time import process_time

import numpy as np
import pytest

from tests.conftest import FULL
from tests.nonlinear.systems import solved_response
from tests.verification.nonlinear.spring_rings import loaded
from tests.verification.vane import second_mode
from vanelock.nonlinear import (
    STUCK,
    Options,
    hysteresis,
    linear_response,
    peak_response,
)

ORDERS = (1, 3) if FULL else (1,)
COUNT = 31 if FULL else 12


def near(system):
    free, stuck, _ = second_mode(system)
    return float(free - 10), float(stuck + 10)


@pytest.mark.parametrize("harmonics", ORDERS)
def test_peaks_against_force_are_those_of_sweeps(scene, harmonics, record, below):
    values = np.geomspace(1e-3, 3.0, COUNT)
    begun = process_time()
    found = peak_response(scene.system, "force", values, near(scene.system), Options(harmonics))
    record("CPU", f"{process_time() - begun:.1f} s")
    record("frequencies", f"{found.readings.sum()}")
    assert found.converged.all()
    smooth = ~found.sharp
    assert smooth.mean() > 0.9
    assert found.distance[smooth].max() < 1e-8
    record("extremum", f"{found.distance[smooth].max():.1e}")
    # A small force leaves all stuck: the linear peak.
    band = found.frequency[0] * (1 + np.linspace(-1e-5, 1e-5, 5))
    stuck = linear_response(scene.system, band, "all", harmonics)
    node = scene.system.output_names.index(found.output)
    curve = stuck.amplitude[:, node, found.direction]
    assert found.states[0, STUCK] == scene.system.contacts.count
    assert curve.argmax() == 2
    np.testing.assert_allclose(found.amplitude[0], values[0] * curve[2], rtol=1e-9)
    # Peaks by themselves: ever finer sweeps of the same system at the same force.
    worst_frequency = worst_amplitude = 0.0
    for i in np.flatnonzero(smooth)[COUNT // 4 :: COUNT // 4]:
        system = loaded(scene.system, values[i])
        width = 0.3 * found.width[i]
        centre = found.frequency[i] + 0.2 * width  # so that nothing leads to the peak but size
        for _ in range(7):
            hertz = centre + width * np.linspace(-1, 1, 9)
            swept = solved_response(system, hertz, Options(harmonics))
            size = swept.amplitude[:, node, found.direction]
            centre, width = hertz[size.argmax()], width / 4
        worst_frequency = max(worst_frequency, abs(centre / found.frequency[i] - 1))
        worst_amplitude = max(worst_amplitude, abs(size.max() / found.amplitude[i] - 1))
    below("frequency's difference", worst_frequency, 1e-6)
    below("amplitude's difference", worst_amplitude, 1e-8)


@pytest.mark.parametrize("harmonics", ORDERS)
def test_some_friction_damps_most(scene, harmonics, record):
    values = np.geomspace(0.01, 10, COUNT)
    begun = process_time()
    found = peak_response(
        scene.system, "mu", values, near(scene.system), Options(harmonics), joint="interlock"
    )
    record("CPU", f"{process_time() - begun:.1f} s")
    record("converged", f"{found.converged.sum()} of {len(values)}")
    assert found.converged.mean() > 0.95
    best = int(np.argmin(found.amplitude))
    record("best mu", f"{values[best]:.2f}")
    record("best / least mu", f"{found.amplitude[best] / found.amplitude[0]:.3f}")
    record("best / largest mu", f"{found.amplitude[best] / found.amplitude[-1]:.3f}")
    assert 0.1 < values[best] < 5
    assert found.amplitude[best] < 0.5 * found.amplitude[0]
    assert found.amplitude[best] < 0.95 * found.amplitude[-1]


def test_sweeps_both_ways_and_the_path_agree(scene, record):
    free, stuck, _ = second_mode(scene.system)
    hertz = np.linspace(free - 3, stuck + 3, 41)
    begun = process_time()
    found = hysteresis(scene.system, hertz, Options(3 if FULL else 1))
    record("CPU", f"{process_time() - begun:.1f} s")
    assert found.complete
    assert found.connected
    for each in (found.up, found.down, found.branch):
        assert each.converged.all()
    record("folds", f"{len(found.fold)}")
    record("points of the path", f"{found.branch.points}")
    inside = np.zeros(found.up.points, bool)
    for low, high in found.several:
        inside |= (found.up.frequency >= low) & (found.up.frequency <= high)
    assert not np.any(found.differ & ~inside)
    # With an even number of folds passed the determinant has the sign that it began with.
    between = np.setdiff1d(np.arange(found.branch.points), found.fold)
    np.testing.assert_array_equal(found.unstable[between], found.passed[between] % 2 == 1)
