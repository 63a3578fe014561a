"""Theories of thin rings and shells, modelled as one sector, at every nodal diameter.

Where exact elasticity is known it stands between the two: what the theory leaves out falls with the
square of the thickness, and what is left of the mesh is smaller.
"""

import dataclasses

import numpy as np
import pytest

from tests.conftest import FULL
from tests.verification.conftest import (
    lowest_frequencies,
    seen_by_a_sector,
    waves_between_diaphragms,
    waves_within,
)
from vanelock.fem import Material, assemble, modes

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def hoppe(n, radius, thickness):
    """Bending [Hz] of a thin ring in plane strain (Love, Theory of Elasticity, art. 293)."""
    modulus = STEEL.E / (1 - STEEL.nu**2)
    unit = np.sqrt(modulus * thickness**2 / 12 / STEEL.rho) / radius**2 / (2 * np.pi)
    return unit * n * (n**2 - 1) / np.sqrt(n**2 + 1)


def extension(n, radius):
    """Extension [Hz] of a thin ring in plane strain, likewise; n = 0 is breathing."""
    modulus = STEEL.E / (1 - STEEL.nu**2)
    return np.sqrt(modulus / STEEL.rho * (1 + n**2)) / radius / (2 * np.pi)


@pytest.mark.parametrize("nodal_diameter", range(7) if FULL else (3, 6))
def test_ring_in_plane_strain(hollow_cylinder, record, nodal_diameter):
    # The thin ring's own error falls with the square of thickness / radius.
    sectors, radius = 12, 0.5
    difference = []
    for ratio in (0.1, 0.05):
        walls = (radius * (1 - ratio / 2), radius * (1 + ratio / 2))
        top = 1.2 * extension(nodal_diameter, radius)

        def of_order(n, walls=walls, top=top):
            return waves_within(walls, n, 0.0, top, STEEL, "plane")

        reference = seen_by_a_sector(nodal_diameter, sectors, of_order)
        part = hollow_cylinder((2, 12, 1), walls, 0.05, sectors)
        found = lowest_frequencies(part, STEEL, len(reference), nodal_diameter, body="z")
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
            record(
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


@pytest.mark.parametrize("nodal_diameter", range(7) if FULL else (0, 3))
def test_thin_shell_between_diaphragms(hollow_cylinder, record, nodal_diameter):
    sectors, radius, length = 12, 0.5, 1.0
    difference = []
    for ratio in (0.1, 0.05):
        thickness = ratio * radius
        walls = (radius - thickness / 2, radius + thickness / 2)

        def of_theory(n, thickness=thickness):
            return [fluegge(n, m, radius, thickness, length)[0] for m in (1, 2, 3)]

        theory = seen_by_a_sector(nodal_diameter, sectors, of_theory)[:2]

        def of_solid(n, walls=walls, top=1.01 * theory[-1]):
            return waves_between_diaphragms(walls, n, length, top, STEEL)

        reference = seen_by_a_sector(nodal_diameter, sectors, of_solid)
        reference = reference[reference > 0][:2]
        part = hollow_cylinder((2, 8, 8), walls, length, sectors)
        found = lowest_frequencies(part, STEEL, 3, nodal_diameter, ends="xy")
        found = found[found > 1][:2]
        np.testing.assert_allclose(found, reference, rtol=2e-3)
        assert np.all(found > reference)
        difference.append(theory[0] / reference[0] - 1)
        record(
            f"thickness / radius {ratio:g}",
            f"Flügge {theory[0]:.2f} Hz, exact {reference[0]:.2f} Hz ({difference[-1]:+.1e}), "
            f"found {found[0]:.2f} Hz ({found[0] / reference[0] - 1:+.1e})",
        )
    assert abs(difference[0]) < 0.07
    assert 1.7 < np.log2(difference[0] / difference[1]) < 4  # thickness squared, or better


@pytest.mark.parametrize("nodal_diameter", range(9) if FULL else (2, 8))
def test_thin_ring_of_square_section(lattice, record, nodal_diameter):
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
            record(f"side / radius {side / radius:g}", f"{rigid} rigid motions")
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
            record(f"side / radius {side / radius:g}, {name}", f"found {f:.3f} Hz, theory {d:+.1e}")
    if difference:
        assert np.all(np.abs(difference[1]) < 4e-4 * n**2)
        np.testing.assert_allclose(np.log2(np.divide(*difference)), 2, atol=0.25)
