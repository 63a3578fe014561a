"""Modes that count by their static part alone: the estimated error against the true one."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.nonlinear import SLIP, SLIP_OPEN, Force, Options, System, frequency_response

Make = Callable[..., System]
Lowest = Callable[[System], float]


def test_estimated_truncation_is_the_error_made(
    random_system: Make, first_frequency: Lowest
) -> None:
    system = random_system(7, size=60, preload=10.0, damping_ratio=0.01)
    hertz = first_frequency(system) * np.array([0.3, 0.8, 1.2, 2.0])
    full = frequency_response(system, hertz, Options(3), find_jumps=False)
    assert full.converged.all()
    assert np.isin(full.state, (SLIP, SLIP_OPEN)).any()
    assert np.all(full.truncation == 0.0)
    largest = np.abs(full.contact[:, 1:]).max(axis=(1, 2, 3))
    for beyond, greatest in ((6.0, 0.3), (16.0, 0.05)):
        cut = frequency_response(system, hertz, Options(3, static_beyond=beyond), find_jumps=False)
        made = np.abs(cut.contact[:, 1:] - full.contact[:, 1:]).max(axis=(1, 2, 3)) / largest
        assert 0.2 * greatest < cut.truncation.max() < greatest
        # To first order: the larger the error, the less is it known.
        np.testing.assert_allclose(cut.truncation, made, rtol=0.1 + 3 * greatest)


def test_cut_off_structure_under_an_unbalance_is_the_same_from_tables(
    random_system: Make, first_frequency: Lowest
) -> None:
    # Few frequencies are summed mode by mode; many come from tables.
    system = random_system(7, size=60, preload=10.0)
    force = {1: Force(system.force[1].vector, omega_power=2)}
    hertz = first_frequency(system) * np.linspace(1.2, 2.0, 60)
    unbalanced = replace(system, force=force)
    beyond = 3.0
    tabulated = frequency_response(
        unbalanced, hertz, Options(1, static_beyond=beyond), find_jumps=False
    )
    summed = frequency_response(
        unbalanced, hertz[[-20, -1]], Options(1, static_beyond=beyond), find_jumps=False
    )
    np.testing.assert_allclose(summed.contact[1], tabulated.contact[-1], atol=1e-8)
    assert np.abs(summed.contact[1, 1:]).max() > 1e-2


def test_truncation_is_refused_where_modes_are_coupled(random_system: Make) -> None:
    system = random_system(7, damping_ratio=None)
    rng = np.random.default_rng(0)
    damped = {}
    for k, matrices in system.diameters.items():
        factor = rng.normal(size=matrices.K.shape)
        damped[k] = replace(matrices, C=1e-3 * factor @ factor.T)
    system = replace(system, diameters=damped)
    with pytest.raises(InputError, match="static_beyond: given with a C that couples the modes"):
        frequency_response(system, [1.0], Options(1, static_beyond=10.0))
    with pytest.raises(InputError, match=r"static_beyond: given 0\.5: must be > 1"):
        frequency_response(system, [1.0], Options(1, static_beyond=0.5))
