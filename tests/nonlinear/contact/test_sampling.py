"""How few samples of a period are too few."""

from collections.abc import Callable

import pytest

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    System,
    frequency_response,
    hysteresis,
    parameter_response,
    peak_response,
)

Make = Callable[..., System]


def test_too_few_samples_are_refused_everywhere(random_system: Make) -> None:
    system, message = random_system(0), "samples: given 3: needs at least 16"
    with pytest.raises(InputError, match=message):
        frequency_response(system, [1.0], 3, samples=3)
    with pytest.raises(InputError, match=message):
        hysteresis(system, [1.0, 2.0], 3, samples=3)
    with pytest.raises(InputError, match=message):
        parameter_response(system, 1.0, "force", [1.0], 3, samples=3)
    with pytest.raises(InputError, match=message):
        peak_response(system, "force", [1.0], (1.0, 2.0), 3, samples=3)
