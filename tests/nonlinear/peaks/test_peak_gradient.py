"""Gradients of a peak against differences of peaks that are solved."""

from dataclasses import replace

import numpy as np
import pytest

from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    AmplitudeGradient,
    Options,
    frequency_response,
    peak_gradient,
    peak_gradient_of,
)
from vanelock.nonlinear.peaks.peak import Resonance
from vanelock.nonlinear.peaks.peak_gradient import _gradient_of_peak


def slipping(seed, kind="slip", **changes):
    """A ring under the load that friction damps most, and a range about its peak, Hz."""
    kinds = worst_of(seed)
    _, force, hertz = kinds.get(kind) or next(iter(kinds.values()))
    system = replace(loaded(spring_ring(seed), force), **changes)
    return system, (0.85 * hertz, 1.12 * hertz)


def test_no_peak_is_one_line():
    system, near = slipping(0)
    with pytest.raises(InputError, match=r"^near: no peak was found in it$"):
        peak_gradient(system, (2 * near[1], 2.02 * near[1]))
    with pytest.raises(InputError, match="needs at least 1"):
        peak_gradient(system, near, Options(0))


def test_a_peak_of_a_response_is_that_of_a_search():
    system, near = slipping(2)
    whole = peak_gradient(system, near, Options(3), frequency=True)
    hertz = np.linspace(near[0], near[1], 60)
    response = frequency_response(system, hertz, Options(3), find_jumps=False)
    at = system.output_names.index(whole.output[0]), whole.output[1]
    point = int(response.amplitude[:, *at].argmax())
    found = peak_gradient_of(system, response, point, whole.output, 0.02)
    assert found.amplitude == pytest.approx(whole.amplitude, rel=1e-10)
    assert found.frequency == pytest.approx(whole.frequency, rel=1e-8)
    for by in (AmplitudeGradient.by_force, AmplitudeGradient.by_damping):
        assert by(found.at_peak) == pytest.approx(by(whole.at_peak), rel=1e-6)
        assert found.of_frequency(by) == pytest.approx(whole.of_frequency(by), rel=1e-3)
    with pytest.raises(InputError, match=r"^point: given 0: no peak was found there$"):
        peak_gradient_of(system, response, 0, whole.output, 1e-5)


def test_where_no_frequency_is_followed_the_reason_is_said(monkeypatch):
    system, near = slipping(2)
    ready, found = Options(1).prepare(system, near, 1000), peak_gradient(system, near, Options(1))
    component = system.output_names.index(found.output[0]), found.output[1]
    monkeypatch.setattr(Resonance, "read", lambda *_: None)
    for changes, asked, why in (
        ({}, False, "the peak's frequency was not asked for"),
        ({"sharp": True}, True, "the peak is sharp"),
        ({"distance": 1e-3}, True, "the peak is not exact"),
        ({}, True, "close beside the peak the path turns back or was lost"),
    ):
        again = _gradient_of_peak(ready, component, replace(found.peak, **changes), asked)
        assert again is not None
        with pytest.raises(InputError, match=f"^of_frequency: {why}"):
            again.of_frequency(AmplitudeGradient.by_force)
