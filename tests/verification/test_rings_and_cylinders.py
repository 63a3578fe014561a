"""Rings and cylinders, modelled as one sector, at every nodal diameter.

The reference is exact: a hollow cylinder whose ends slide axially and are held in their plane is a
stretch of a standing wave in an endless one, which Bessel functions solve (D. C. Gazis, J. Acoust.
Soc. Am. 31 (1959) 568-578). Theories of thin rings and shells are compared with both.
"""

import dataclasses
import os
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import iv, ivp, jv, jvp, kv, kvp, yv, yvp

from vanelock.fem import Material, assemble, cyclic_transform, eigenpairs, modes

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
FULL = os.environ.get("VANELOCK_VERIFY") == "full"

# Rows and columns of the tractions that belong to motions in the plane, and along the axis, where
# nothing varies along the axis; all of them otherwise.
PARTS = {"plane": ([0, 1, 3, 4], [0, 1, 2, 3]), "axial": ([2, 5], [4, 5]), "solid": (range(6),) * 2}


def potential(square, n, r):
    """Both solutions of f'' + f'/r + (square - n²/r²) f = 0 at r, with two derivatives."""
    s = np.sqrt(np.abs(square))
    for wave, d_wave, fading, d_fading in ((jv, jvp, iv, ivp), (yv, yvp, kv, kvp)):
        f = np.where(square > 0, wave(n, s * r), fading(n, s * r))
        slope = s * np.where(square > 0, d_wave(n, s * r), d_fading(n, s * r))
        yield f, slope, (n * n / r**2 - square) * f - slope / r


def traction_determinant(omega, n, wave, walls, part):
    """Zero where a free motion U cos nθ sin kz, V sin nθ sin kz, W cos nθ cos kz exists.

    u = ∇φ + ∇×(ψ e_z) + ∇×∇×(χ e_z) with two Bessel functions each; the tractions on both walls
    vanish. Columns and rows are scaled by their lengths, which keeps the sign.
    """
    lame, shear = STEEL.lame
    square_p = omega**2 * STEEL.rho / (lame + 2 * shear) - wave**2
    square_s = omega**2 * STEEL.rho / shear - wave**2
    rows = []
    for r in walls:
        columns = []  # U, U', V, V', W, W' of each of the six functions
        for f, d, dd in potential(square_p, n, r):
            columns.append((d, dd, -n * f / r, n * (f / r - d) / r, wave * f, wave * d))
        for f, d, dd in potential(square_s, n, r):
            columns.append((n * f / r, n * (d - f / r) / r, -d, -dd, 0 * f, 0 * f))
        for f, d, dd in potential(square_s, n, r):
            turned = wave * n * f / r, wave * n * (d - f / r) / r
            columns.append((-wave * d, -wave * dd, *turned, square_s * f, square_s * d))
        U, dU, V, dV, W, dW = np.moveaxis(np.array(columns), 1, 0)
        rows.append(lame * (dU + (U + n * V) / r - wave * W) + 2 * shear * dU)
        rows.append(shear * (dV - (V + n * U) / r))
        rows.append(shear * (dW + wave * U))
    matrix = np.moveaxis(np.array(rows)[np.ix_(*PARTS[part])], (0, 1), (-2, -1))
    for axis in (-2, -1):
        matrix = matrix / np.max(np.abs(matrix), axis=axis, keepdims=True)
    return np.linalg.det(matrix)


def exact(n, wave, walls, top, part="solid"):
    """Frequencies below `top` [Hz] of the waves of circumferential order n between two walls."""

    def function(f):
        return traction_determinant(2 * np.pi * f, n, wave, walls, part)

    grid = np.linspace(top / 2000, top, 2000)
    values = function(grid)
    change = np.flatnonzero(values[:-1] * values[1:] < 0)
    found = [brentq(function, grid[i], grid[i + 1], xtol=1e-13 * top) for i in change]
    # Where a potential turns from Bessel's functions to modified ones its columns are dependent;
    # only the twist u_θ ∝ r, which needs no wall, is a motion there.
    lame, shear = STEEL.lame
    twist, pressure = wave * np.sqrt(np.array([shear, lame + 2 * shear]) / STEEL.rho) / (2 * np.pi)
    found = [f for f in found if abs(f - twist) > 1e-6 * f and abs(f - pressure) > 1e-6 * f]
    rigid = (n == 0 and part != "solid") + (n == 1 and part == "plane")
    return found + [0.0] * rigid + [float(twist)] * int(n == 0 and 0 < twist < top)


