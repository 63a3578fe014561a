"""Natural frequencies of the finite-element stage against theory."""

import numpy as np
import pytest
from scipy.optimize import brentq

from vanelock.fem import Material, assemble, eigenpairs, modes

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def timoshenko(material, length, depth, width, clamped, count):
    """Bending frequencies [Hz] of a Timoshenko beam, free at its end and clamped or free at x = 0.

    The spatial equation is integrated exactly: with the state s of deflection, rotation, bending
    moment and shear force, s' = A(ω) s; the free end's moment and force vanish. Shear coefficient
    10 (1 + ν) / (12 + 11 ν) of a rectangle (G. R. Cowper, J. Appl. Mech. 33 (1966) 335-340).
    """
    area, inertia = width * depth, width * depth**3 / 12
    shear = material.lame[1] * area * 10 * (1 + material.nu) / (12 + 11 * material.nu)
    unknown = slice(2, 4) if clamped else slice(0, 2)  # at x = 0

    def free_end(omega):
        A = np.zeros((4, 4))
        A[0, 1], A[0, 3] = 1, 1 / shear
        A[1, 2] = 1 / (material.E * inertia)
        A[2, 3], A[2, 1] = -1, -material.rho * inertia * omega**2
        A[3, 0] = -material.rho * area * omega**2
        values, vectors = np.linalg.eig(A)
        end = (vectors * np.exp(values * length)) @ np.linalg.inv(vectors)
        return np.linalg.det(end[2:, unknown]).real

    unit = np.sqrt(material.E * inertia / (material.rho * area)) / length**2
    omegas = np.linspace(1, 250, 2000) * unit
    signs = [free_end(omega) for omega in omegas]
    steps = zip(omegas, omegas[1:], signs, signs[1:], strict=False)
    roots = [brentq(free_end, a, b) for a, b, fa, fb in steps if fa * fb < 0]
    return np.array(roots[:count]) / (2 * np.pi)


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron20", "hexahedron27"])
@pytest.mark.parametrize("clamped", [True, False], ids=["cantilever", "free"])
def test_slender_block_bends_as_a_timoshenko_beam(lattice, record, cell_type, clamped):
    # A clamped solid cannot contract sideways at the clamp, which no beam knows: there ν = 0.
    material = Material(E=210e9, nu=0.0 if clamped else 0.3, rho=7850.0)
    length, depth, width = 0.5, 0.025, 0.02
    part = lattice((24, 2, 2), lambda p: p * [length, depth, width], cell_type)
    found = modes(assemble(part, material, fixed="x0" if clamped else None), 14)
    elastic = np.arange(0 if clamped else 6, 14)
    along = np.sum(found.shapes[:, :, elastic] ** 2, axis=0)  # (3, modes)
    for axis, (high, wide) in ((1, (depth, width)), (2, (width, depth))):
        exact = timoshenko(material, length, high, wide, clamped, 3)
        root = 3.5160 if clamped else 22.3733  # Euler and Bernoulli's, for the first
        euler = root * np.sqrt(material.E * high**2 / 12 / material.rho) / length**2 / (2 * np.pi)
        assert exact[0] == pytest.approx(euler, rel=0.01)
        mine = elastic[along[axis] > 0.9 * along.sum(axis=0)][:3]
        difference = found.frequency[mine] / exact - 1
        record(f"along {'xyz'[axis]}, solid / beam - 1", ", ".join(f"{d:+.1e}" for d in difference))
        np.testing.assert_allclose(difference, 0, atol=3e-3)


def test_bar_vibrates_along_its_axis_as_a_rod(lattice, record):
    # Without lateral contraction sin((2n - 1) π x / 2L) solves the solid exactly, and quadratic
    # elements of length h with consistent mass raise its frequency by (kh)⁴ / 1440 (dispersion of
    # the one-dimensional element, leading term).
    material = Material(E=70e9, nu=0.0, rho=2700.0)
    length, n = 0.4, 12
    part = lattice((n, 1, 1), lambda p: p * [length, 0.02, 0.02], "hexahedron27")
    found = modes(assemble(part, material, fixed="x0"), 30)
    energy = np.sum(found.shapes**2, axis=0)
    axial = np.flatnonzero(energy[0] > 0.99 * energy.sum(axis=0))[:3]
    wave = np.array([1, 3, 5]) * np.pi / (2 * length)
    exact = wave * np.sqrt(material.E / material.rho) / (2 * np.pi)
    error = found.frequency[axial] / exact - 1
    predicted = (wave * length / n) ** 4 / 1440
    for name, values in (("error", error), ("predicted", predicted)):
        record(name, ", ".join(f"{value:.3e}" for value in values))
    np.testing.assert_allclose(error, predicted, rtol=0.03)


