"""What limit cycles refuse, and what they are where nothing is driven."""

import numpy as np
import pytest

from tests.verification.nonlinear.peaks.test_limit_cycles import found, one_mass
from vanelock.common.errors import InputError
from vanelock.nonlinear import Options, aerodynamic_coefficients, aerodynamic_damping, limit_cycles


def test_air_that_damps_leaves_no_cycle() -> None:
    quiet = found(-0.1, 1)
    assert len(quiet.amplitude) == 0
    assert quiet.critical_kick == np.inf
    assert quiet.linear_damping == pytest.approx(quiet.aerodynamic_damping)
    assert quiet.linear_damping > 0


def test_real_coefficients_move_the_frequency_alone() -> None:
    plain, size = found(0.36, 1), 0.2 / 0.25
    stiff = limit_cycles(
        one_mass(), 1, {0: -0.1 + 1j * 0.36 * 0.25 / np.pi}, (0.3 * size, 12 * size), Options(1)
    )
    np.testing.assert_allclose(stiff.amplitude, plain.amplitude, rtol=1e-9)
    squares = (2 * np.pi * stiff.frequency) ** 2 - (2 * np.pi * plain.frequency) ** 2
    np.testing.assert_allclose(squares, 0.1, rtol=1e-9)


def test_coefficients_are_checked() -> None:
    with pytest.raises(InputError, match=r"^influence: given sectors \[-1, 4\]: two are the same"):
        aerodynamic_coefficients({-1: 1j, 4: 2j}, 5)
    with pytest.raises(InputError, match=r"needs \(5,\), one a sector"):
        aerodynamic_coefficients(np.ones(4), 5)
    with pytest.raises(InputError, match="not finite"):
        aerodynamic_coefficients({0: np.nan}, 5)
    with pytest.raises(InputError, match="^frequency: given 0"):
        aerodynamic_damping({0: 1j}, 5, 0.0)
