"""Loads at rest: resultants against integrals over edges and volumes, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.fem import Material, assemble, centrifugal, pressure, stress, thermal

CELLS = ["tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27"]
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def bent(p):
    return p * [0.4, 0.3, 0.2] + 0.03 * np.sin(3 * p[:, [1, 2, 0]])


def block(lattice, cell_type, counts=(2, 3, 2)):
    part = lattice(counts, bent, cell_type, curved=True)
    return replace(part, node_sets={**part.node_sets, "all": np.arange(len(part.points))})


# The edges round a side of the lattice, in the order that makes its normal outward.
SIDES = {
    "x1": ("z0", "y1", "z1", "y0"), "y1": ("x0", "z1", "x1", "z0"), "z0": ("x0", "y1", "x1", "y0"),
}  # fmt: skip


def vector_area(part, side):
    """½ ∮ x × dx round a side, by Simpson's rule on each straight or parabolic edge: exact."""
    edges = [np.intersect1d(part.node_sets[side], part.node_sets[name]) for name in SIDES[side]]
    total = np.zeros(3)
    for edge, following in zip(edges, [*edges[1:], edges[0]], strict=True):
        (end,) = np.intersect1d(edge, following)
        order = np.argsort(-np.linalg.norm(part.points[edge] - part.points[end], axis=1))
        x = part.points[edge[order]]
        if part.cell_type in ("tetra", "hexahedron"):
            total += 0.5 * np.cross(x[:-1], x[1:]).sum(axis=0)
            continue
        for a, m, b in zip(x[:-2:2], x[1:-1:2], x[2::2], strict=True):
            slopes = (4 * m - 3 * a - b, b - a, a + 3 * b - 4 * m)
            total += np.cross([a, m, b], slopes).T @ [1, 4, 1] / 12
    return total


@pytest.mark.parametrize("cell_type", CELLS)
def test_pressure_on_a_curved_side_has_the_resultant_of_its_edge(lattice, cell_type):
    model = assemble(block(lattice, cell_type), STEEL, fixed=None)
    for side in SIDES:
        found = pressure(model, side, 3e5).reshape(-1, 3).sum(axis=0)
        expected = -3e5 * vector_area(model.part, side)
        np.testing.assert_allclose(found, expected, atol=1e-12 * float(np.linalg.norm(expected)))


@pytest.mark.parametrize("cell_type", CELLS)
def test_pressure_all_round_squeezes_evenly_and_a_gradient_lifts(lattice, cell_type):
    # u = -p/(3λ + 2μ) x is the exact answer, which every element holds; the stiffness of elements
    # with curved sides is not integrated exactly.
    model = assemble(block(lattice, cell_type), STEEL, fixed=None)
    (lame, shear), x = STEEL.lame, model.part.points
    f = pressure(model, "all", 1e6)
    bound = {"tetra10": 1e-4, "hexahedron20": 1e-6, "hexahedron27": 1e-6}.get(cell_type, 1e-12)
    squeezed = model.K @ (-1e6 / (3 * lame + 2 * shear) * x).ravel()
    np.testing.assert_allclose(squeezed, f, atol=bound * np.abs(f).max())
    moment = np.cross(x, f.reshape(-1, 3))
    assert np.linalg.norm(moment.sum(axis=0)) < 1e-13 * np.abs(moment).sum()
    lift = pressure(model, "all", 1e6 + 5e4 * x[:, 2]).reshape(-1, 3).sum(axis=0)
    volume = model.M.sum() / 3 / STEEL.rho  # Gauss: -∮ p n dA = -∫ ∇p dV
    accuracy = 1e-12 if cell_type in ("tetra", "tetra10") else 1e-3  # of the mass's own rule
    np.testing.assert_allclose(lift, [0, 0, -5e4 * volume], atol=accuracy * 5e4 * volume)


@pytest.mark.parametrize("cell_type", CELLS)
def test_a_free_body_grows_without_stress(lattice, cell_type):
    model = assemble(block(lattice, cell_type), STEEL, fixed=None)
    grown = 2e-3 * model.part.points
    f = thermal(model, 2e-3)
    np.testing.assert_allclose(model.K @ grown.ravel(), f, atol=1e-13 * np.abs(f).max())
    free = stress(model, grown, 2e-3)
    assert np.abs(free).max() < 1e-12 * STEEL.E * 2e-3
    held = stress(model, 0 * grown, np.full(len(grown), 2e-3))
    lame, shear = STEEL.lame
    np.testing.assert_allclose(held[:, :3], -(3 * lame + 2 * shear) * 2e-3, rtol=1e-12)


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron20", "hexahedron27"])
def test_a_temperature_gradient_bends_a_free_body_without_stress(lattice, cell_type):
    # ε = c·x I is compatible: u_i = (c·x) x_i - c_i |x|²/2, held by straight-sided elements.
    part = lattice((2, 2, 2), lambda p: p * [0.4, 0.3, 0.2], cell_type)
    model = assemble(part, STEEL, fixed=None)
    x, c = part.points, np.array([3e-3, -2e-3, 1e-3])
    u = (x @ c)[:, None] * x - 0.5 * c * np.sum(x**2, axis=1, keepdims=True)
    f = thermal(model, x @ c)
    np.testing.assert_allclose(model.K @ u.ravel(), f, atol=1e-12 * np.abs(f).max())
    assert np.abs(stress(model, u, x @ c)).max() < 1e-11 * STEEL.E * 1e-3


def test_what_acts_on_clamped_nodes_is_left_out(lattice):
    part = block(lattice, "tetra10")
    free = assemble(part, STEEL, fixed=None)
    held = assemble(part, STEEL, fixed="x0")
    rows = held.dofs >= 0
    for load in (
        lambda model: pressure(model, "all", 1e6),
        lambda model: thermal(model, 1e-3),
        lambda model: centrifugal(model, 100.0),
    ):
        assert np.array_equal(load(free).reshape(-1, 3)[rows], load(held)[held.dofs[rows]])


def test_what_does_not_belong_to_a_part_is_refused(lattice):
    model = assemble(block(lattice, "tetra10"), STEEL, fixed=None)
    n = len(model.part.points)
    for call, words in (
        (lambda: pressure(model, "back", 1.0), "no node set 'back'; it has all, x0, x1"),
        (lambda: pressure(model, "x0", np.ones(3)), f"pressure of shape .3,.: needed is .* .{n},."),
        (lambda: pressure(model, "x0", np.nan), "pressure must be finite"),
        (lambda: thermal(model, np.ones((n, 3))), "thermal strain of shape"),
        (lambda: thermal(model, np.inf), "thermal strain must be finite"),
        (lambda: centrifugal(model, np.nan), "speed = nan rad/s: must be finite"),
    ):
        with pytest.raises(InputError, match=words):
            call()
    edge = replace(model.part, node_sets={"edge": np.arange(2)})
    with pytest.raises(InputError, match="no face of the surface has all its nodes in 'edge'"):
        pressure(replace(model, part=edge), "edge", 1.0)
