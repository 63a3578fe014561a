"""Loads at which all contacts stick, and how far responses are from one another."""

from dataclasses import replace

import numpy as np
import pytest

from vanelock.nonlinear import STUCK, Options, frequency_response, linear_response, static_response
from vanelock.published.checks import MARGIN, at_mean_load, between, from_linear, sticking_load

HERTZ = np.linspace(100, 190, 60)
OUTPUT = (0, 2)


def loaded(system, factor):
    force = {1: replace(system.force[1], vector=factor * system.force[1].vector)}
    return replace(system, force=force)


def test_the_interlock_sticks_at_the_load_and_slips_well_above(sector):
    stuck = linear_response(sector, HERTZ, np.ones(2, bool))
    small = sticking_load(static_response(sector), stuck, sector.contacts.opens)
    assert 0 < small < 1
    at = frequency_response(loaded(sector, small), HERTZ, Options(1))
    assert (at.state[:, 1] == STUCK).all()
    beyond = frequency_response(loaded(sector, 2.5 * small / MARGIN), HERTZ, Options(1))
    assert (beyond.state[:, 1] != STUCK).any()


def test_at_full_stick_coupled_and_uncoupled_coincide(sector):
    stuck = linear_response(sector, HERTZ, np.ones(2, bool))
    small = loaded(sector, sticking_load(static_response(sector), stuck, sector.contacts.opens))
    response = frequency_response(small, HERTZ, Options(1))
    found = between(response, "uncoupled", small, OUTPUT)
    assert found.vibration < 1e-9
    assert (found.frequency, found.amplitude) == pytest.approx((0, 0), abs=1e-9)
    assert found.slipping == 0
    full = frequency_response(sector, HERTZ, Options(1))
    assert between(full, "uncoupled", sector, OUTPUT).vibration > 0.01


def test_hooks_alone_are_linear_where_the_interlock_is_apart(sector):
    apart = replace(sector, contacts=replace(sector.contacts, v0=np.array([4e-4, -1e-3])))
    hooks = np.array([True, False])
    response = frequency_response(apart, HERTZ, Options(1))
    found = from_linear(response, apart, hooks, OUTPUT)
    assert found.vibration < 1e-9
    assert found.slipping == 0
    weak = replace(apart, contacts=replace(apart.contacts, mu=np.array([1e-5, 0.3])))
    slips = from_linear(frequency_response(weak, HERTZ, Options(1)), weak, hooks, OUTPUT)
    assert slips.slipping == 1
    assert slips.vibration > 1e-6


def test_the_mean_load_of_the_coupled_peak_explains_constant_load(sector):
    # Strong vibration: the interlock lifts off, and its mean load grows.
    strong = loaded(sector, 3.0)
    response = frequency_response(strong, (100.0, 190.0), Options(1))
    top = response.at([int(response.amplitude[:, 0, 2].argmax())])
    static = static_response(strong).force[0, 0, 1, 0].real
    assert top.force[0, 0, 1, 0].real > 1.05 * static
    held = (
        frequency_response(strong, (100.0, 190.0), Options(1, coupling="constant-load"))
        .amplitude[:, 0, 2]
        .max()
    )
    again = at_mean_load(strong, top, (100.0, 190.0), OUTPUT)
    coupled = float(top.amplitude[0, 0, 2])
    assert abs(again - coupled) < 0.5 * abs(held - coupled)