def test_free_block_has_six_rigid_motions(lattice, record, below):
    part = lattice((4, 3, 2), lambda p: p * [0.2, 0.1, 0.05] + [1.0, 2.0, -1.0])
    model = assemble(part, STEEL)
    found = modes(model, 8)
    assert np.all(found.frequency[:6] < 1e-5 * found.frequency[6])
    values, _ = eigenpairs(model.K, model.M, 8, shift=-1e6)
    assert np.all(np.abs(values[:6]) < 1e-9 * values[6])
    np.testing.assert_allclose(np.sqrt(values[6:]) / (2 * np.pi), found.frequency[6:], rtol=1e-10)
    # They span translations and rotations: a rigid field has no other part.
    coordinates = np.empty(model.K.shape[0])
    turned = np.cross([0.4, -1.0, 0.7], part.points)
    coordinates[model.dofs] = turned + np.array([0.3, -0.2, 0.5])
    shapes = np.empty((len(coordinates), 6))
    shapes[model.dofs.ravel()] = found.shapes[:, :, :6].reshape(-1, 6)
    share = shapes.T @ model.M @ coordinates
    left = coordinates - shapes @ share
    rest = (left @ model.M @ left) / (coordinates @ model.M @ coordinates)
    record("sixth / first elastic frequency", f"{found.frequency[5] / found.frequency[6]:.1e}")
    below("part of a rigid field outside them, squared", rest, 1e-18)


def lame_error(lattice, cell_type, n):
    """Relative error of the three Lamé modes of a free cube meshed with n boxes a side."""
    part = lattice((n, n, n), cell_type=cell_type)
    material = Material(E=1.0, nu=0.3, rho=1.0)
    model = assemble(part, material)
    exact = 2 * np.pi**2 * material.lame[1]  # ω² of curl(cos πx cos πy e_z): shear, no pressure
    values, vectors = eigenpairs(model.K, model.M, 24, shift=-0.01)
    x, y, z = np.pi * part.points.T
    zero = np.zeros_like(x)
    fields = [
        [-np.cos(x) * np.sin(y), np.sin(x) * np.cos(y), zero],
        [zero, -np.cos(y) * np.sin(z), np.sin(y) * np.cos(z)],
        [np.sin(z) * np.cos(x), zero, -np.cos(z) * np.sin(x)],
    ]
    lame = np.empty((len(vectors), 3))
    lame[model.dofs.ravel()] = np.array(fields).transpose(2, 1, 0).reshape(-1, 3)
    gram = np.linalg.cholesky(lame.T @ model.M @ lame)
    share = np.linalg.solve(gram, lame.T @ model.M @ vectors)  # of each mode in those fields
    share = np.sum(share**2, axis=0)
    mine = np.argsort(share)[-3:]
    assert np.all(share[mine] > 0.9)
    return np.sqrt(values[mine] / exact).max() - 1


@pytest.mark.parametrize(("cell_type", "order", "sides", "finest"), [
    ("tetra", 2, (8, 11, 14), 0.06), ("hexahedron", 2, (6, 9, 12), 0.03),
    ("tetra10", 4, (4, 6, 8), 1e-3), ("hexahedron20", 4, (3, 4, 6), 3e-4),
    ("hexahedron27", 4, (3, 4, 6), 3e-4),
])  # fmt: skip
def test_frequency_of_the_cube_converges_at_the_order_of_its_elements(
    lattice, record, cell_type, order, sides, finest
):
    # The Lamé modes of a free cube are known in closed form for any Poisson's ratio, and smooth.
    errors = [lame_error(lattice, cell_type, n) for n in sides]
    rates = -np.diff(np.log(errors)) / np.diff(np.log(sides))
    record("boxes a side", ", ".join(map(str, sides)))
    record("error", ", ".join(f"{error:.2e}" for error in errors))
    record("order", ", ".join(f"{rate:.2f}" for rate in rates))
    assert order - 0.4 < rates[-1] < order + 0.05  # from below: the meshes are still coarse
    assert abs(rates[-1] - order) < abs(rates[0] - order)  # and nearer with each
    assert 0 < errors[-1] < finest  # and the frequency from above: a conforming mesh is too stiff
