"""Linear limits against the dense equations, damping that of stuck or of open joints."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from vanelock.nonlinear import OPEN, STUCK, System, linear_response
from vanelock.rom import linear_damping
from vanelock.rom.system.system import Force


@pytest.mark.parametrize("joints", ["stuck", "open"])
@pytest.mark.parametrize("closed", ["none", "all", "some"])
@pytest.mark.parametrize("static", [0, 2])
def test_limits_are_those_of_the_dense_equations(
    joints: str,
    closed: str,
    static: int,
    random_system: Callable[..., System],
    first_frequency: Callable[[System], float],
) -> None:
    system, push = random_system(7), Force(np.full(20, 0.3 + 0j), static)
    system = replace(system, damping_joints=joints, force=system.force | {0: push})
    mask = np.full(system.contacts.count, closed == "all")
    mask[::2] |= closed == "some"
    hertz = first_frequency(system) * np.array([0.7, 1.0, 1.01])
    found = linear_response(system, hertz, mask, harmonics=2)
    assert found.converged.all()
    assert np.all(found.state == np.where(mask, STUCK, OPEN))
    k, offset = system.contacts.stiffness[mask].reshape(-1), system.contacts.offset[mask].ravel()
    for h in range(3):
        nd = system.nodal_diameter(h)
        matrices, B = system.at(nd), system.contact_rows(nd)[mask].reshape(-1, 20)
        C = linear_damping(system, nd)
        for i, omega in enumerate(2 * np.pi * hertz):
            s = h * omega
            dynamic = matrices.K + (B.conj().T * k) @ B - s**2 * matrices.M + 1j * s * C
            force = system.force[h].at(omega) if h in system.force else np.zeros(20)
            if h == 0:
                force = force - B.conj().T @ (k * offset)
            x = np.linalg.solve(dynamic, force)
            np.testing.assert_allclose(found.x[h][i], x, atol=1e-8 * max(np.abs(x).max(), 1e-300))
            u = (system.contact_rows(nd).reshape(-1, 20) @ x).reshape(-1, 3)
            u = u + system.contacts.offset if h == 0 else u
            np.testing.assert_allclose(found.contact[i, h], u, atol=1e-8 * np.abs(u).max() + 1e-300)
