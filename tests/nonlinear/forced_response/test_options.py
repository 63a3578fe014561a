"""What options there may be and are by default; steps that a point may take."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import gap_oscillator, random_system, sliding_system
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Element,
    Options,
    Shares,
    System,
    adaptive_response,
    frequency_response,
    hysteresis,
    parameter_response,
    peak_response,
    static_response,
)
from vanelock.nonlinear.continuation.globalisation import from_nothing
from vanelock.nonlinear.forced_response import frequency_sweep

PLANE: dict[str, object] = {"friction": "isotropic"}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"harmonics": -1}, "harmonics: given -1: must be >= 0"),
        ({"harmonics": 2.5}, "harmonics: given 2.5: needs a whole number"),
        ({"coupling": "loose"}, "coupling: given 'loose': allowed: coupled, uncoupled, constant-l"),
        ({"friction": "round"}, "friction: given 'round': allowed: orthogonal, isotropic"),
        ({"harmonic_diameters": "own"}, "harmonic_diameters: given 'own': allowed: wave, sector"),
        ({"direction": "left"}, "direction: given 'left': allowed: up, down"),
        ({"samples": 7}, "samples: given 7: needs at least 8"),
        ({"samples": 15, "harmonics": 3}, "samples: given 15: needs at least 16"),
        ({"samples": 96} | PLANE, "samples: given 96: isotropic friction has its events located"),
        ({"static_beyond": 1.0}, "static_beyond: given 1.0: must be > 1"),
        ({"tolerance": 0.0}, "tolerance: given 0.0: must be > 0"),
        ({"effort": 0}, "effort: given 0: must be >= 1"),
    ],
)
def test_what_is_not_possible_is_refused_at_once(given, message):
    with pytest.raises(InputError, match=message):
        Options(**given)


def test_too_few_samples_for_the_harmonics_by_default_are_refused():
    system, few = random_system(0), Options(samples=15)
    for solved in (
        lambda: frequency_response(system, [1.0], few, find_jumps=False),
        lambda: hysteresis(system, [1.0, 2.0], few),
        lambda: parameter_response(system, 1.0, "force", [1.0], few),
        lambda: peak_response(system, "force", [1.0], (1.0, 2.0), few),
    ):
        with pytest.raises(InputError, match="samples: given 15: needs at least 16"):
            solved()


def test_what_cannot_be_honoured_is_refused_with_the_reason():
    system, hertz = gap_oscillator(), [0.15, 0.2]
    with pytest.raises(InputError, match="direction: given 'down': hysteresis is of both ways"):
        hysteresis(system, hertz, Options(direction="down"))
    with pytest.raises(InputError, match="static_beyond: given 4: adaptive_response does not est"):
        adaptive_response(lambda _: system, hertz, Shares(0.1, 0.1), Options(static_beyond=4))


def test_by_default_there_are_three_harmonics_and_the_way_is_up():
    system = random_system(0)
    found = frequency_response(system, [0.3, 0.4], find_jumps=False)
    same = frequency_response(system, [0.3, 0.4], harmonics=3, direction="up", find_jumps=False)
    assert (found.harmonics, found.direction) == (3, "up")
    np.testing.assert_array_equal(found.contact, same.contact)


def test_options_by_name_are_refused_where_unknown_or_beside_others():
    system = sliding_system()
    assert not len(frequency_response(system, np.linspace(0.14, 0.22, 30), harmonics=3).jump)
    with pytest.raises(InputError, match="options: given, and harmonics beside: needs one of both"):
        static_response(system, Options(), harmonics=1)
    with pytest.raises(InputError, match="harmonic: given to static_response: allowed: system, "):
        static_response(system, harmonic=1)


HERTZ = np.linspace(0.5, 2.5, 41) / (2 * np.pi)


def folding():
    """A mass on a spring that hardens: two solutions between two folds, and one between them."""
    spring = Element(force="cubic_spring", places=[0], parameters=[4.0])
    return System.from_matrices([[1.0]], [[1.0]], elements=[spring], C=[[0.02]], force={0: 0.1})


def test_what_a_sweep_loses_is_found_from_the_other_side(monkeypatch):
    options, heard = Options(3, direction="down"), []
    whole = frequency_response(folding(), HERTZ, options, find_jumps=False)
    asked: list[float] = []

    def once(balance, *more):
        asked.append(balance.omega)
        found = from_nothing(balance, *more)
        return found if len(asked) == 1 else replace(found, converged=False, residual=1.0)

    monkeypatch.setattr(frequency_sweep, "from_nothing", once)

    def progress(done, total, hertz, amplitude):
        if np.isnan(amplitude):
            heard.append(hertz)

    found = frequency_response(folding(), HERTZ, options, progress, find_jumps=False)
    assert len(asked) > 2  # the first one, and what lies below the fold
    assert found.converged.all()
    np.testing.assert_allclose(found.amplitude, whole.amplitude, rtol=1e-9)
    assert set(np.round(heard, 9)) >= set(np.round(np.array(asked[1:]) / (2 * np.pi), 9))
