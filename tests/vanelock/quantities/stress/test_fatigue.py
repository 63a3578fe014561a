"""Fatigue margins against what is done by hand."""

import numpy as np
import pytest

from vanelock.quantities.stress.fatigue import Strength, cycle, half_chord

STEEL = Strength(limit=200e6, tensile=800e6)


def tension(value):
    """Uniaxial stress along x."""
    return np.array([value, 0, 0, 0, 0, 0], complex)


def shear(value):
    """Shear in xy."""
    return np.array([0, 0, 0, 0, 0, value], complex)


def periodic(*coefficients):
    """(H+1, 1, 6) harmonics of one place."""
    return np.stack(coefficients)[:, None]


def test_bar_in_tension_has_the_goodman_margin_of_a_textbook():
    # 50 MPa about 400 MPa: 50/200 + 400/800 = 0.75; vibration may grow to half of the limit.
    found = cycle(periodic(tension(400e6), tension(50e6 * np.exp(0.7j))))
    assert found.amplitude[0] == pytest.approx(50e6)
    assert found.mean[0] == found.mean_mises[0] == pytest.approx(400e6)
    assert STEEL.reserve(found.amplitude, found.mean)[0] == pytest.approx(4 / 3)
    assert STEEL.growth(found.amplitude, found.mean)[0] == pytest.approx(2)


def test_compression_at_rest_earns_no_credit():
    found = cycle(periodic(tension(-400e6), tension(50e6)))
    assert found.mean[0] == found.mean_mises[0] == pytest.approx(-400e6)
    assert STEEL.reserve(found.amplitude, found.mean)[0] == pytest.approx(4)


def test_mean_torsion_does_no_harm_by_sines_and_does_by_von_mises():
    found = cycle(periodic(shear(100e6), tension(50e6)))
    assert found.mean[0] == 0
    assert found.mean_mises[0] == pytest.approx(100e6 * 3**0.5)


def test_alternating_torsion_counts_root_three_times():
    found = cycle(periodic(tension(0), shear(50e6)))
    assert found.amplitude[0] == pytest.approx(50e6 * 3**0.5)


def test_rotating_tensor_has_a_constant_distance_from_its_mean():
    # cos in tension and sin / √3 in shear: von Mises 100 MPa at every instant.
    turning = tension(100e6) - 1j * shear(100e6 / 3**0.5)
    found = cycle(periodic(tension(0), turning))
    assert found.amplitude[0] == pytest.approx(100e6)
    assert found.chord[0] == pytest.approx(100e6)


def test_tension_turning_in_its_plane_alternates_by_its_deviator():
    # A uniaxial stress S whose axis turns: (1 + cos 2θ)/2, (1 - cos 2θ)/2, sin 2θ/2 times S. What
    # alternates is a shear S/2 of turning axes, √3/2 S by von Mises; the mean is S/2 twice.
    S = 120e6
    mean = np.array([S / 2, S / 2, 0, 0, 0, 0], complex)
    turning = np.array([S / 2, -S / 2, 0, 0, 0, -1j * S / 2])
    found = cycle(periodic(mean, turning))
    assert found.amplitude[0] == pytest.approx(3**0.5 / 2 * S)
    assert found.mean[0] == pytest.approx(S)


def test_two_harmonics_in_one_direction_by_their_extremes():
    # cos θ + cos 2θ / 2 goes from -3/4 to 3/2: 1.5 from the mean, 1.125 half of the range.
    found = cycle(periodic(tension(0), tension(100e6), tension(50e6)))
    assert found.amplitude[0] == pytest.approx(150e6)
    assert found.chord[0] == pytest.approx(112.5e6, rel=2e-3)


def test_chord_never_exceeds_the_distance_from_the_mean():
    random = np.random.default_rng(5)
    harmonics = random.normal(size=(4, 40, 6)) + 1j * random.normal(size=(4, 40, 6))
    found = cycle(harmonics)
    assert np.all(found.chord <= found.amplitude * (1 + 1e-9))
    assert np.all(found.chord > 0.5 * found.amplitude)


def test_chord_is_that_of_all_pairs_of_instants():
    random = np.random.default_rng(6)
    h = random.normal(size=(3, 1, 6)) + 1j * random.normal(size=(3, 1, 6))
    h[0] = 0
    t = 2 * np.pi * np.arange(400) / 400
    s = np.einsum("hc,ht->tc", h[:, 0], np.exp(1j * np.outer(np.arange(3), t))).real
    d = s[:, None] - s[None]
    x, y, z, yz, zx, xy = np.moveaxis(d, -1, 0)
    vm = np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) + 3 * (yz**2 + zx**2 + xy**2))
    assert 0.98 * vm.max() / 2 <= half_chord(h)[0] <= vm.max() / 2 * (1 + 1e-4)


def test_nothing_alternates_and_nothing_breaks():
    assert STEEL.reserve(0.0, 0.0) == np.inf
    assert STEEL.growth(10e6, 900e6) == 0
