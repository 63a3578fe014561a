"""A part of another modulus: scaled, and reduced again, by every route."""

import numpy as np
import pytest
import scipy.linalg as sl

from vanelock import fem, rom
from vanelock.common.errors import InputError

N = 8
FACTOR = 0.71
ROUTES = [
    {},
    {"modes": 6},
    {"accuracy": 1e-3},
    {"modes": 6, "route": "paper", "interface_modes": 5},
]


def hotter(model):
    """The model assembled anew with another modulus."""
    metal = model.material
    fixed = "z0" if "z0" in model.part.node_sets and (model.dofs < 0).any() else None
    softer = fem.Material(FACTOR * metal.E, metal.nu, metal.rho)
    return fem.assemble(model.part, softer, fixed=fixed)


def answers(component, k):
    """What no choice of basis changes: frequencies, Hz, and the masters' dynamic compliance.

    The compliance is that of springs at the masters, at three frequencies.
    """
    reduced, first = component.at(k), component.interface_modes
    masters = slice(first, first + 3 * len(component.masters.nodes))
    squared = sl.eigvalsh(reduced.K, reduced.M)
    K = np.array(reduced.K)
    K[masters, masters] += 1e8 * np.eye(masters.stop - masters.start)
    found = []
    for ratio in (0.0, 0.3, 1.1):
        D = K - ratio * squared[7] * reduced.M
        found.append(np.linalg.inv(D)[masters, masters])
    return np.sqrt(squared.clip(0)) / (2 * np.pi), np.array(found)


def same(a, b, k):
    (f, x), (g, y) = answers(a, k), answers(b, k)
    np.testing.assert_allclose(f, g, rtol=1e-8, atol=1e-6 * f[-1])
    np.testing.assert_allclose(x, y, rtol=0, atol=1e-8 * np.abs(x).max())


@pytest.mark.parametrize("options", ROUTES, ids=str)
def test_a_sector_reduced_again_is_the_same(ring_sector, options):
    """At real and complex nodal diameters, by every route and choice of vectors."""
    model, diameters = ring_sector(sectors=N), (0, 1, N // 2)
    scaled = rom.stiffened(
        rom.reduce(model, ("force",), nodal_diameters=diameters, **options), FACTOR
    )
    again = rom.reduce(hotter(model), ("force",), nodal_diameters=diameters, **options)
    assert scaled.size == again.size
    for k in (*diameters, N - 1):
        same(scaled, again, k)
    if again.band is not None:
        assert scaled.band == pytest.approx(again.band, rel=1e-3)  # of rough modes
    if again.at(1).complete is not None:
        assert scaled.at(1).complete == pytest.approx(again.at(1).complete, rel=1e-8)


def test_what_is_left_out_scales_too(ring_sector):
    """ε = qᴴ (G₀ - θ G₁ + θ² G₂) q at the reduced modes, of the part reduced again."""
    model = ring_sector(sectors=N)
    scaled, again = (
        rom.reduce(each, ("force",), 4, nodal_diameters=[1]) for each in (model, hotter(model))
    )
    scaled = rom.stiffened(scaled, FACTOR)
    left = []
    for part in (scaled, again):
        reduced = part.at(1)
        theta, q = sl.eigh(reduced.K, reduced.M)
        G = [np.einsum("ij,ik,kj->j", q.conj(), each, q).real for each in reduced.neglected]
        left.append(G[0] - theta * G[1] + theta**2 * G[2])
    assert left[0][:8].max() > 0
    np.testing.assert_allclose(left[0], left[1], rtol=1e-7, atol=1e-9 * left[1].max())


@pytest.mark.parametrize("options", [{}, {"modes": 5}, {"cutoff": 3000.0}], ids=str)
def test_a_part_in_one_piece(bar, options):
    model = bar()
    given = dict(options)
    scaled = rom.stiffened(rom.reduce(model, ("held",), **given), FACTOR)
    if "cutoff" in given:
        given["cutoff"] *= FACTOR**0.5
    same(scaled, rom.reduce(hotter(model), ("held",), **given), 0)


def test_recovered_shapes_stay(ring_sector):
    """The same coordinates are the same displacements of the hotter part, at s times the stress."""
    model = ring_sector(sectors=N)
    part = rom.reduce(model, ("force",), 6, nodal_diameters=[1])
    q = np.random.default_rng(1).standard_normal(part.size) + 0j
    cold, hot = (
        rom.recovery(each, other)
        for each, other in ((part, model), (rom.stiffened(part, FACTOR), hotter(model)))
    )
    u = cold.displacement(q, 1)
    np.testing.assert_allclose(hot.displacement(q, 1), u, atol=1e-9 * np.abs(u).max())
    stress = cold.stress(q, 1)
    expected = FACTOR * stress
    np.testing.assert_allclose(hot.stress(q, 1), expected, atol=1e-9 * np.abs(stress).max())


@pytest.mark.parametrize("factor", [0.0, -1.0, np.inf, np.nan])
def test_a_factor_that_is_none(bar, factor):
    with pytest.raises(InputError, match="factor = .*: Young's modulus must stay > 0"):
        rom.stiffened(rom.reduce(bar(), ("held",), 3), factor)