def held_between_diaphragms(n, walls, length, top):
    """Frequencies of order n of a cylinder whose ends slide axially and are held otherwise."""
    found = exact(n, 0.0, walls, top, "axial")
    for half_waves in range(1, 100):
        more = exact(n, half_waves * np.pi / length, walls, top)
        if not more:
            return found
        found += more
    raise AssertionError("more axial orders below that frequency than were tried")


def seen_by_a_sector(nodal_diameter, sectors, of_order: Callable[[int], list[float]]):
    """Frequencies of all orders that a sector sees as this nodal diameter, ascending.

    A wave of order n and its mirror image make one mode at n and one at N - n; at 0 and N/2 both
    belong to the same problem.
    """
    found = []
    for n in range(2 * sectors):
        if (n - nodal_diameter) % sectors == 0 or (n + nodal_diameter) % sectors == 0:
            twice = n > 0 and 2 * nodal_diameter % sectors == 0
            found += of_order(n) * (2 if twice else 1)
    return np.sort(found)


def cylinder(lattice, counts, walls, length, sectors, cell_type="hexahedron27", curved=True):
    """One sector of a hollow cylinder, and which displacements (nodes, 3) diaphragms would hold."""

    def place(p):
        r, angle = walls[0] + (walls[1] - walls[0]) * p[:, 0], 2 * np.pi / sectors * p[:, 1]
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), length * p[:, 2]])

    part = lattice(counts, place, cell_type, curved, sectors)
    sets = {"left": part.node_sets["y0"], "right": part.node_sets["y1"]}
    held = np.zeros(part.points.shape, bool)
    held[np.concatenate([part.node_sets["z0"], part.node_sets["z1"]]), :2] = True
    return assemble(dataclasses.replace(part, node_sets=sets), STEEL), held


def frequencies(model, held, nodal_diameter, count):
    """Lowest frequencies [Hz] of one sector with some displacements held."""
    T = cyclic_transform(model, nodal_diameter)
    T = T[:, abs(T[model.dofs[held]]).sum(axis=0) == 0]
    K, M = ((T.conj().T @ A @ T).tocsc() for A in (model.K, model.M))
    values, _ = eigenpairs(K, M, count, shift=-1e6)
    return np.sqrt(np.maximum(values, 0)) / (2 * np.pi)


THICK = {"walls": (0.35, 0.5), "length": 0.6, "sectors": 8}


def thick_spectrum(nodal_diameter, top):
    return seen_by_a_sector(
        nodal_diameter,
        THICK["sectors"],
        lambda n: held_between_diaphragms(n, THICK["walls"], THICK["length"], top),
    )


@pytest.mark.slow
@pytest.mark.parametrize("nodal_diameter", range(5) if FULL else (0, 2, 4))
def test_spectrum_of_a_thick_cylinder(lattice, record_property, nodal_diameter):
    reference = thick_spectrum(nodal_diameter, top=6000)
    assert len(reference) >= 6
    model, held = cylinder(lattice, (3, 6, 10), **THICK)
    found = frequencies(model, held, nodal_diameter, len(reference))
    elastic = reference > 0
    error = found[elastic] / reference[elastic] - 1
    np.testing.assert_allclose(found[~elastic], 0, atol=1e-2)
    record_property("frequencies", len(reference))
    record_property("from Hz", f"{reference[elastic].min():.2f}")
    record_property("to Hz", f"{reference.max():.2f}")
    record_property("error", f"{error.min():.1e} to {error.max():.1e}")
    assert np.all(error > 0)  # a conforming mesh is too stiff
    assert error.max() < 3e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cell_type", "walls", "order"),
    [
        ("tetra", "straight", 2),
        ("hexahedron", "straight", 2),
        ("tetra10", "straight", 2),
        ("tetra10", "curved", 4),
        ("hexahedron20", "straight", 2),
        ("hexahedron20", "curved", 4),
        ("hexahedron27", "straight", 2),
        ("hexahedron27", "curved", 4),
    ],
)
def test_frequencies_converge_at_the_order_of_elements_and_walls(
    lattice, record_property, cell_type, walls, order
):
    # At ND 2, the bending of the wall and the axial shear. Chords of the walls leave an error of
    # second order however high that of the element. In the shear it has the sign of the element's
    # own; in bending they pass through zero together, which makes no rate.
    reference = thick_spectrum(2, top=3000)
    assert len(reference) == 2
    linear = cell_type in ("tetra", "hexahedron")
    levels = (3, 4, 5) if linear else (1, 1.5, 2)
    errors = []
    for level in levels:
        counts = [int(level * n) for n in (2, 4, 4)]
        model, held = cylinder(
            lattice, counts, cell_type=cell_type, curved=walls == "curved", **THICK
        )
        errors.append(frequencies(model, held, 2, 2) / reference - 1)
    steps = np.log(np.divide(levels[1:], levels[:-1]))
    rates = np.log(np.abs(np.divide(errors[:-1], errors[1:]))) / steps[:, None]
    for i, name in ((0, "bending"), (1, "shear")):
        record_property(f"{name}: errors", ", ".join(f"{e[i]:.2e}" for e in errors))
        record_property(f"{name}: order", ", ".join(f"{rate:.2f}" for rate in rates[:, i]))
    np.testing.assert_allclose(rates[:, 1], order, atol=0.2)
    if linear or walls == "curved":
        np.testing.assert_allclose(rates[:, 0], order, atol=0.3)


