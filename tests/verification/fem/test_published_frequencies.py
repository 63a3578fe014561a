"""Published benchmarks of natural frequencies, solved with solid elements.

Targets: F. Abbassian, D. J. Dawswell, N. C. Knowles, Selected Benchmarks for Natural Frequency
Analysis, NAFEMS (1987), by the number of the test there. Those of plates are in test_plates.py.
"""

import dataclasses

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import brentq
from scipy.special import spherical_jn, spherical_yn

from tests.verification.conftest import lowest_frequencies
from vanelock.fem import Material, assemble, modes

STEEL = Material(E=200e9, nu=0.3, rho=8000.0)


def test_fv32_cantilevered_tapered_membrane(lattice, compare):
    # Half the thickness, whose middle plane stays plane: plane stress. The targets are those of
    # 16 x 8 eight-node quadrilaterals, not the limit: a finer mesh goes below them, slowly, as
    # the stress at the corners of the clamp is infinite.
    targets = [44.623, 130.03, 162.70, 246.05, 379.90, 391.44]

    def tapered(p):
        x, y, z = p.T
        return np.column_stack([10 * x, (y - 0.5) * (5 - 4 * x), 0.025 * z])

    for n, least, most in ((8, -5e-5, 5e-5), (16, -6e-4, 0.0)):
        part = lattice((2 * n, n, 1), tapered, "hexahedron20")
        found = lowest_frequencies(part, STEEL, 6, z0="z", x0="xy")
        compare(targets, found, least, most, f"target, {2 * n} x {n} elements")


def hinged_beam(n, shear_coefficient):
    """Bending frequency [Hz] of n half waves of Timoshenko's beam, 10 m long and 2 m square."""
    wave, radius2 = n * np.pi / 10, 2.0**2 / 12
    stiffness = STEEL.E * radius2 / STEEL.rho * wave**4
    ratio = STEEL.E / (shear_coefficient * STEEL.lame[1])
    inertia = radius2 * STEEL.rho / (shear_coefficient * STEEL.lame[1])
    omega2 = np.roots([inertia, -(1 + radius2 * wave**2 * (1 + ratio)), stiffness]).min()
    return np.sqrt(omega2) / (2 * np.pi)


def hutchinson_square(nu):
    """Shear coefficient of a square section, J. R. Hutchinson, J. Appl. Mech. 68 (2001) 87-92."""
    n = np.pi * np.arange(1, 50)
    series = 16 * nu**2 / (1 + nu) * np.sum((n - np.tanh(n)) / n**5)
    return -8 / 9 * (1 + nu) / (series - 4 / 45 * (12 + 10 * nu))


@pytest.mark.parametrize(("motion", "targets", "held", "within"), [
    ("flexure", [42.650, 148.15, 283.47], {"y0": "y", "z0": "xy", "x1": "yz"}, 0.007),
    ("torsion", [71.20, 213.61], {"y0": "xz", "z0": "xy"}, 0.001),
    ("extension", [125.00], {"y0": "y", "z0": "z"}, 0.001),
], ids=["flexure", "torsion", "extension"])  # fmt: skip
def test_fv5_deep_simply_supported_beam(lattice, compare, motion, targets, held, within):
    # A quarter of the section, parted by its symmetries. The targets are those of the issue of
    # 1989: Saint-Venant's torsion, a slender rod (the section's contraction lowers the solid) and
    # Timoshenko's beam with Cowper's shear coefficient, which long waves in a solid exceed.
    part = lattice((16, 2, 2), lambda p: p * [10, 1, 1], "hexahedron20")
    end = "x" if motion == "extension" else "yz"
    found = lowest_frequencies(part, STEEL, 3, x0=end, **held)[: len(targets)]
    compare(targets, found, -within, within)
    if motion == "flexure":
        cowper = 10 * (1 + STEEL.nu) / (12 + 11 * STEEL.nu)  # J. Appl. Mech. 33 (1966) 335-340
        np.testing.assert_allclose([hinged_beam(n, cowper) for n in (1, 2, 3)], targets, rtol=2e-4)
        theory = [hinged_beam(n, hutchinson_square(STEEL.nu)) for n in (1, 2, 3)]
        compare(theory, found, 0, 1e-3, "beam with Hutchinson's shear coefficient")


