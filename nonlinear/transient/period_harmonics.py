"""What a period of a ring's motion shows: its harmonics, and its outputs."""

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier.trigonometric import TURN
from vanelock.nonlinear.transient.integration import Integrator, Period

Array = NDArray[np.complex128]
Floats = NDArray[np.float64]


def coefficients(history: Floats, harmonics: int) -> Array:
    """One-sided coefficients (H + 1, ...) of samples (s, ...) at the ends of the steps."""
    q: Array = np.fft.rfft(np.roll(history, 1, axis=0), axis=0)[: harmonics + 1] / len(history)
    q[1:] *= 2
    return q


def departure(
    stepped: Integrator, found: Period, output: Floats, response: Response, point: int
) -> float:
    """Largest difference of the harmonics from those of a point of a response."""
    lag = stepped.ring.lag(np.arange(response.harmonics + 1))
    largest = 0.0
    for history, expected in (
        (found.u, response.contact[point]),
        (output, response.output[point]),
    ):
        q = expected.reshape(response.harmonics + 1, 1, -1) * lag[:, :, None]
        if q.size:
            moved = np.abs(coefficients(history, response.harmonics) - q).max()
            largest = max(largest, moved / max(np.abs(q[1:]).max(initial=0), 1e-300))
    return float(largest)


def output_history(stepped: Integrator, found: Period) -> Floats:
    """(s, N, 3o) displacement of the output nodes."""
    whole, n = stepped.ring, stepped.rows.shape[2]
    deviations = stepped.pulling(found.u, found.w, stepped.linear)
    moved = []
    rows = [
        np.zeros((0, len(m.shapes))) if out is None else out.reshape(-1, len(m.shapes)) @ m.shapes
        for m, out in (
            (m, whole.system.at(k).output)
            for k, m in zip(whole.diameters, whole.modes, strict=True)
        )
    ]
    for k, (modes, out) in enumerate(zip(whole.modes, rows, strict=True)):
        near, far = out[:, :n], out[:, n:]
        rigid = far / modes.static[n:] @ modes.rows[:, n:].conj().T * whole.stiffness
        moved.append(found.y[:, k, : near.shape[1]] @ near.T + deviations[k] @ rigid.T)
    history = whole.in_sectors(np.array(moved))
    angles = TURN * np.arange(1, stepped.steps + 1) / stepped.steps
    for h, amplitude in whole.linear(stepped.omega).items():
        k, mirrored = whole.wave(h)
        out = rows[k].conj() if mirrored else rows[k]
        history += whole.travelling(h, out @ amplitude, angles)
    return history
