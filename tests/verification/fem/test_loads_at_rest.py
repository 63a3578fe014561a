"""Loads at rest against theory: heat in a thick cylinder, rotation, pressure on a plate."""

import os
from itertools import pairwise

import numpy as np
import pytest

from vanelock.fem import Material, assemble, centrifugal, factorise, pressure, stress, thermal

FULL = os.environ.get("VANELOCK_VERIFY") == "full"
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
CELLS = ["tetra10", "hexahedron20", "hexahedron27"]


def solved(model, load, **held):
    """Displacements (nodes, 3), m, with components of node sets held: x0="x", and so on."""
    free = np.ones(model.dofs.shape, bool)
    for name, axes in held.items():
        free[np.ix_(model.part.node_sets[name], ["xyz".index(axis) for axis in axes])] = False
    rows = np.flatnonzero(free.ravel())
    u = np.zeros(free.size)
    u[rows] = factorise(model.K[rows][:, rows].tocsc()).solve(load[rows])
    return u.reshape(free.shape)


def quarter(lattice, counts, walls, length, cell_type):
    """A quarter of a ring between two walls."""

    def place(p):
        r, t = walls[0] + (walls[1] - walls[0]) * p[:, 0], np.pi / 2 * p[:, 1]
        return np.column_stack([r * np.cos(t), r * np.sin(t), length * p[:, 2]])

    return lattice(counts, place, cell_type, curved=True)


def cylindrical(part, radial, hoop, axial):
    """(nodes, 6) stress from its components along r, θ and z."""
    r = np.hypot(*part.points.T[:2])
    c, s = part.points[:, 0] / r, part.points[:, 1] / r
    xx, yy = radial * c**2 + hoop * s**2, radial * s**2 + hoop * c**2
    return np.column_stack([xx, yy, axial, 0 * r, 0 * r, (radial - hoop) * c * s])


def orders(record_property, counts, errors):
    """Record errors of meshes, each twice as fine as the one before, and return their orders."""
    for n, error in zip(counts, errors, strict=True):
        record_property(f"{n} elements", f"{error:.2e}")
    found = [float(np.log2(a / b)) for a, b in pairwise(errors)]
    record_property("order", ", ".join(f"{order:.2f}" for order in found))
    return found


@pytest.mark.parametrize("cell_type", CELLS)
def test_a_bar_at_one_temperature_grows_by_alpha_t_l(lattice, cell_type, record_property):
    length, growth = 0.3, 12e-6 * 500
    part = lattice((6, 2, 2), lambda p: p * [length, 0.04, 0.02], cell_type)
    model = assemble(part, STEEL, fixed=None)
    u = solved(model, thermal(model, growth), x0="x", y0="y", z0="z")
    error = np.abs(u[part.node_sets["x1"], 0] / (growth * length) - 1).max()
    left = np.abs(stress(model, u, growth)).max() / (STEEL.E * growth)
    record_property("growth", f"{error:.1e}")
    record_property("stress over E α T", f"{left:.1e}")
    assert error < 1e-11
    assert left < 1e-11


