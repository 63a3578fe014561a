"""What the part of a load that does not drive a mode changes at an amplitude, to first order.

A load f at Ω is the part along the mode, Mφ(φᴴf), and the rest f_r = f - Mφ(φᴴf), which moves the
other modes. With the mode's amplitude held (`held_vibration`) the rest moves the contacts by u_r,
they deviate by dw, and the force along the mode shape that holds the amplitude changes by δΛ:

    P dw = (dW/du) u_r,      P = I - (dW/du) R̂,      δΛ = Λ(f_r) + (∂Λ/∂w) dw.

P is that of the mode's own motion. As friction tells phases apart, all this is linear in the real
and the imaginary part of f_r alone: under f e^{iθ},

    δΛ = α e^{iθ} + β e^{-iθ}.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Structure
from vanelock.nonlinear.balance.held_vibration import Array, Floats, HeldVibration
from vanelock.nonlinear.contact.law import Law
from vanelock.nonlinear.fourier.trigonometric import to_complex, to_real
from vanelock.nonlinear.newton.law_jacobian import response_to
from vanelock.nonlinear.newton.linearised import linearise
from vanelock.nonlinear.newton.newton import active_rows, scales

EXACT = 1e-9
"""Of the linearised contacts where P is large and solved by iteration."""


@dataclass(frozen=True)
class OtherModes:
    """What the rest of a load f e^{iθ} does, each as its parts along e^{iθ} and e^{-iθ}.

    Attributes
    ----------
    driving : complex
        φᴴf, N/kg^½.
    force : (2,) complex
        α and β of δΛ, N/kg^½.
    output : (2, o, 3) complex
        Displacement of the output nodes in the fundamental, m.
    contact : (3,) float
        |u|² of the contacts' vibration that it adds: of its parts with cos θ, with sin θ, and what
        stands with 2 sin θ cos θ; each contact by its stiffness, J.
    own : float
        The same of the mode's own vibration, J.
    damping : float
        φᴴCφ of the structure's own damping C, 1/s.
    """

    driving: complex
    force: Array
    output: Array
    contact: Floats
    own: float
    damping: float


def other_modes(
    structure: Structure,
    friction: Law,
    held: HeldVibration,
    amplitude: float,
    w: Floats,
    load: Array,
    counted: NDArray[np.bool_],
) -> OtherModes:
    """What the rest of a load does to a mode's motion.

    Parameters
    ----------
    structure : Structure
    friction : Law
    held : HeldVibration
        Along the mode's shape, at its frequency and without self-excitation.
    amplitude : float
        The mode's, kg^½ m.
    w : (c, 3, 2H + 1) float
        Deviation of the contacts in the mode's motion, m.
    load : (n,) complex
        Vᴴf.
    counted : (c,) bool
        Contacts whose vibration is summed up.

    Raises
    ------
    numpy.linalg.LinAlgError
        If P is singular.
    """
    modes, fundamental = structure.at(1), held.excited[0]
    unit = held.shape / modes.compliance  # VᴴMφ are the modal amplitudes of φ by their compliance
    driving = complex(np.vdot(unit, load))
    rest = load - held.shape * driving
    balance = held.balance(amplitude)
    u = balance.displacement(w)
    deviation = friction(u, held.omega)
    rows = active_rows(w, deviation)
    linear = None
    if len(rows):
        weight = np.broadcast_to(1 / scales(balance.linear), w.shape).reshape(-1)
        stiffness = friction.stiffness.reshape(-1)
        linear = linearise(balance, deviation, rows, weight, None, None, stiffness)
    forces, outputs, moves = [], [], []
    for phase in (1.0, 1j):
        y, force = fundamental.solve((phase * rest)[:, None])
        first = np.zeros((structure.harmonics + 1, modes.rows.shape[0]), complex)
        first[1] = modes.rows @ y[:, 0]
        pushed = to_real(first).reshape(w.shape)
        dw, moved = np.zeros_like(w), pushed
        if linear is not None:
            right = np.zeros(w.size)
            right[rows] = response_to(deviation, rows, pushed)
            found = linear.solve(right, EXACT)
            if found is None:
                raise np.linalg.LinAlgError("the linearised contacts are singular")
            dw = found.reshape(w.shape)
            moved = pushed + balance.moved(dw)
        pulled = modes.pull @ (_first(dw) * structure.stiffness)
        by_contacts = fundamental.solve(pulled[:, None])[0][:, 0]
        forces.append(complex(force[0]) + held.force(0.0, dw))
        outputs.append(structure.output_rows[1] @ (y[:, 0] + by_contacts))
        moves.append(moved)
    (real, imaginary), (even, odd) = moves, np.array(outputs)
    by_stiffness = friction.stiffness[:, :, None] * counted[:, None, None]

    def product(a: Floats, b: Floats) -> float:
        """Of two vibrations of the contacts."""
        return float((by_stiffness * a[:, :, 1:] * b[:, :, 1:]).sum())

    slope = modes.slope(held.omega, unit)
    return OtherModes(
        driving=driving,
        force=np.array([forces[0] - 1j * forces[1], forces[0] + 1j * forces[1]]) / 2,
        output=np.array([even - 1j * odd, even + 1j * odd]) / 2,
        contact=np.array(
            [product(real, real), product(imaginary, imaginary), product(real, imaginary)]
        ),
        own=product(u, u),
        damping=float(np.vdot(unit, slope).imag),
    )


def _first(w: Floats) -> NDArray[Any]:
    """(3c,) complex coefficients of the fundamental."""
    return np.asarray(to_complex(w.reshape(-1, w.shape[2])[:, :3])[1])
