"""Time integration of raw matrices with friction contacts, in plain NumPy: no wave, no reduction.

Newmark's average acceleration; the contacts' forces at the end of a step follow from their law by
fixed-point iteration, on the flexibility that the step leaves them.
"""

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def modal_damping(K: Floats, M: Floats, ratio: float, count: int = 12) -> Floats:
    """(n, count) F of C = F Fᵀ = Σ 2 ζ ω_j (M V_j)(M V_j)ᵀ of the lowest modes."""
    squared, V = scipy.linalg.eigh(K, M, subset_by_index=[0, count - 1])
    MV = M @ V
    factor: Floats = MV * np.sqrt(2 * ratio * np.sqrt(np.abs(squared)))
    return factor


def springs(B: Floats, k: Floats) -> Floats:
    """Stiffness of all contacts stuck; B (c, 3, n), k (c, 3)."""
    flat = B.reshape(-1, B.shape[-1])
    added: Floats = flat.T @ (k.reshape(-1, 1) * flat)
    return added


def march(
    K: Floats,
    M: Floats,
    B: Floats,
    k: Floats,
    mu: float,
    v0: float,
    force: NDArray[np.complex128] | Floats,
    constant: Floats,
    hertz: float,
    ratio: float,
    periods: int,
    steps: int = 240,
    start: NDArray[np.complex128] | None = None,
) -> Floats:
    """(steps, n) displacement over the last period, from the preloaded state.

    At rest, or as it vibrates by Re(start e^{iωt}).

    B (c, 3, n) takes displacements to (closing, two tangential) of each contact; k (c, 3) N/m;
    the load is Re(force e^{iωt}) + constant.
    """
    c, _, n = B.shape
    flat = B.reshape(-1, n)
    stuck = K + springs(B, k)
    F = modal_damping(stuck, M, ratio)
    mass = sp.csr_array(M)
    omega = 2 * np.pi * hertz
    h = 1 / hertz / steps
    inverse = np.linalg.inv(K + (2 / h) * (F @ F.T) + (4 / h**2) * M)
    across = inverse @ flat.T
    G = flat @ across
    closed = np.zeros((c, 3))
    closed[:, 0] = k[:, 0] * v0
    x = np.linalg.solve(stuck, constant - flat.T @ closed.ravel())
    v, a = np.zeros(n), np.zeros(n)
    if start is not None:
        x, v, a = x + start.real, -omega * start.imag, -(omega**2) * start.real
    slider, last = np.zeros((c, 2)), (k * _with(flat @ x, v0)).ravel()
    kept = np.empty((steps, n))
    for step in range(1, periods * steps + 1):
        load = constant + (force * np.exp(1j * omega * h * step)).real
        inertia = (4 / h**2) * x + (4 / h) * v + a
        free = inverse @ (load + mass @ inertia + F @ (F.T @ ((2 / h) * x + v)))
        open_, guess = flat @ free, last
        for _ in range(300):
            found, moved = _law(_with(open_ - G @ guess, v0), k, mu, slider)
            change = np.abs(found - guess).max()
            guess = found
            if change < 1e-9 * max(1.0, np.abs(found).max()):
                break
        else:
            raise AssertionError(f"the contacts of step {step} do not settle")
        slider, last = moved, guess
        new = free - across @ guess
        speed = (2 / h) * (new - x) - v
        a = (4 / h**2) * (new - x) - (4 / h) * v - a
        x, v = new, speed
        kept[step % steps] = x
    return kept


def _with(displacement: Floats, v0: float) -> Floats:
    found: Floats = displacement.reshape(-1, 3).copy()
    found[:, 0] += v0
    return found


def _law(d: Floats, k: Floats, mu: float, slider: Floats) -> tuple[Floats, Floats]:
    """Forces (3c,) and sliders: n = max(kn v, 0), |t| <= mu n in each direction."""
    normal = np.maximum(k[:, 0] * d[:, 0], 0.0)
    bound = (mu * normal)[:, None]
    trial = k[:, 1:] * (d[:, 1:] - slider)
    friction = np.clip(trial, -bound, bound)
    return np.column_stack([normal, friction]).ravel(), d[:, 1:] - friction / k[:, 1:]


def amplitude(history: Floats, row: Floats) -> float:
    """Half the peak-to-peak of a displacement."""
    return float(np.ptp(history @ row) / 2)