def test_fv41_free_cylinder_vibrates_symmetrically_about_its_axis(lattice, compare):
    # One sector in 64 at nodal diameter 0, without the modes of torsion.
    targets = [243.53, 377.41, 394.11, 397.72, 405.28]

    def place(p):
        r, angle = 1.8 + 0.4 * p[:, 0], 2 * np.pi / 64 * p[:, 1]
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), 10 * p[:, 2]])

    part = lattice((2, 1, 30), place, "hexahedron20", curved=True, sectors=64)
    sets = {"left": part.node_sets["y0"], "right": part.node_sets["y1"]}
    part = dataclasses.replace(part, node_sets=sets)
    found = modes(assemble(part, STEEL), 10, 0)
    angle = np.arctan2(part.points[:, 1], part.points[:, 0])[:, None]
    around = found.shapes[:, 1] * np.cos(angle) - found.shapes[:, 0] * np.sin(angle)
    twisting = np.sum(around**2, axis=0) > 0.5 * np.sum(found.shapes**2, axis=(0, 1))
    symmetric = found.frequency[~twisting]
    assert symmetric[0] < 1e-3  # along the axis
    compare(targets, symmetric[1:6], -5e-4, 5e-4)
    # Torsion is exact in closed form: n half waves of shear along the length.
    torsion = np.array([1, 2]) * np.sqrt(STEEL.lame[1] / STEEL.rho) / 20
    assert found.frequency[twisting][0] < 1e-3
    compare(torsion, found.frequency[twisting][1:3], 0, 1e-4, "torsion, exact")


def breathing_sphere(inner, outer, top):
    """Radial frequencies [Hz] of a free hollow sphere: spherical Bessel functions (Lamb 1882)."""
    lame, shear = STEEL.lame
    speed = np.sqrt((lame + 2 * shear) / STEEL.rho)

    def tractions(f):
        k = 2 * np.pi * f / speed
        matrix = np.empty((2, 2))
        for i, r in enumerate((inner, outer)):
            for j, bessel in enumerate((spherical_jn, spherical_yn)):
                u, slope = bessel(1, k * r), k * bessel(1, k * r, derivative=True)
                matrix[i, j] = (lame + 2 * shear) * slope + 2 * lame * u / r
        return np.linalg.det(matrix)

    grid = np.linspace(top / 600, top, 600)
    change = np.flatnonzero(np.diff(np.sign([tractions(f) for f in grid])))
    return [brentq(tractions, grid[i], grid[i + 1]) for i in change]


def test_fv42_thick_hollow_sphere_breathes(lattice, compare):
    # A pyramid out of the sphere, of which each layer of nodes moves along the radius as one.
    targets = [369.91, 838.03, 1451.2, 2117.0, 2795.8]
    inner, outer, layers = 1.8, 6.0, 24

    def place(p):
        axis = np.column_stack([np.ones(len(p)), np.tan(0.1 * (p[:, 1:] - 0.5))])
        r = inner + (outer - inner) * p[:, :1]
        return r * axis / np.linalg.norm(axis, axis=1, keepdims=True)

    part = lattice((layers, 1, 1), place, "hexahedron27", curved=True)
    model = assemble(part, STEEL)
    r = np.linalg.norm(part.points, axis=1)
    layer = np.rint(2 * layers * (r - inner) / (outer - inner)).astype(int)
    T = np.zeros((model.K.shape[0], 2 * layers + 1))
    T[model.dofs, layer[:, None]] = part.points / r[:, None]
    omega2 = scipy.linalg.eigh(T.T @ model.K @ T, T.T @ model.M @ T, eigvals_only=True)
    found = np.sqrt(omega2[:5]) / (2 * np.pi)
    compare(breathing_sphere(inner, outer, 3000.0), found, 0, 1e-4, "exact")
    compare(targets, found, -2e-4, 2e-4)
