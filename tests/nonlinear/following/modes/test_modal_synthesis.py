"""Curves drawn from a damped mode: small loads, phases, rotating unbalance, what is refused."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.verification.nonlinear.spring_rings import loaded, spring_ring
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    ModalSynthesis,
    Options,
    damped_mode,
    linear_response,
    modal_synthesis,
)
from vanelock.rom.system.system import Force

RING = spring_ring(0)
SMALL = 2e-4


@cache
def mode():
    """A damped mode of the ring."""
    return damped_mode(RING, 1, (1e-3, 10.0), Options(1))


def own():
    """The load along its stuck shape."""
    return RING.at(RING.nodal_diameter(1)).M @ mode().shape[0]


def test_a_small_load_is_answered_as_by_the_stuck_structure():
    """All its modes, phases and all: their own part at the mode's frequency, so near it."""
    curve = modal_synthesis(RING, mode()).response(SMALL)
    apart = np.abs(curve.frequency / mode().linear[0] - 1)
    near = np.flatnonzero((apart < 2e-3) & (curve.amplitude < 1e-2))
    assert len(near) > 10
    stuck = linear_response(loaded(RING, SMALL), curve.frequency[near]).output[:, 1]
    size = np.abs(stuck).max()
    assert np.abs(curve.output[near] - stuck).max() < 1e-3 * size
    alone = modal_synthesis(RING, mode()).response(SMALL, others=False)
    near = np.abs(alone.frequency / mode().linear[0] - 1) < 2e-3
    stuck = linear_response(loaded(RING, SMALL), alone.frequency[near]).output[:, 1]
    assert np.abs(alone.output[near] - stuck).max() > 5e-3 * size


def test_a_load_along_the_stuck_mode_moves_no_other_while_all_stick():
    system = replace(RING, force={1: Force(own())})
    found = modal_synthesis(system, mode())
    np.testing.assert_allclose(found.driving[0], 1.0, rtol=1e-9)
    assert np.abs(found.force[0]).max() < 1e-9
    assert (
        np.abs(found.others[0]).max() < 1e-9 * np.abs(found.output[0]).max() / mode().amplitude[0]
    )


def test_an_unbalance_is_a_load_that_grows():
    """At its frequency on the curve, the load that does not grow gives the same point."""
    vector = RING.force[1].vector
    growing = replace(RING, force={1: Force(1e-4 * vector, omega_power=2)})
    curve = modal_synthesis(growing, mode()).response()
    i = int(curve.amplitude.argmax()) + 40
    scale = 1e-4 * (2 * np.pi * curve.frequency[i]) ** 2
    same = modal_synthesis(RING, mode()).response(scale)
    near = np.abs(same.frequency - curve.frequency[i]) + np.abs(
        same.amplitude / curve.amplitude[i] - 1
    )
    k = int(near.argmin())
    others = [k - 1, k, k + 1]
    order = np.argsort(same.amplitude[others])
    hertz = np.interp(
        curve.amplitude[i], same.amplitude[others][order], same.frequency[others][order]
    )
    np.testing.assert_allclose(hertz, curve.frequency[i], rtol=1e-5)


def test_it_is_saved_and_read(tmp_path):
    found = modal_synthesis(RING, mode())
    found.save(tmp_path / "synthesis.h5")
    again = ModalSynthesis.load(tmp_path / "synthesis.h5").response(SMALL)
    np.testing.assert_array_equal(again.output, found.response(SMALL).output)


def test_what_does_not_fit_is_refused():
    with pytest.raises(InputError, match="has no load of the first harmonic"):
        modal_synthesis(replace(RING, force={}), mode())
    with pytest.raises(InputError, match="under force/1 alone"):
        modal_synthesis(replace(RING, force={**RING.force, 2: RING.force[1]}), mode())
    with pytest.raises(InputError, match="nodal diameter 1; the load, of engine order 2, is of 2"):
        modal_synthesis(replace(RING, engine_order=2), mode())
    one = {name: getattr(RING.contacts, name)[:1] for name in ("kn", "kt", "mu", "v0")}
    fewer = replace(RING, contacts=replace(RING.contacts, **one))
    with pytest.raises(InputError, match="the system has 3 and 1"):
        modal_synthesis(fewer, mode())
    with pytest.raises(InputError, match="does not drive the mode"):
        modal_synthesis(replace(RING, force={1: Force(0 * own())}), mode())
    with pytest.raises(InputError, match="scale: given 0"):
        modal_synthesis(RING, mode()).response(0.0)
