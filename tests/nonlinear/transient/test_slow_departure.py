"""A wave that a ring leaves slowly is not taken for one that it stays with."""

import numpy as np
import pytest

from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock.nonlinear import (
    STEADY,
    UNSTABLE,
    Options,
    frequency_response,
    settled_response,
    stability,
)


@pytest.mark.parametrize("seed", [0, 1])
def test_what_grows_slowly_is_not_hidden_by_what_dies_out(seed: int) -> None:
    system, frequency = loaded(spring_ring(20), 0.7101), worst_of(20)["lift"][2]
    response = frequency_response(system, [frequency], Options(9))
    tested = stability(system, response)
    assert tested.verdict[0] == UNSTABLE
    assert 1.002 < np.abs(tested.multiplier[0, 0]) < 1.004
    assert settled_response(system, response, 0, periods=200, seed=seed).verdict != STEADY
