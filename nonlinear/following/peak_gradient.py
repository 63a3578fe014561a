"""How a peak changes with the places of the sliders: one linear solution for all of them.

With w = W(u), u = ũ + R̂ w, J = dW/du and P = I - J R̂, an amplitude A that depends on w by g = dA/dw
changes with ũ by

    dA/dũ = Jᵀ y,      Pᵀ y = g.

Sliders assembled at s, m, move the mean of ũ by (R̂₀ - I) s. Those that stick for good count as
held, wherever they first slid to: they may be moved back from there, not on. The frequency of a
peak moves along, which changes nothing to first order.
"""

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.contact.law import STUCK
from vanelock.nonlinear.following.peak import Resonance
from vanelock.nonlinear.forced_response.response import extremes
from vanelock.nonlinear.newton.linearised import newton_matrix
from vanelock.nonlinear.newton.newton import Solution, active_rows

Floats = NDArray[np.float64]


def slider_gradient(resonance: Resonance, solution: Solution) -> Floats | None:
    """dA/ds of the amplitude at a peak, (c, 3); that of the normal direction is zero.

    None where P is singular.
    """
    count, _, m = solution.w.shape
    rows = active_rows(solution.w, solution.deviation)
    rows = rows[solution.deviation.state[rows // (3 * m)] != STUCK]
    if not len(rows):
        return np.zeros((count, 3))
    balance = resonance.family.at(solution.omega)
    form = _amplitude_by_w(resonance, solution).reshape(-1)
    try:
        y = np.linalg.solve(newton_matrix(balance, solution.deviation, rows).T, form[rows])
    except np.linalg.LinAlgError:
        return None
    slopes = solution.deviation.jacobian.reshape(-1, 3, m)[rows, :, 0]  # by the mean of u
    by_mean = np.zeros((count, 3))
    np.add.at(by_mean, rows // (3 * m), y[:, None] * slopes)
    flat = by_mean.reshape(-1)
    found = (balance.columns.all(0).real.T @ flat - flat).reshape(count, 3)
    found[:, 0] = 0.0
    return np.asarray(found)


def _amplitude_by_w(resonance: Resonance, solution: Solution) -> Floats:
    """dA/dw, (c, 3, 2H + 1), of A = (q(θ₁) - q(θ₂)) / 2 at the extremes of the output q."""
    prepared, omega = resonance.structure, solution.omega
    rows = [each[resonance.component] for each in prepared.output_rows]
    amplitudes = prepared.amplitudes(omega, solution.w)
    q = np.array([row @ amplitude for row, amplitude in zip(rows, amplitudes, strict=True)])
    angles = extremes(q[:, None])[:, 0]
    form = np.zeros((len(prepared.stiffness), solution.w.shape[2]))
    for h in range(1, len(rows)):  # the mean counts at both extremes
        modes = prepared.at(h)
        by_w = (rows[h] @ modes.solve(h * omega, modes.pull)) * prepared.stiffness
        by_w *= np.exp(1j * h * angles) @ [0.5, -0.5]
        form[:, 2 * h - 1], form[:, 2 * h] = by_w.real, -by_w.imag
    return form.reshape(solution.w.shape)
