"""Loads at rest against theory: heat in a thick cylinder, rotation, pressure on a plate."""

import numpy as np
import pytest
import scipy.linalg as sl

from tests.conftest import FULL
from tests.verification.fem.rings import COUNTS, cylindrical, orders, quarter, solved
from vanelock.fem import Material, assemble, centrifugal, pressure, stress, thermal
from vanelock.mesh.cells import exterior, nodal_areas, solid
from vanelock.nonlinear import static_response
from vanelock.rom import Contacts, Diameter, Force, System

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
CELLS = ["tetra10", "hexahedron20", "hexahedron27"]


@pytest.mark.parametrize("cell_type", CELLS)
def test_heat_flow_through_a_thick_cylinder(lattice, cell_type, record):
    # S. Timoshenko and J. N. Goodier, Theory of Elasticity, 2nd ed. 1951, § 135, the ends held:
    # T = T_i ln(b/r)/ln(b/a), stresses by the integrals of T r.
    a, b, growth, nu = 1.0, 2.0, 1e-3, STEEL.nu
    errors = []
    for n in COUNTS:
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
    assert min(orders(record, errors)) > 1.5  # on the way to 2
    assert errors[1] < 0.03


@pytest.mark.parametrize("cell_type", CELLS)
def test_rotating_cylinder(lattice, cell_type, record):
    # The same book, § 30, for plane strain: ν/(1 - ν) in place of ν.
    a, b, speed, nu = 1.0, 2.0, 300.0, STEEL.nu / (1 - STEEL.nu)
    errors = []
    for n in COUNTS:
        part = quarter(lattice, (n, n, max(1, n // 3)), (a, b), 0.4, cell_type)
        model = assemble(part, STEEL, fixed=None)
        r = np.hypot(*part.points.T[:2])
        u = solved(model, centrifugal(model, speed), y0="y", y1="x", z0="z", z1="z")
        scale = (3 + nu) / 8 * STEEL.rho * speed**2
        radial = scale * (a**2 + b**2 - (a * b / r) ** 2 - r**2)
        hoop = scale * (a**2 + b**2 + (a * b / r) ** 2 - (1 + 3 * nu) / (3 + nu) * r**2)
        exact = cylindrical(part, radial, hoop, STEEL.nu * (radial + hoop))
        errors.append(np.abs(stress(model, u) - exact).max() / hoop.max())
    assert min(orders(record, errors)) > 1.5
    assert errors[1] < 0.02


@pytest.mark.parametrize("cell_type", CELLS)
def test_thin_rotating_ring(lattice, cell_type, record):
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
    record("of ρ Ω² r²", f"{mean / thin:.6f}")
    record("error of the mean", f"{mean / expected - 1:.1e}")
    assert abs(mean / expected - 1) < 1e-4
    assert np.abs(hoop / thin - 1).max() < 4e-3  # (b - a)/r, over the wall


def test_clamped_round_plate_under_pressure(lattice, record):
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
        record(f"of p a⁴/64D at h/a = {h:g}", f"{1 + more[-1]:.5f}")
        shear = 16 * D / (5 / 6 * STEEL.lame[1] * h * a**2)
        assert 0 < more[-1] < shear
        area = load.reshape(-1, 3).sum(axis=0) / (p * np.pi * a**2 / 4)
        np.testing.assert_allclose(area, [0, 0, -1], atol=1e-6)
    assert more[1] < 0.3 * more[0] < 0.012


def test_a_hot_ring_in_a_cold_one(lattice, record, below):
    # Lamé's shrink fit: δ/b = α ΔT, p = E δ/b (b² - a²)(c² - b²) / (2 b² (c² - a²)), and
    # -2 p b²/(b² - a²) along the bore (S. Timoshenko, Strength of Materials, Part II, § 41).
    # Contacts without friction cannot tell the growth from an interference of α ΔT b.
    a, b, c, growth, length = 0.4, 0.5, 0.58, 4e-4, 0.03
    counts = (4, 12, 1) if FULL else (2, 6, 1)
    rings = [quarter(lattice, counts, walls, length, "hexahedron27") for walls in ((a, b), (b, c))]
    models = [assemble(part, STEEL, fixed=None) for part in rings]
    free = []
    for part, model in zip(rings, models, strict=True):
        moves = np.ones((len(part.points), 3), bool)
        for name, axis in (("y0", 1), ("y1", 0), ("z0", 2)):
            moves[part.node_sets[name], axis] = False
        free.append(np.flatnonzero(moves.ravel()))
        assert model.K.shape[0] == moves.size
    sizes = [len(rows) for rows in free]
    K = sl.block_diag(*(m.K[r][:, r].toarray() for m, r in zip(models, free, strict=True)))
    M = sl.block_diag(*(m.M[r][:, r].toarray() for m, r in zip(models, free, strict=True)))
    inner, outer = rings[0].node_sets["x1"], rings[1].node_sets["x0"]
    place = rings[0].points[inner]
    assert np.allclose(place, rings[1].points[outer])
    radial = place * [1, 1, 0] / b
    own = np.zeros((len(inner), 3, sum(sizes)))
    for sign, start, rows, nodes in ((1, 0, free[0], inner), (-1, sizes[0], free[1], outer)):
        whole = np.zeros((len(nodes), rows.max() + 1))
        np.put_along_axis(whole, 3 * nodes[:, None] + np.arange(2), sign * radial[:, :2], 1)
        own[:, 0, start : start + len(rows)] = whole[:, rows]
    faces = exterior(rings[0].cells, solid("hexahedron27"))
    faces = faces[np.isin(faces, inner).all(axis=1)]
    area = nodal_areas(rings[0].points, faces, inner, radial)
    assert area is not None
    heat = np.zeros(sum(sizes), complex)
    heat[: sizes[0]] = thermal(models[0], growth)[free[0]]

    def pressed(interference, force):
        flat = np.ones(len(inner))
        contacts = Contacts(1e15 * area, np.ones((len(inner), 2)), 0 * flat, interference * flat)
        system = System(1, 1, {0: Diameter(K=K, M=M, own=own)}, contacts, {0: Force(force)})
        rest = static_response(system)
        assert rest.converged.all()
        return rest.x[0][0].real, rest.force[0, 0, :, 0].real

    x, normal = pressed(0.0, heat)
    _, fitted = pressed(growth * b, 0 * heat)
    exact = STEEL.E * growth * (b**2 - a**2) * (c**2 - b**2) / (2 * b**2 * (c**2 - a**2))
    mean = normal.sum() / area.sum() / exact - 1
    u = np.zeros(rings[0].points.size)
    u[free[0]] = x[: sizes[0]]
    hoop = stress(models[0], u.reshape(-1, 3), growth)
    bore = np.intersect1d(rings[0].node_sets["x0"], rings[0].node_sets["y0"])
    along = hoop[bore, 1].mean() / (-2 * exact * b**2 / (b**2 - a**2)) - 1
    same = np.abs(fitted / normal - 1).max()
    record("pressure", f"{mean:.1e}")
    record("stress along the bore", f"{along:.1e}")
    below("by interference instead", same, 1e-9)
    assert abs(mean) < 2e-3
    assert abs(along) < 1e-2