@pytest.mark.parametrize("cell_type", CELLS)
def test_heat_flow_through_a_thick_cylinder(lattice, cell_type, record_property):
    # S. Timoshenko and J. N. Goodier, Theory of Elasticity, 2nd ed. 1951, § 135, the ends held:
    # T = T_i ln(b/r)/ln(b/a), stresses by the integrals of T r.
    a, b, growth, nu = 1.0, 2.0, 1e-3, STEEL.nu
    counts, errors = (4, 8, 16) if FULL else (4, 8), []
    for n in counts:
        part = quarter(lattice, (n, n, max(1, n // 3)), (a, b), 0.4, cell_type)
        model = assemble(part, STEEL, fixed=None)
        r = np.hypot(*part.points.T[:2])
        T = growth * np.log(b / r) / np.log(b / a)
        u = solved(model, thermal(model, T), y0="y", y1="x", z0="z", z1="z")

        def moment(r):  # ∫ ln(b/r) r dr from a, over ln(b/a), times the growth
            def primitive(r):
                return r**2 / 4 * (2 * np.log(b / r) + 1)

            return growth * (primitive(r) - primitive(a)) / np.log(b / a)

        all_of_it, scale = moment(b) / (b**2 - a**2), STEEL.E / (1 - nu)
        radial = scale / r**2 * ((r**2 - a**2) * all_of_it - moment(r))
        hoop = scale / r**2 * ((r**2 + a**2) * all_of_it + moment(r) - T * r**2)
        exact = cylindrical(part, radial, hoop, nu * (radial + hoop) - STEEL.E * T)
        errors.append(np.abs(stress(model, u, T) - exact).max() / np.abs(hoop).max())
    assert min(orders(record_property, counts, errors)) > 1.5  # on the way to 2
    assert errors[1] < 0.03


@pytest.mark.parametrize("cell_type", CELLS)
def test_rotating_cylinder(lattice, cell_type, record_property):
    # The same book, § 30, for plane strain: ν/(1 - ν) in place of ν.
    a, b, speed, nu = 1.0, 2.0, 300.0, STEEL.nu / (1 - STEEL.nu)
    counts, errors = (4, 8, 16) if FULL else (4, 8), []
    for n in counts:
        part = quarter(lattice, (n, n, max(1, n // 3)), (a, b), 0.4, cell_type)
        model = assemble(part, STEEL, fixed=None)
        r = np.hypot(*part.points.T[:2])
        u = solved(model, centrifugal(model, speed), y0="y", y1="x", z0="z", z1="z")
        scale = (3 + nu) / 8 * STEEL.rho * speed**2
        radial = scale * (a**2 + b**2 - (a * b / r) ** 2 - r**2)
        hoop = scale * (a**2 + b**2 + (a * b / r) ** 2 - (1 + 3 * nu) / (3 + nu) * r**2)
        exact = cylindrical(part, radial, hoop, STEEL.nu * (radial + hoop))
        errors.append(np.abs(stress(model, u) - exact).max() / hoop.max())
    assert min(orders(record_property, counts, errors)) > 1.5
    assert errors[1] < 0.02


@pytest.mark.parametrize("cell_type", CELLS)
def test_thin_rotating_ring(lattice, cell_type, record_property):
    # ρ Ω² r², exactly the mean over the wall of ρ Ω² (b³ - a³) / 3 (b - a).
    a, b, speed = 0.499, 0.501, 400.0
    part = quarter(lattice, (1, 160, 1), (a, b), 0.004, cell_type)
    model = assemble(part, STEEL, fixed=None)
    u = solved(model, centrifugal(model, speed), y0="y", y1="x", z0="z")
    hoop = stress(model, u)[part.node_sets["y1"], 0]  # at θ = 90°, x is the hoop direction
    inner, middle, outer = (
        hoop[np.abs(part.points[part.node_sets["y1"], 1] - r) < 1e-9].mean()
        for r in (a, 0.5 * (a + b), b)
    )
    mean = (inner + 4 * middle + outer) / 6
    expected = STEEL.rho * speed**2 * (b**3 - a**3) / (3 * (b - a))
    thin = STEEL.rho * speed**2 * 0.5**2
    record_property("of ρ Ω² r²", f"{mean / thin:.6f}")
    record_property("error of the mean", f"{mean / expected - 1:.1e}")
    assert abs(mean / expected - 1) < 1e-4
    assert np.abs(hoop / thin - 1).max() < 4e-3  # (b - a)/r, over the wall


def test_clamped_round_plate_under_pressure(lattice, record_property):
    # p a⁴/(64 D), to which shear adds p a²/(4 κ G h), κ = 5/6: less in a solid, whose clamp holds
    # the edge's thickness too (S. Timoshenko and S. Woinowsky-Krieger, Theory of Plates and Shells,
    # 2nd ed. 1959, §§ 17 and 20).
    a, p, n = 1.0, 1e5, 16 if FULL else 8
    more = []
    for h in (0.1, 0.05):

        def place(q, h=h):  # a square onto a quarter of a disc
            x, y = q[:, 0], q[:, 1]
            flat = x * np.sqrt(1 - y**2 / 2), y * np.sqrt(1 - x**2 / 2)
            return np.column_stack([a * flat[0], a * flat[1], h * q[:, 2]])

        part = lattice((n, n, 2), place, "hexahedron27", curved=True)
        model = assemble(part, STEEL, fixed=None)
        load = pressure(model, "z1", p)
        u = solved(model, load, x0="x", y0="y", x1="xyz", y1="xyz")
        middle = np.intersect1d(part.node_sets["x0"], part.node_sets["y0"])
        D = STEEL.E * h**3 / 12 / (1 - STEEL.nu**2)
        more.append(-u[middle, 2].mean() / (p * a**4 / (64 * D)) - 1)
        record_property(f"of p a⁴/64D at h/a = {h:g}", f"{1 + more[-1]:.5f}")
        shear = 16 * D / (5 / 6 * STEEL.lame[1] * h * a**2)
        assert 0 < more[-1] < shear
        area = load.reshape(-1, 3).sum(axis=0) / (p * np.pi * a**2 / 4)
        np.testing.assert_allclose(area, [0, 0, -1], atol=1e-6)
    assert more[1] < 0.3 * more[0] < 0.012
