"""Comparisons that the published study makes at full stick, on equal frequencies.

Figure 10: hooks in friction, interlock apart, against the linear response. Figure 11: all stuck,
coupled against uncoupled.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.nonlinear import Response, System

STEPS = 10
"""Of the iteration for an interference; each leaves a small share of the distance."""
REACHED = 0.05
"""Share of the largest mean force by which another may be missed in the end."""
MARGIN = 0.5
"""Share of the friction bound that vibration may use where all contacts shall stick."""


def sticking_load(static: Response, linear: Response, opens: NDArray[np.bool_]) -> float:
    """Factor of the load at which every contact that can open sticks in every period.

    A slider that rests at its bound gives way once and then sticks where the bounds leave room for
    all of the motion: 2 kt |u| + 2 mu |n| <= 2 mu n0, amplitudes of the linear response at its
    worst frequency against the normal force at rest; half of that is taken, to two digits.

    Parameters
    ----------
    static : Response
        The state at rest.
    linear : Response
        Linear response with all contacts stuck, at the full load.
    opens : (c,) bool
        Those contacts.
    """
    force = np.abs(linear.force[:, 1]).max(axis=0)  # (c, 3)
    bound = static.mu * static.force[0, 0, :, 0].real
    wanted = force[:, 1:].max(axis=1) + static.mu * force[:, 0]
    own = opens & (wanted > 0)
    room = MARGIN * float((bound[own] / wanted[own]).min())
    if not room > 0:
        return 1e-3
    digits = 10.0 ** (1 - np.floor(np.log10(min(room, 1.0))))
    return float(np.floor(min(room, 1.0) * digits) / digits)


@dataclass(frozen=True)
class Difference:
    """How far a response is from another one at the same frequencies.

    Attributes
    ----------
    vibration : float
        Largest difference of any output's harmonics h >= 1, over the largest of them.
    mean : float
        Largest difference of the contacts' mean forces, over the largest mean force of the joint.
    frequency : float
        Difference of the peaks' frequencies, relative.
    amplitude : float
        Difference of the peaks' amplitudes, relative.
    slipping : int
        Contacts that slip or open at any frequency.
    """

    vibration: float
    mean: float
    frequency: float
    amplitude: float
    slipping: int


def from_linear(
    response: Response, system: System, closed: NDArray[np.bool_], output: tuple[int, int]
) -> Difference:
    """A nonlinear response against the linear one with the given contacts closed."""
    linear = nonlinear.linear_response(system, response.frequency, closed)
    return _difference(response, linear, output, closed)


def between(response: Response, other: str, system: System, output: tuple[int, int]) -> Difference:
    """A coupled response against another coupling at the same frequencies."""
    again = nonlinear.frequency_response(
        system,
        response.frequency,
        nonlinear.Options(response.harmonics, coupling=other, friction=response.friction),
        find_jumps=False,
    )
    return _difference(response, again, output, np.ones(system.contacts.count, bool))


def at_mean_load(
    system: System, top: Response, hertz: tuple[float, float], output: tuple[int, int]
) -> float:
    """Constant-load peak where the forces at rest are the mean ones of a coupled peak, m, or NaN.

    Interference is moved, contact by contact, until the static problem has those means; what is
    then left between the two peaks is not due to the mean load. NaN where there is no such
    interference, or no peak within the range.

    Parameters
    ----------
    system : System
    top : Response
        The coupled peak alone.
    hertz : (float, float)
        The range of frequencies, Hz.
    output : (int, int)
        Output node and direction.
    """
    own = system.contacts.opens
    wanted = top.force[0, 0, own, 0].real
    moved = system
    modes = nonlinear.harmonic_modes(system, top.harmonics).diameters
    for _ in range(STEPS):
        n = nonlinear.static_response(moved, modes=modes).force[0, 0, own, 0].real
        v0 = moved.contacts.v0.copy()
        v0[own] += (wanted - n) / system.contacts.kn[own]
        moved = replace(moved, contacts=replace(moved.contacts, v0=v0))
    n = nonlinear.static_response(moved, modes=modes).force[0, 0, own, 0].real
    if np.abs(n - wanted).max(initial=0.0) > REACHED * np.abs(wanted).max(initial=0.0):
        return float("nan")
    found = nonlinear.frequency_response(
        moved,
        hertz,
        nonlinear.Options(top.harmonics, coupling="constant-load"),
        modes=modes,
        find_jumps=False,
    )
    size = np.where(found.converged, found.amplitude[:, *output], -np.inf)
    peak = int(size.argmax())
    within = 0 < peak < found.points - 1 and np.isfinite(size[peak])
    return float(size[peak]) if within else float("nan")


def _difference(
    one: Response, other: Response, output: tuple[int, int], counted: NDArray[np.bool_]
) -> Difference:
    harmonics = min(one.harmonics, other.harmonics)
    a, b = one.output[:, 1 : harmonics + 1], other.output[:, 1 : harmonics + 1]
    means = [each.force[:, 0, counted].real for each in (one, other)]
    size = [each.amplitude[:, *output] for each in (one, other)]
    tops = [int(each.argmax()) for each in size]
    return Difference(
        vibration=float(np.abs(a - b).max() / np.abs(b).max()),
        mean=float(np.abs(means[0] - means[1]).max() / max(np.abs(means[1]).max(), 1e-300)),
        frequency=float(one.frequency[tops[0]] / other.frequency[tops[1]] - 1),
        amplitude=float(size[0][tops[0]] / size[1][tops[1]] - 1),
        slipping=int((one.state[:, counted] != nonlinear.STUCK).any(axis=0).sum()),
    )
