"""Stresses and strain gauges against theory, and those of a reduced model against the unreduced."""

from functools import lru_cache

import numpy as np
import pytest

from tests.conftest import FULL
from tests.verification.fem.rings import COUNTS, cylindrical, orders, quarter, solved
from tests.verification.vane import DIMENSIONS
from vanelock import fem, mesh, rom
from vanelock.fem import Material, assemble, factorise, gauge, pressure, stress
from vanelock.stages.parts.segment import Segment


def lame_error(lattice, cell_type, n, warp):
    """Largest nodal stress error of a quarter of a thick cylinder under inner pressure 1."""
    a, b, nu = 1.0, 2.0, 0.3
    part = quarter(lattice, (n, n, max(1, n // 3)), (a, b), 0.4, cell_type, warp)
    model = assemble(part, Material(E=1.0, nu=nu, rho=1.0), fixed=None)
    u = solved(model, pressure(model, "x0", 1.0), y0="y", y1="x", z0="z", z1="z")
    r, A = np.hypot(*part.points.T[:2]), a**2 / (b**2 - a**2)
    radial, hoop = A * (1 - (b / r) ** 2), A * (1 + (b / r) ** 2)
    exact = cylindrical(part, radial, hoop, 2 * nu * A)
    return np.abs(stress(model, u) - exact).max() / hoop.max()


@pytest.mark.parametrize("warp", [0.0, 0.05], ids=["regular", "distorted"])
@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron20", "hexahedron27"])
def test_stress_of_a_thick_cylinder_converges_with_the_square_of_the_size(
    lattice, cell_type, warp, record
):
    # Lamé's solution in plane strain, largest error of any component at any node.
    errors = [lame_error(lattice, cell_type, n, warp) for n in COUNTS]
    found = orders(record, errors)
    assert errors[1] < 0.02
    assert min(found) > 1.5  # on the way to 2
    assert found[-1] > (1.75 if FULL else 1.5)


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron20", "hexahedron27"])
def test_gauge_on_a_cantilever(lattice, cell_type, record):
    # Tip force F on length L, width b, height h: strain 6 F (L - x) / (E b h²) on the upper side,
    # -ν of it across, away from the clamp and the force's ends.
    L, b, h, E, nu, F = 0.3, 0.02, 0.01, 200e9, 0.3, 50.0
    # Displacements are cubic: serendipity and Lagrange bricks nearly hold them, tetrahedra do not.
    counts = (48, 4, 4) if cell_type == "tetra10" else (24, 2, 2)
    part = lattice(counts, lambda p: p * [L, b, h], cell_type)
    model = assemble(part, Material(E, nu, 7800.0), fixed="x0")
    load = np.zeros(model.K.shape[0])
    tip = model.rows("x1")[:, 2]
    load[tip] = F / len(tip)
    u = model.field(factorise(model.K).solve(load))
    worst = {"along": 0.0, "across": 0.0}
    for x in (0.09, 0.13, 0.2) if FULL else (0.13,):
        expected = -6 * F * (L - x) / (E * b * h**2)
        for name, direction, factor in (("along", [1, 0, 0], 1), ("across", [0, 1, 0], -nu)):
            found = gauge(part, [x, 0.4 * b, h], direction, length=2e-3).strain(u)
            worst[name] = max(worst[name], abs(found / (factor * expected) - 1))
    for name, error in worst.items():
        record(f"error {name}", f"{error:.1e}")
    assert max(worst.values()) < (5e-3 if cell_type == "tetra10" else 1e-4)


@pytest.fixture(scope="module")
def reduced(scene):
    """Function that reduces vane and casing with a number of modes, once for each."""
    of_vane, of_casing = (tuple(part.masters.node_sets) for part in (scene.vane, scene.casing))

    @lru_cache
    def reduce(modes):
        casing = rom.reduce(scene.casing_model, of_casing, modes, nodal_diameters=[1])
        return rom.reduce(scene.vane_model, of_vane, modes), casing

    return reduce


MODES = [("free", 5), ("closed", 5), ("closed", 40)]


@pytest.mark.parametrize(("interlock", "modes"), MODES if FULL else MODES[:2])
def test_strains_of_the_reduced_vane_are_those_of_the_unreduced(
    scene, reduced, interlock, modes, record
):
    # Second mode of ND 1, both models' shapes mass-normalised; the phase is free. By Rayleigh's
    # quotient the squared error of the stresses, in energy, is the error of ω².
    vane, casing = scene.vane_model, scene.casing_model
    frequency, vectors = scene.truth(1, interlock)
    blade, other = reduced(modes)
    system = Segment(scene.joints, 1, force=30.0).join(blade, other)
    closed = ~scene.interlock if interlock == "free" else None
    found, shapes = rom.linear_modes(system, 1, 2, closed)
    of_frequency = found[1] / frequency[1] - 1
    T = fem.cyclic_transform(casing, 1)
    shell = casing.field(T @ vectors[: T.shape[1], 1])
    keys = vane.part.node_sets["key"]
    merged = vane.dofs[keys].ravel()
    x = np.zeros(vane.K.shape[0], complex)
    x[np.setdiff1d(np.arange(len(x)), merged)] = vectors[T.shape[1] :, 1]
    x[merged] = shell[casing.part.node_sets["key"]].ravel()
    truth = vane.field(x)
    recovery = rom.recovery(blade, vane)
    q = system.at(1).split(shapes[:, 1])["vane"]
    u = recovery.displacement(q, 1)
    phase = np.vdot(u, truth) / abs(np.vdot(u, truth))

    placed, dimensions = [], mesh.VaneDimensions() if FULL else DIMENSIONS
    for span in (0.05, 0.95):
        for aerofoil in range(1, 5):
            spot = mesh.on_aerofoil(dimensions, 16, aerofoil, span, 0.5)
            one = gauge(vane.part, spot.position, spot.direction, 2e-3, spot.normal)
            placed.append((one.strain(truth), phase * (recovery.rows(one.row, 1)[0] @ q)))
    expected, reduced = np.array(placed).T
    of_gauges = np.abs(reduced - expected).max() / np.abs(expected).max()
    s, exact = phase * recovery.stress(q, 1), stress(vane, truth)
    of_field = np.linalg.norm(s - exact) / np.linalg.norm(exact)
    record("gauges", f"{of_gauges:.1e} of the largest strain")
    record("stress at nodes, rms", f"{of_field:.1e}")
    record("frequency", f"{of_frequency:.1e}")
    assert of_frequency > 0
    assert max(of_gauges, of_field) < np.sqrt(2 * of_frequency)