def hoppe(n, radius, thickness):
    """Bending [Hz] of a thin ring in plane strain (Love, Theory of Elasticity, art. 293)."""
    modulus = STEEL.E / (1 - STEEL.nu**2)
    unit = np.sqrt(modulus * thickness**2 / 12 / STEEL.rho) / radius**2 / (2 * np.pi)
    return unit * n * (n**2 - 1) / np.sqrt(n**2 + 1)


def extension(n, radius):
    """Extension [Hz] of a thin ring in plane strain, likewise; n = 0 is breathing."""
    modulus = STEEL.E / (1 - STEEL.nu**2)
    return np.sqrt(modulus / STEEL.rho * (1 + n**2)) / radius / (2 * np.pi)


@pytest.mark.parametrize("nodal_diameter", range(7) if FULL else (0, 3, 6))
def test_ring_in_plane_strain(lattice, record_property, nodal_diameter):
    # The thin ring's own error falls with the square of thickness / radius.
    sectors, radius = 12, 0.5
    difference = []
    for ratio in (0.1, 0.05):
        walls = (radius * (1 - ratio / 2), radius * (1 + ratio / 2))
        top = 1.2 * extension(nodal_diameter, radius)

        def of_order(n, walls=walls, top=top):
            return exact(n, 0.0, walls, top, "plane")

        reference = seen_by_a_sector(nodal_diameter, sectors, of_order)
        model, held = cylinder(lattice, (2, 12, 1), walls, 0.05, sectors)
        held[:] = [False, False, True]
        found = frequencies(model, held, nodal_diameter, len(reference))
        elastic = reference > 0
        error = found[elastic] / reference[elastic] - 1
        np.testing.assert_allclose(found[~elastic], 0, atol=1e-2)
        assert np.all(error > 0)
        assert error.max() < 1e-2  # short waves of the order N - n
        theory = [extension(nodal_diameter, radius)]
        if nodal_diameter > 1:
            theory.append(hoppe(nodal_diameter, radius, ratio * radius))
        own = np.array(of_order(nodal_diameter))
        nearest = np.array([own[np.argmin(np.abs(own - f))] for f in theory])
        difference.append(theory / nearest - 1)
        mine = np.array([found[np.argmin(np.abs(found - f))] for f in nearest])
        np.testing.assert_allclose(mine, nearest, rtol=5e-4)
        for name, target, right, it in zip(
            ("extension", "bending"), theory, nearest, mine, strict=False
        ):
            record_property(
                f"thickness / radius {ratio:g}, {name}",
                f"theory {target:.2f} Hz, exact {right:.2f} Hz ({target / right - 1:+.1e}), "
                f"found {it:.2f} Hz ({it / right - 1:+.1e})",
            )
    assert np.all(np.abs(difference[0]) < [0.01, 0.07][: len(theory)])
    np.testing.assert_allclose(np.log2(np.divide(*difference)), 2, atol=0.1)


def fluegge(n, half_waves, radius, thickness, length):
    """Three frequencies [Hz] of a thin cylindrical shell between diaphragms.

    W. Flügge's equations as given by A. W. Leissa, Vibration of Shells, NASA SP-288 (1973), ch. 2,
    with u = A cos λs cos nθ, v = B sin λs sin nθ, w = C sin λs cos nθ, s = x / R.
    """
    nu, wave, k = STEEL.nu, half_waves * np.pi * radius / length, (thickness / radius) ** 2 / 12
    S = np.zeros((3, 3))
    S[0, 0] = wave**2 + (1 - nu) / 2 * n**2 * (1 + k)
    S[0, 1] = S[1, 0] = -(1 + nu) / 2 * wave * n
    S[0, 2] = S[2, 0] = -(nu * wave + k * (wave**3 - (1 - nu) / 2 * wave * n**2))
    S[1, 1] = n**2 + (1 - nu) / 2 * wave**2 * (1 + 3 * k)
    S[1, 2] = S[2, 1] = n + k * (3 - nu) / 2 * wave**2 * n
    S[2, 2] = 1 + k * ((wave**2 + n**2) ** 2 + 1 - 2 * n**2)
    unit = np.sqrt(STEEL.E / (STEEL.rho * (1 - nu**2))) / radius / (2 * np.pi)
    return unit * np.sqrt(np.linalg.eigvalsh(S))


