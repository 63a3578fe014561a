"""Contacts far stiffer than what they join are rigid links; and what the whole balance notices."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from vanelock.nonlinear import (
    Contact,
    Options,
    System,
    audit_response,
    frequency_response,
    linear_response,
    stuck_modes,
)

K = np.array([[30.0, -5.0], [-5.0, 20.0]])
ZETA = 0.01


def linked(kt: float, damping: str) -> System:
    """Two masses of 1 kg on springs, which a stuck contact joins."""
    system = System.from_matrices(
        M=np.eye(2),
        K=K,
        contacts=[Contact(tangential=(1, 0), kt=kt, mu=0.5, preload=1e3)],
        damping_ratio=ZETA,
        force={1: 1.0},
        static_force={0: -3.0},
    )
    return replace(system, damping_joints=damping)


@pytest.mark.parametrize("kt", [1e10, 1e13, 1e16, 1e18, 1e30])
@pytest.mark.parametrize("damping", ["open", "stuck"])
def test_a_far_stiffer_contact_is_a_rigid_link(kt: float, damping: str) -> None:
    """Both masses then are one, 2 kg on 40 N/m; forces lost in rounding are no solution."""
    system = linked(kt, damping)
    response = frequency_response(system, [0.5], Options(harmonics=1))
    if damping == "stuck" or kt <= 1e16:
        np.testing.assert_allclose(response.x[0][0], -3 / 40, rtol=1e-8)
    s = 2 * np.pi * 0.5
    c = 2 * ZETA * (la.sqrtm(K).sum() if damping == "open" else np.sqrt(2 * 40.0))
    exact = 1 / abs(40 - 2 * s**2 + 1j * s * c)
    np.testing.assert_allclose(np.abs(response.x[1][0]), exact, rtol=1e-8)
    if response.converged[0] and kt <= 1e16:  # beyond, rounding is all that an audit sees
        checked = audit_response(system, response)
        assert checked.residual[0] < 1e-6 + checked.residual_error[0]


def test_modes_that_are_not_those_of_the_matrices_are_noticed() -> None:
    system = linked(30.0, "open")
    assert linear_response(system, [0.5]).residual.max() < 1e-14
    modes = stuck_modes(system, 0)
    wrong = {0: replace(modes, shapes=modes.shapes * [1.0, 1 + 1e-4])}
    for response in (linear_response(system, [0.5], modes=wrong),
                     frequency_response(system, [0.5], Options(1), modes=wrong)):  # fmt: skip
        assert 1e-6 < response.residual[0] < 1e-3
        assert not response.converged[0]
