"""Inertia forces of static answers at nodal diameters, against dense elimination."""

import numpy as np
import pytest

from vanelock import rom
from vanelock.rom.routes.condensed import _at_diameter


@pytest.mark.parametrize("order", [(0, 1, 3, 4), (4, 3, 1, 0)], ids=["up", "down"])
def test_real_motions_answer_for_every_nodal_diameter(ring_sector, exact, order):
    """What earlier diameters left is used again, and more is added to it."""
    model = ring_sector()
    shared = rom.prepare(model, ("force",))
    for k in order:
        part = _at_diameter(shared, k)
        K, M, rows = exact.dense(model, "force", k)
        rest = np.setdiff1d(np.arange(len(K)), rows)
        Psi = -np.linalg.solve(K[np.ix_(rest, rest)], K[np.ix_(rest, rows)])
        L = M[np.ix_(rest, rows)] + M[np.ix_(rest, rest)] @ Psi
        mass = M[np.ix_(rows, rows)] + M[np.ix_(rows, rest)] @ Psi + Psi.conj().T @ L
        compliance = L.conj().T @ np.linalg.solve(K[np.ix_(rest, rest)], L)
        np.testing.assert_allclose(part.M_mm, mass, atol=1e-11 * abs(mass).max())
        np.testing.assert_allclose(part.compliance, compliance, atol=1e-10 * abs(compliance).max())

        # L, and the mass of what is not held, in the order of the sector's own coordinates.
        T = shared.transform(k)
        M_ss, rng = T.conj().T @ model.M @ T, np.random.default_rng(k)
        x = rng.standard_normal((T.shape[1], 3)) + 1j * rng.standard_normal((T.shape[1], 3))
        size = abs(M_ss.diagonal()).max()
        np.testing.assert_allclose(part.M_ss @ x, M_ss @ x, atol=1e-12 * size)
        np.testing.assert_allclose(part.M_ss.diagonal(), M_ss.diagonal(), atol=1e-12 * size)
        assert part.M_ss.shape == M_ss.shape
        u = rom.recovery(rom.reduce(model, ("force",), 0, [k]), model).displacement(
            np.eye(len(rows)), k
        )
        free = u[model.dofs[:, 0] >= 0].reshape(model.K.shape[0], -1)
        pushed = T.conj().T @ (model.M @ free)
        unit = np.eye(len(rows))
        np.testing.assert_allclose(part.inertia.push(unit), pushed, atol=1e-10 * size)
        np.testing.assert_allclose(part.inertia.gather(x), pushed.conj().T @ x, atol=1e-9 * size)


def test_motions_that_differ_by_little_stay_apart(ring_sector):
    """What is left of a motion that is nearly known is small, and of unit length in the basis."""
    shared = rom.prepare(ring_sector(), ("force",))
    rng = np.random.default_rng(0)
    moved = rng.standard_normal((shared.faces, len(shared.problem.rows)))
    other = rng.standard_normal(moved.shape)
    other[:, 1::2] = other[:, ::2] + 1e-11 * other[:, 1::2]  # hard to distinguish
    for changed in (moved, other):
        found = shared.answers.at(changed)
        U = shared.answers._motions
        np.testing.assert_allclose(U.T @ U, np.eye(U.shape[1]), atol=1e-13)
        restored = U @ found.coefficients[len(shared.problem.rows) :]
        np.testing.assert_allclose(restored, changed, atol=1e-10)
