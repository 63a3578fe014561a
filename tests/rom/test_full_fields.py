"""Recovered fields: around the annulus, their stresses and energy, and adjoint functionals."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from tests.verification.conftest import whole_ring
from vanelock import fem, rom
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError

N = 5
STEEL = fem.Material(E=200e9, nu=0.3, rho=7800.0)


@pytest.fixture(scope="module", params=["cyclic", "paper"])
def ring(ring_sector, request):
    """A sector of a clamped ring with some master nodes, reduced at each diameter."""
    model = ring_sector(sectors=N, counts=(1, 4, 2))
    options = {} if request.param == "cyclic" else {"interface_modes": 8}
    component = rom.reduce(
        model, ("force",), 6, nodal_diameters=range(N), route=request.param, **options
    )
    return rom.recovery(component, model)


def coordinates(recovery, count=2, seed=0):
    rng = np.random.default_rng(seed)
    shape = (recovery.component.size, count)
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


@pytest.mark.parametrize("k", range(N))
def test_fields_of_all_sectors_make_the_whole_ring(ring, k):
    q = coordinates(ring)
    full, number = whole_ring(ring.model.part)
    u = np.full((len(full.points), 3, q.shape[1]), np.nan + 0j)
    for j in range(N):
        mine = ring.displacement(q, k, sector=j)
        before = u[number[j]]
        shared = ~np.isnan(before[:, 0, 0])
        # The last node of one sector's right face is the next one's left face: no gap.
        assert np.abs(before[shared] - mine[shared]).max(initial=0) < 1e-12 * np.abs(mine).max()
        u[number[j]] = mine
    strain = fem.strain(full, u)
    stress = fem.hooke(STEEL, strain)
    for j in range(N):
        for found, expected in (
            (ring.strain(q, k, sector=j), strain[number[j]]),
            (ring.stress(q, k, sector=j), stress[number[j]]),
        ):
            assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()


def test_strain_of_a_sector_is_that_of_the_turned_part(ring_scene):
    """The vane too, which has no cyclic faces."""
    recovery = rom.recovery(ring_scene.vane, ring_scene.vane_model)
    q = coordinates(recovery, 1)[:, 0]
    part = ring_scene.vane_model.part
    N = part.sectors
    j, k = 3, 2
    turned = replace(part, points=part.points @ turn(N, j).T)
    expected = fem.strain(turned, recovery.displacement(q, k, sector=j))
    found = recovery.strain(q, k, sector=j)
    assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()
    # ... and the displacement is sector 0's, turned by 2πj/N and later by 2πjk/N.
    delayed = recovery.displacement(q, k) @ turn(N, j).T * np.exp(-2j * np.pi * j * k / N)
    assert (
        np.abs(recovery.displacement(q, k, sector=j) - delayed).max()
        < 1e-13 * np.abs(delayed).max()
    )


@pytest.mark.parametrize("part", ["vane", "casing"])
def test_a_functional_s_row_is_the_functional_of_the_recovered_field(ring_scene, part):
    recovery = rom.recovery(getattr(ring_scene, part), getattr(ring_scene, f"{part}_model"))
    nodes = len(recovery.model.part.points)
    rng = np.random.default_rng(2)
    functional = sp.random_array((3, 3 * nodes), density=0.01, rng=rng).tocsr()
    functional = functional + 1j * sp.random_array((3, 3 * nodes), density=0.01, rng=rng)
    q = coordinates(recovery, 4)
    for k in (0, 1):
        direct = functional @ recovery.displacement(q, k).reshape(3 * nodes, -1)
        rows = recovery.rows(functional, k)
        scale = np.linalg.norm(rows, axis=1)[:, None] * np.linalg.norm(q, axis=0)
        assert np.max(np.abs(rows @ q - direct) / scale) < 1e-12
        phase = np.exp(-2j * np.pi * 5 * k / 8)
        np.testing.assert_allclose(recovery.rows(functional, k, sector=5), phase * rows)


@pytest.mark.parametrize("ring", ["cyclic"], indirect=True)
def test_a_part_in_one_piece_is_recovered_with_the_factors_that_it_was_reduced_with(ring):
    """A load on its masters bends it as it bends the unreduced part."""
    model = ring.model
    prepared = rom.prepare(model, ("force",), cyclic=False)
    component = rom.reduce(model, ("force",), 6, prepared=prepared)
    alone = rom.reduce(model, ("force",), 6).at(0)
    np.testing.assert_array_equal(component.at(0).K, alone.K)
    np.testing.assert_array_equal(component.at(0).M, alone.M)
    rows = component.dofs(component.masters.nodes).ravel()
    load = np.random.default_rng(1).standard_normal((len(rows), 2))
    forces, f = np.zeros((component.size, 2)), np.zeros((model.K.shape[0], 2))
    forces[rows], f[model.rows("force").ravel()] = load, load
    found = rom.recovery(component, model, prepared)
    u = found.displacement(np.linalg.solve(component.at(0).K, forces), 0)
    exact = np.linalg.solve(model.K.toarray(), f)
    np.testing.assert_allclose(u, model.field(exact), rtol=0, atol=1e-10 * abs(exact).max())
    with pytest.raises(InputError, match="give the same model, masters and averaged sets"):
        rom.reduce(model, ("force",), 6, nodal_diameters=[0], prepared=prepared)
