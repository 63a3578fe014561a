"""A sector's shape around the ring and in time, against the analytic travelling wave."""

import numpy as np
import pytest

from vanelock.render.scenes import annulus


def wave(points, nodal_diameter):
    """A field given on the whole ring: u(θ) = (a e_r + b e_θ + c e_z) e^{-i ND θ}."""
    angle = np.arctan2(points[:, 1], points[:, 0])
    radial = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    around = np.column_stack([-np.sin(angle), np.cos(angle), 0 * angle])
    axial = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    phase = np.exp(-1j * nodal_diameter * angle)[:, None]
    return (0.3 * radial + (0.2 - 0.5j) * around + 0.7j * axial) * phase


@pytest.mark.parametrize("nodal_diameter", [0, 1, 3, 8, -1])
def test_each_sector_carries_the_wave_of_the_whole_ring(sector, nodal_diameter):
    part = sector(sectors=16)
    own = wave(part.points, nodal_diameter)
    for j in (1, 5, 15, 16):
        there = annulus.sector_points(part.points, j, 16)
        expected = wave(there, nodal_diameter)
        given = annulus.sector_shape(own, j, 16, nodal_diameter)
        np.testing.assert_allclose(given, expected, atol=1e-13)


def test_peak_is_the_largest_length_in_a_cycle():
    random = np.random.default_rng(4)
    shape = random.standard_normal((20, 3)) + 1j * random.standard_normal((20, 3))
    steps = np.linspace(0, 2 * np.pi, 20001)
    lengths = [np.linalg.norm(annulus.at(shape, angle), axis=1) for angle in steps]
    np.testing.assert_allclose(annulus.peak(shape), np.max(lengths, axis=0), rtol=1e-7)


def test_largest_instant_over_two_shapes():
    random = np.random.default_rng(5)
    a, b = (random.standard_normal((9, 3)) + 1j * random.standard_normal((9, 3)) for _ in range(2))

    def energy(angle):
        return sum(float(np.sum(annulus.at(shape, angle) ** 2)) for shape in (a, b))

    best = max(energy(angle) for angle in np.linspace(0, np.pi, 10001))
    assert energy(annulus.largest_instant(a, b)) == pytest.approx(best, rel=1e-6)


def test_cylindrical_components_and_names_of_known_waves(sector):
    part = sector(sectors=16)
    angle = np.arctan2(part.points[:, 1], part.points[:, 0])
    given = annulus.cylindrical(part.points, wave(part.points, 1))
    expected = np.exp(-1j * angle)[:, None] * np.array([0.3, 0.2 - 0.5j, 0.7j])
    np.testing.assert_allclose(given, expected, atol=1e-14)
    assert annulus.dominant(part.points, wave(part.points, 1)) == 2
    assert annulus.wave_name(1, 16) == "nodal diameter 1"
    assert annulus.wave_name(8, 16) == "nodal diameter 8"
    assert annulus.wave_name(15, 16) == "nodal diameter 1, backward wave"
    assert annulus.wave_name(-1, 16) == "nodal diameter 1, backward wave"


@pytest.mark.parametrize(
    ("largest", "drawn", "scale"),
    [(46e-6, 0.03, 500), (1e-6, 0.03, 20000), (0.03, 0.03, 1), (1e-4, 0.02, 200)],
)
def test_round_scale(largest, drawn, scale):
    assert annulus.round_scale(largest, drawn) == pytest.approx(scale, rel=1e-12)
