"""Recovered fields: around the annulus, their stresses and energy, and adjoint functionals."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sl
import scipy.sparse as sp
from scipy.spatial import KDTree

from vanelock import fem, rom
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.mesh import Part

N = 5
STEEL = fem.Material(E=200e9, nu=0.3, rho=7800.0)


@pytest.fixture(scope="module", params=["cyclic", "paper"])
def ring(lattice, request):
    """A sector of a clamped ring with three master nodes, reduced at each diameter."""

    def place(p):
        r, angle = 0.5 + 0.1 * p[:, 0], 2 * np.pi / N * (p[:, 1] - 0.5)
        angle = angle + 0.1 * np.sin(3 * p[:, 2])
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.2 * p[:, 2]])

    part = lattice((1, 4, 2), place, "tetra10", curved=True, sectors=N)
    inner = np.setdiff1d(
        part.node_sets["x1"], np.concatenate([part.node_sets[s] for s in ("y0", "y1", "z0")])
    )
    sets = {
        "left": part.node_sets["y0"],
        "right": part.node_sets["y1"],
        "fixed": part.node_sets["z0"],
        "force": inner[::5],
    }
    part = replace(part, name="ring", node_sets=sets)
    model = fem.assemble(part, STEEL)
    options = {} if request.param == "cyclic" else {"interface_modes": 8}
    component = rom.reduce(
        model, ("force",), 6, nodal_diameters=range(N), route=request.param, **options
    )
    return rom.recovery(component, model)


def coordinates(recovery, count=2, seed=0):
    rng = np.random.default_rng(seed)
    shape = (recovery.component.size, count)
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


def whole(part):
    """The ring of all sectors, the faces merged, and (N, nodes) its node of each sector's node."""
    points = np.concatenate([part.points @ turn(N, j).T for j in range(N)])
    first = np.array([min(found) for found in KDTree(points).query_ball_point(points, 1e-9)])
    kept, number = np.unique(first, return_inverse=True)
    n = len(part.points)
    cells = np.concatenate([number[part.cells + j * n] for j in range(N)])
    full = Part("whole", points[kept], cells, part.cell_type, {}, {}, 1)
    return full, number.reshape(N, n)


@pytest.mark.parametrize("k", range(N))
def test_fields_of_all_sectors_make_the_whole_ring(ring, k):
    q = coordinates(ring)
    full, number = whole(ring.model.part)
    assert len(full.points) == N * (
        len(ring.model.part.points) - len(number[0]) + len(np.setdiff1d(number[0], number[1]))
    )
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
def test_a_gauge_turns_with_its_sector(ring):
    part, j = ring.model.part, 4
    found = fem.gauge(part, [0.6, 0.01, 0.11], [0, 1, 1], length=5e-3)
    q = coordinates(ring)
    R = turn(N, j)
    turned = replace(part, points=part.points @ R.T)
    there = fem.gauge(turned, R @ [0.6, 0.01, 0.11], R @ [0, 1, 1], length=5e-3)
    for k in (0, 1, 3):
        direct = there.strain(ring.displacement(q, k, sector=j))
        assert ring.rows(found.row, k, sector=j)[0] @ q == pytest.approx(direct, rel=1e-11)


@pytest.mark.parametrize("k", [0, 1, 2])
def test_energy_of_a_mode_is_half_the_square_of_its_frequency(ring, k):
    reduced = ring.component.at(k)
    omega2, shapes = sl.eigh(reduced.K, reduced.M, subset_by_index=[0, 3])
    u = ring.displacement(shapes, k)
    model = ring.model
    x = np.zeros((model.K.shape[0], 4), complex)
    free = model.dofs >= 0
    x[model.dofs[free]] = u[free]
    half = 0.5 * np.einsum("nk,nk->k", x.conj(), model.K @ x).real
    np.testing.assert_allclose(half, 0.5 * omega2, rtol=1e-8)  # shapes are mass-normalised


@pytest.mark.parametrize("ring", ["cyclic"], indirect=True)
def test_a_softer_part_keeps_its_own_modulus_with_what_was_prepared_of_the_stiff_one(ring):
    """Displacements of the same coordinates are the same, stresses as much less as the modulus."""
    prepared = rom.prepare(ring.model, ("force",))
    metal = ring.model.material
    softer = replace(ring.model, K=0.7 * ring.model.K, material=replace(metal, E=0.7 * metal.E))
    found = rom.recovery(rom.stiffened(ring.component, 0.7), softer, prepared)
    q = coordinates(ring)
    np.testing.assert_allclose(found.displacement(q, 1), ring.displacement(q, 1), rtol=1e-9)
    np.testing.assert_allclose(found.stress(q, 1), 0.7 * ring.stress(q, 1), rtol=1e-7)
    assert found.model.material.E == 0.7 * metal.E


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
