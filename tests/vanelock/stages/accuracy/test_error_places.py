"""Where meshes err: places, shares and densities of what their elements add."""

from dataclasses import replace

import numpy as np
import pytest

from vanelock.stages.accuracy.evidence import _error_places


@pytest.fixture
def parts(lattice):
    """A cube of twelve slices of tetrahedra along x, and another far above it."""
    bar = lattice((12, 1, 1), lambda p: p, "tetra")
    return [bar, replace(bar, points=bar.points + np.array([0.0, 0.0, 100.0]))]


def test_the_worst_place_is_described_with_what_lies_around_it(parts):
    count = len(parts[0].cells)
    middles = parts[0].points[parts[0].cells].mean(axis=1)
    energies = [np.full(count, 1.0), np.full(count, 0.5)]
    worst = int(np.argmin(np.linalg.norm(middles - [9.5 / 12, 0.5, 0.5], axis=1)))
    energies[1][worst] = 500.0
    found = _error_places(parts, energies)
    total = 1.0 * count + 0.5 * (count - 1) + 500
    assert found.part[0] == 1
    np.testing.assert_allclose(found.position[0], middles[worst] + [0, 0, 100])
    assert 500 / total < found.share[0] < 1
    assert (np.diff(found.share) <= 0).all()
    assert found.share.sum() <= 1 + 1e-12
    rows = found.table.shown
    assert rows[0][0] == "casing"
    assert rows[0][1] == pytest.approx(100 * found.share[0])


def test_the_mean_density_over_the_volume_is_one(parts):
    """At nodes: energies of the elements around over their volumes, both in all of one size."""
    count = len(parts[0].cells)
    found = _error_places(parts, [np.full(count, 3.0), np.full(count, 3.0)])
    np.testing.assert_allclose(found.vane, 1, rtol=1e-9)
    np.testing.assert_allclose(found.casing, 1, rtol=1e-9)
