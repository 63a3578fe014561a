"""The estimates that the program's own is compared with."""

import numpy as np

from benchmarks.mesh import bubbles, error
from vanelock.fem import Material, assemble, eigenpairs


def test_bubbles_vanish_at_nodes_and_have_these_slopes():
    nodes = np.vstack([np.zeros(3), np.eye(3)])
    nodes = np.vstack([nodes, [nodes[list(pair)].mean(axis=0) for pair in bubbles.EDGES]])
    assert np.abs(bubbles.bubbles(nodes)[0]).max() < 1e-15
    place, step = np.array([[0.2, 0.3, 0.1]]), 1e-6
    _, slopes = bubbles.bubbles(place)
    for i, e in enumerate(step * np.eye(3)):
        rise = bubbles.bubbles(place + e)[0] - bubbles.bubbles(place - e)[0]
        np.testing.assert_allclose(rise / (2 * step), slopes[..., i], atol=1e-9)


def test_both_estimate_part_of_the_error_of_a_wave_along_a_box(lattice):
    part = lattice((4, 4, 4), lambda p: p * [1.3, 1.0, 1.0])
    model = assemble(part, Material(E=3.0, nu=0.0, rho=1.0))
    rows = model.dofs[:, 0]
    K, M = (A[rows][:, rows].tocsc() for A in (model.K, model.M))
    squared, shapes = eigenpairs(K, M, 4, shift=-1.0)
    true = squared[3] - 3 * (np.pi / 1.3) ** 2  # after the rigid motion and two waves across
    u = np.zeros((len(part.points), 3, 1))
    u[:, 0, 0] = shapes[:, 3]
    assert 0.6 < bubbles.bubble_excess(model, u, squared[3:])[0] / true < 1
    assert 0 < error.averaged_excess(model, u)[0] / true < 1
