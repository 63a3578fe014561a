"""Estimated errors against the errors made, source by source."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import sliding_system
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    SOURCES,
    Options,
    Shares,
    adaptive_response,
    frequency_response,
    peak_errors,
)
from vanelock.rom.errors import Neglected

HERTZ = np.linspace(0.165, 0.195, 13)
LOOSE = Shares(0.5, 0.5)


def _amplitude(response):
    return np.asarray(response.amplitude[:, 0, 0])


def _estimated(response, source):
    assert response.estimates is not None
    assert response.converged.all()
    np.testing.assert_allclose(response.estimates.amplitude, _amplitude(response), rtol=1e-9)
    return np.asarray(response.estimates.change[:, SOURCES.index(source)])


@pytest.mark.parametrize("preload", [1.0, 0.3])
def test_neglected_harmonics(preload):
    system = sliding_system(preload=preload)
    best = _amplitude(frequency_response(system, HERTZ, Options(19), find_jumps=False))
    greatest = []
    for H in (1, 3, 5):
        found = adaptive_response(lambda _: system, HERTZ, LOOSE, Options(H), monitor=(0, 0))
        estimated, made = _estimated(found, "harmonics"), best - _amplitude(found)
        greatest.append(np.abs(made).max())
        np.testing.assert_allclose(estimated, made, atol=0.5 * np.abs(made).max())
        # The highest point's is measured, and what is beyond allowed for.
        top = int(np.argmax(_amplitude(found)))
        assert 0.6 < estimated[top] / made[top] < 2.0
    assert greatest[0] > 5 * greatest[2]


def _softened(system, share):
    """The system without a share of one spring at every diameter, and a record of that."""
    missing = share * np.array([[1.0, -0.5], [-0.5, 1.5]])
    none = np.zeros_like(missing)
    diameters = {k: replace(d, K=d.K - missing) for k, d in system.diameters.items()}
    form = np.stack([missing, none, none])
    return replace(system, diameters=diameters), lambda _: Neglected(
        ((np.arange(2), form, np.inf),)
    )


def test_neglected_compliance():
    system = sliding_system()
    softer, neglected = _softened(system, 1e-4)
    found = adaptive_response(
        lambda _: system, HERTZ, LOOSE, Options(9), monitor=(0, 0), neglected=neglected
    )
    estimated = _estimated(found, "modes")
    made = _amplitude(frequency_response(softer, HERTZ, Options(9), find_jumps=False)) - _amplitude(
        found
    )
    assert np.abs(made / _amplitude(found)).max() > 1e-4
    np.testing.assert_allclose(estimated, made, atol=0.05 * np.abs(made).max())


def test_mesh_that_is_too_stiff():
    # Without slip or interference every natural frequency falls by a share if masses grow by two.
    system = sliding_system(mu=100.0)
    share = 1e-5
    asked = []

    def mesh_error(diameter, hertz):
        asked.append((diameter, len(hertz)))
        return np.full(len(hertz), share)

    found = adaptive_response(
        lambda _: system, HERTZ, LOOSE, Options(1), monitor=(0, 0), mesh_error=mesh_error
    )
    heavier = {k: replace(d, M=d.M * (1 + 2 * share)) for k, d in system.diameters.items()}
    best = _amplitude(
        frequency_response(replace(system, diameters=heavier), HERTZ, Options(1), find_jumps=False)
    )
    estimated, made = _estimated(found, "mesh"), best - _amplitude(found)
    near = np.abs(made) > 0.5 * np.abs(made).max()  # where inertia and stiffness are alike
    np.testing.assert_allclose(estimated[near], made[near], rtol=0.2)
    assert set(asked) == {(1, 2)}


def test_samples():
    system, options = sliding_system(preload=0.3), Options(3, samples=128)
    found = adaptive_response(lambda _: system, HERTZ, LOOSE, options, monitor=(0, 0))
    best = _amplitude(frequency_response(system, HERTZ, Options(3), find_jumps=False))
    estimated, made = _estimated(found, "samples"), best - _amplitude(found)
    assert np.abs(made / best).max() > 1e-6
    assert 0.8 < np.abs(estimated).max() / np.abs(made).max() < 1.25


def test_errors_of_a_peak():
    system = sliding_system()
    exact = adaptive_response(lambda _: system, (0.165, 0.195), Shares(1e-5, 1e-5), monitor=(0, 0))
    coarse = adaptive_response(
        lambda _: system, (0.165, 0.195), Shares(0.03, 0.03), Options(1), monitor=(0, 0)
    )
    best, estimated = peak_errors(exact), peak_errors(coarse)
    assert best.total < 1e-4
    made = abs(estimated.amplitude / best.amplitude - 1)
    assert 0.3 < estimated.total / made < 10
    shifted = np.nansum(list(estimated.frequency_error.values()))
    assert abs(estimated.frequency / best.frequency - 1) < 3 * shifted
    assert estimated.sources == (*SOURCES, "frequencies")
    assert np.isnan(estimated.amplitude_error["mesh"])
    assert coarse.estimates is not None
    ends = coarse.at([0, 1, 2])
    assert np.isnan(peak_errors(ends).amplitude_error["frequencies"])
    plain = frequency_response(system, HERTZ[:3], Options(1), find_jumps=False)
    assert np.isnan(plain.error).all()
    with pytest.raises(InputError, match="peak_errors: the response has no error estimates"):
        peak_errors(plain)


def test_the_error_of_a_peak_takes_nothing_from_beyond_a_jump():
    """A straight branch of slope 2 /Hz that ends at 4.5 of a curve in hertz, and a parabola."""
    system = sliding_system()
    solved = adaptive_response(lambda _: system, np.linspace(0.17, 0.19, 9), Shares(0.1, 0.1))
    assert solved.estimates is not None
    f = np.arange(9.0)

    def drawn(amplitude, slope):
        estimates = replace(
            solved.estimates, amplitude=amplitude, slope=slope, change=np.zeros((9, len(SOURCES)))
        )
        return replace(solved, frequency=f, estimates=estimates, jump=np.array([[4, 5]]))

    hill, rising = 8 - (f - 3) ** 2, 2 * f
    top = drawn(np.where(f < 5, hill, 4.0), np.where(f < 5, -2 * (f - 3), 0.0))
    found = peak_errors(top)  # a parabola is interpolated exactly
    assert found.amplitude_error["frequencies"] == pytest.approx(0, abs=1e-12)
    end = drawn(np.where(f < 5, rising, 1.0), np.where(f < 5, 2.0, 0.0))
    found = peak_errors(end)  # the branch may go on for 1 Hz, and by 2 of 8
    assert found.amplitude == 8
    assert found.amplitude_error["frequencies"] == pytest.approx(2 / 8)
    assert found.frequency_error["frequencies"] == pytest.approx(1 / 4)