@pytest.mark.slow
@pytest.mark.parametrize("nodal_diameter", range(7) if FULL else (0, 3, 6))
def test_thin_shell_between_diaphragms(lattice, record_property, nodal_diameter):
    sectors, radius, length = 12, 0.5, 1.0
    difference = []
    for ratio in (0.1, 0.05):
        thickness = ratio * radius
        walls = (radius - thickness / 2, radius + thickness / 2)

        def of_theory(n, thickness=thickness):
            return [fluegge(n, m, radius, thickness, length)[0] for m in (1, 2, 3)]

        theory = seen_by_a_sector(nodal_diameter, sectors, of_theory)[:2]

        def of_solid(n, walls=walls, top=1.01 * theory[-1]):
            return held_between_diaphragms(n, walls, length, top)

        reference = seen_by_a_sector(nodal_diameter, sectors, of_solid)
        reference = reference[reference > 0][:2]
        model, held = cylinder(lattice, (2, 8, 8), walls, length, sectors)
        found = frequencies(model, held, nodal_diameter, 3)
        found = found[found > 1][:2]
        np.testing.assert_allclose(found, reference, rtol=2e-3)
        assert np.all(found > reference)
        difference.append(theory[0] / reference[0] - 1)
        record_property(
            f"thickness / radius {ratio:g}",
            f"Flügge {theory[0]:.2f} Hz, exact {reference[0]:.2f} Hz ({difference[-1]:+.1e}), "
            f"found {found[0]:.2f} Hz ({found[0] / reference[0] - 1:+.1e})",
        )
    assert abs(difference[0]) < 0.07
    assert 1.7 < np.log2(difference[0] / difference[1]) < 4  # thickness squared, or better


@pytest.mark.parametrize("nodal_diameter", range(9) if FULL else (0, 2, 8))
def test_thin_ring_of_square_section(lattice, record_property, nodal_diameter):
    # Love, Theory of Elasticity, art. 293, inextensible ring: in its plane
    # n² (n² - 1)² / (n² + 1), out of it n² (n² - 1)² / (n² + EI / GJ).
    sectors, radius, n = 16, 0.5, nodal_diameter
    torsion = STEEL.E / 12 / (STEEL.lame[1] * 0.140577)  # EI / GJ of a square
    difference = []
    for side in (0.04, 0.02):

        def arc(p, side=side):
            angle = 2 * np.pi / sectors * p[:, 1]
            r = radius + side * (p[:, 0] - 0.5)
            return np.column_stack([r * np.cos(angle), r * np.sin(angle), side * (p[:, 2] - 0.5)])

        part = lattice((4, 20, 4), arc, "hexahedron20", curved=True, sectors=sectors)
        sets = {"left": part.node_sets["y0"], "right": part.node_sets["y1"]}
        model = assemble(dataclasses.replace(part, node_sets=sets), STEEL)
        unit = np.sqrt(STEEL.E * side**2 / 12 / STEEL.rho) / radius**2 / (2 * np.pi)
        found = modes(model, 4, n)
        rigid = {0: 2, 1: 2}.get(n, 0)  # of a free ring
        assert np.count_nonzero(found.frequency < 1e-3 * unit) == rigid
        if rigid:
            record_property(f"side / radius {side / radius:g}", f"{rigid} rigid motions")
            continue
        bending = n**2 * (n**2 - 1) ** 2
        theory = unit * np.sqrt([bending / (n**2 + torsion), bending / (n**2 + 1)])
        step = 2 if 2 * n == sectors else 1  # each comes twice at N/2
        mine = found.frequency[: 2 * step : step]
        axial = np.sum(np.abs(found.shapes[:, 2]) ** 2, axis=0)
        share = axial / np.sum(np.abs(found.shapes) ** 2, axis=(0, 1))
        assert share[0] > 0.95  # out of the plane
        assert share[step] < 0.05
        difference.append(theory / mine - 1)
        for name, f, d in zip(("out of plane", "in plane"), mine, difference[-1], strict=True):
            record_property(
                f"side / radius {side / radius:g}, {name}", f"found {f:.3f} Hz, theory {d:+.1e}"
            )
    if difference:
        assert np.all(np.abs(difference[1]) < 4e-4 * n**2)
        np.testing.assert_allclose(np.log2(np.divide(*difference)), 2, atol=0.25)
