"""What `stability` refuses, reports and keeps."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.forced_response.test_hysteresis import HIGH, LOW
from tests.nonlinear.systems import gap_oscillator
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    STABLE,
    UNDECIDED,
    UNSTABLE,
    Contacts,
    Diameter,
    Force,
    Options,
    Stability,
    System,
    frequency_response,
    hysteresis,
    stability,
    static_response,
    stuck_modes,
)
from vanelock.nonlinear.fourier import TURN


def impact(push=1.0, sectors=1, **more):
    """A mass on two springs, one of which cannot pull, in every sector; the sectors are apart."""
    own = np.array([[[1.0], [0.0], [0.0]]])
    same = Diameter(K=np.eye(1), M=np.eye(1), own=own)
    contacts = Contacts([4.0], [[1.0, 1.0]], [0.0], [0.3])
    diameters = dict.fromkeys(range(sectors // 2 + 1), same)
    return System(sectors, 1, diameters, contacts, {1: Force([push])}, damping_ratio=0.05, **more)


HERTZ = 3.2 / (2 * np.pi)


@pytest.fixture(scope="module")
def wave():
    return frequency_response(impact(), [HERTZ], Options(5))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (Options(5, coupling="uncoupled"), "uncoupled, located events"),
        (Options(5, coupling="constant-load"), "constant-load, located events"),
        (Options(5, samples=64), "coupled, 64 samples"),
    ],
)
def test_other_laws_are_refused(options, words):
    response = frequency_response(impact(), [HERTZ], options)
    with pytest.raises(InputError, match=f"response: {words}.*: stability is of coupled"):
        stability(impact(), response)


def test_what_does_not_fit_is_refused_in_one_line(wave):
    system = impact()
    for given, words in (
        ((system, static_response(system)), "response: at rest"),
        ((impact(1.1), wave), "response: no solution of this system at 0.509296 Hz: off by"),
        ((system, wave, [1]), "points: given 1: there are 1, counted from 0"),
        ((system, wave, []), "points: given none"),
        ((system, wave, None, 4), "harmonics: given 4: the response has 5 already"),
        ((system, wave, None, None, 0), "count: given 0"),
    ):
        with pytest.raises(InputError, match=words):
            stability(*given)


def test_all_nodal_diameters_are_needed():
    system = impact(sectors=6)
    response = frequency_response(system, [HERTZ], Options(1))
    few = replace(system, diameters={k: system.at(k) for k in (0, 1)})
    with pytest.raises(
        InputError, match="no matrices for nodal diameters 2, 3: stability needs 0 to 3"
    ):
        stability(few, response)


def test_damping_that_couples_modes_is_refused():
    own = [[[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]]
    C = [[0.1, 0.05], [0.05, 0.1]]
    diameters = {0: Diameter(K=np.diag([1.0, 2.0]), M=np.eye(2), own=own, C=C)}
    system = replace(impact(), diameters=diameters, force={1: Force([1.0, 0.0])})
    system = replace(system, damping_ratio=None)
    response = frequency_response(system, [HERTZ], Options(1))
    with pytest.raises(InputError, match="nd/0/C: given one that couples the modes"):
        stability(system, response)


def test_what_is_reported_is_kept(wave, tmp_path):
    found = stability(impact(), wave, modes={0: stuck_modes(impact(), 0)})
    # The multiplier of the closed form is -1.3503: a period twice as long.
    assert found.verdict.tolist() == [UNSTABLE]
    assert found.growing.tolist() == [1]
    assert found.multiplier[0, 0] == pytest.approx(-1.3503, abs=1e-3)
    np.testing.assert_allclose(found.seen[0, 0] % HERTZ, HERTZ / 2, rtol=1e-5)
    assert found.harmonics.tolist() == [5, 7]
    found.save(tmp_path / "stability.h5")
    again = Stability.load(tmp_path / "stability.h5")
    np.testing.assert_array_equal(again.exponent, found.exponent)
    np.testing.assert_array_equal(again.seen, found.seen)


def test_sectors_apart_have_the_exponents_of_one(wave):
    # In a ring of sectors that know nothing of each other diameters are a matter of phase.
    alone = stability(impact(), wave, count=1)
    for sectors in (2, 3, 4, 5, 6):
        ring = impact(sectors=sectors)
        response = frequency_response(ring, [HERTZ], Options(5))
        found = stability(ring, response, count=2 * sectors)
        grows = found.exponent[0][found.exponent[0].real > 0]
        np.testing.assert_allclose(grows.real, alone.exponent[0, 0].real, rtol=1e-6)
        # In the sectors' own frames each is one with all N others: a motion for each sector.
        either = sum(1 if abs(s.imag) < 1e-6 * HERTZ else 2 for s in grows)
        assert found.growing[0] == len(grows)
        assert either >= sectors


def test_point_that_is_not_solved_is_undecided(wave):
    found = stability(impact(), replace(wave, converged=np.array([False])))
    assert found.verdict.tolist() == [UNDECIDED]
    assert np.isnan(found.exponent).all()
    assert np.isnan(found.growth).all()


def test_truncations_that_differ_leave_it_open():
    # One harmonic of an impact spring knows nothing of how it parts from the wave.
    seen = set()
    for hertz in np.linspace(0.3, 0.6, 16):
        response = frequency_response(impact(), [hertz], Options(1))
        found = stability(impact(), response, harmonics=9)
        both = found.growth[0] > 0
        expected = UNDECIDED if both[0] != both[1] else UNSTABLE if both[0] else STABLE
        assert found.verdict[0] == expected
        seen.add(expected)
    assert seen == {STABLE, UNSTABLE, UNDECIDED}


def test_neutral_motions_are_undecided():
    # No damping, no friction that moves: nothing grows, nothing shrinks.
    system = replace(impact(0.01), damping_ratio=None)
    found = stability(system, frequency_response(system, [0.6], Options(1)))
    assert found.verdict.tolist() == [UNDECIDED]
    np.testing.assert_allclose(np.abs(found.multiplier[0, 0]), 1)


def test_the_branch_between_folds_is_unstable_and_the_others_are_not():
    system = gap_oscillator()
    found = hysteresis(system, (LOW / TURN, HIGH / TURN), Options(3))
    path, (first, second) = found.branch, found.fold
    assert 1 < first < second < path.points - 2
    middle = (first + second) // 2
    chosen = [first // 2, middle, (second + path.points) // 2]
    assert found.unstable[chosen].tolist() == [False, True, False]
    tested = stability(system, path, chosen)
    assert tested.verdict.tolist() == [STABLE, UNSTABLE, STABLE]
    assert abs(tested.exponent[1, 0].imag) < 1e-9 * TURN * path.frequency[middle]
    assert tested.growing.tolist() == [0, 1, 0]
