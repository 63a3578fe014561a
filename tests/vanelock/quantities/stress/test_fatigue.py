"""Fatigue margins against what is done by hand."""

import numpy as np
import pytest

from vanelock.quantities.stress.fatigue import _half_chord, cycle
from vanelock.quantities.stress.margins import _Strength

STEEL = _Strength(limit=200e6, tensile=800e6)


def tension(value):
    """Uniaxial stress along x."""
    return np.array([value, 0, 0, 0, 0, 0], complex)


def shear(value):
    """Shear in xy."""
    return np.array([0, 0, 0, 0, 0, value], complex)


def periodic(*coefficients):
    """(H+1, 1, 6) harmonics of one place."""
    return np.stack(coefficients)[:, None]


TURNING = tension(100e6) - 1j * shear(100e6 / 3**0.5)
"""A cosine in tension and a sine / √3 in shear: von Mises 100 MPa at every instant."""
S = 120e6
"""A uniaxial stress whose axis turns: (1 + cos 2θ)/2, (1 - cos 2θ)/2, sin 2θ/2 times this. What
alternates is a shear S/2 of turning axes, √3/2 S by von Mises; the mean is S/2 twice."""
IN_PLANE = np.array([S / 2, S / 2, 0, 0, 0, 0], complex)
TURNS = np.array([S / 2, -S / 2, 0, 0, 0, -1j * S / 2])
ROOT = 3**0.5


@pytest.mark.parametrize(
    ("harmonics", "amplitude", "mean", "mises"),
    [
        ((tension(400e6), tension(50e6 * np.exp(0.7j))), 50e6, 400e6, 400e6),
        ((tension(-400e6), tension(50e6)), 50e6, -400e6, -400e6),
        ((shear(100e6), tension(50e6)), 50e6, 0, 100e6 * ROOT),
        ((tension(0), shear(50e6)), 50e6 * ROOT, 0, 0),
        ((tension(0), TURNING), 100e6, 0, 0),
        ((IN_PLANE, TURNS), ROOT / 2 * S, S, S / 2),
        ((tension(0), tension(100e6), tension(50e6)), 150e6, 0, 0),
    ],
)
def test_amplitude_and_mean_are_those_by_hand(harmonics, amplitude, mean, mises):
    found = cycle(periodic(*harmonics))
    given = found.amplitude[0], found.mean[0], found.mean_mises[0]
    assert given == pytest.approx((amplitude, mean, mises))


def test_goodman_margins_are_those_of_a_textbook():
    """50/200 + 400/800 = 0.75, beside 400 MPa half of the limit; compression is no help."""
    assert STEEL.reserve(50e6, 400e6) == pytest.approx(4 / 3)
    assert STEEL.growth(50e6, 400e6) == pytest.approx(2)
    assert STEEL.reserve(50e6, -400e6) == pytest.approx(4)
    assert STEEL.reserve(0.0, 0.0) == np.inf
    assert STEEL.growth(10e6, 900e6) == 0


def test_chords_of_what_turns_and_of_two_harmonics():
    """Their sum cos θ + cos 2θ / 2 goes from -3/4 to 3/2: 1.125 half of the range."""
    assert cycle(periodic(tension(0), TURNING)).chord[0] == pytest.approx(100e6)
    found = cycle(periodic(tension(0), tension(100e6), tension(50e6)))
    assert found.chord[0] == pytest.approx(112.5e6, rel=2e-3)


def test_chord_is_that_of_all_pairs_of_instants_and_within_the_distance_from_the_mean():
    random = np.random.default_rng(5)
    harmonics = random.normal(size=(4, 40, 6)) + 1j * random.normal(size=(4, 40, 6))
    found = cycle(harmonics)
    assert np.all(found.chord <= found.amplitude * (1 + 1e-9))
    assert np.all(found.chord > 0.5 * found.amplitude)
    random = np.random.default_rng(6)
    h = random.normal(size=(3, 1, 6)) + 1j * random.normal(size=(3, 1, 6))
    h[0] = 0
    t = 2 * np.pi * np.arange(400) / 400
    s = np.einsum("hc,ht->tc", h[:, 0], np.exp(1j * np.outer(np.arange(3), t))).real
    d = s[:, None] - s[None]
    x, y, z, yz, zx, xy = np.moveaxis(d, -1, 0)
    vm = np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) + 3 * (yz**2 + zx**2 + xy**2))
    assert 0.98 * vm.max() / 2 <= _half_chord(h)[0] <= vm.max() / 2 * (1 + 1e-4)
