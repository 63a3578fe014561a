"""Direct time integration of the whole ring: the reference that assumes no period and no wave."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from vanelock.common.arrays import Array, Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.contact.law import OPEN, SLIP, SLIP_OPEN, STUCK, check_friction
from vanelock.nonlinear.forced_response.options import check_band
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import TURN, one_thread
from vanelock.nonlinear.transient.full_ring import ring
from vanelock.nonlinear.transient.integration import Integrator, Period, check_start, integrator
from vanelock.rom.system.system import System


def _coefficients(history: Floats, harmonics: int) -> Complex:
    """One-sided coefficients (H + 1, ...) of samples (s, ...) at the ends of the steps."""
    q: Complex = np.fft.rfft(np.roll(history, 1, axis=0), axis=0)[: harmonics + 1] / len(history)
    q[1:] *= 2
    return q


def departure(
    stepped: Integrator, period: Period, output: Floats, response: Response, point: int
) -> float:
    """Largest difference of the harmonics from those of a point of a response."""
    lag = stepped.ring.lag(np.arange(response.harmonics + 1))
    largest = 0.0
    for history, expected in (
        (period.u, response.contact[point]),
        (output, response.output[point]),
    ):
        q = expected.reshape(response.harmonics + 1, 1, -1) * lag[:, :, None]
        if q.size:
            moved = np.abs(_coefficients(history, response.harmonics) - q).max()
            largest = max(largest, moved / max(np.abs(q[1:]).max(initial=0), 1e-300))
    return float(largest)


def output_history(stepped: Integrator, period: Period) -> Floats:
    """(s, N, 3o) displacement of the output nodes."""
    whole, n = stepped.ring, stepped.arrays.rows.shape[2]
    deviations = stepped.pulling(period.u, period.w, stepped.arrays.linear)
    rows, moved = [], []
    for i, (k, modes) in enumerate(zip(whole.diameters, whole.modes, strict=True)):
        output, size = whole.system.at(k).output, len(modes.shapes)
        out = np.zeros((0, size)) if output is None else output.reshape(-1, size) @ modes.shapes
        near, far = out[:, :n], out[:, n:]
        rigid = far / modes.static[n:] @ modes.rows[:, n:].conj().T * whole.stiffness
        moved.append(period.y[:, i, : near.shape[1]] @ near.T + deviations[i] @ rigid.T)
        rows.append(out)
    weighted = np.array(moved) * whole.weight[:, None, None]
    history: Floats = np.einsum("kj,k...d->...jd", whole.shift, weighted).real
    angles = TURN * np.arange(1, stepped.steps + 1) / stepped.steps
    for h, amplitude in whole.linear(stepped.omega).items():
        k, mirrored = whole.wave(h)
        out = rows[k].conj() if mirrored else rows[k]
        history += whole.travelling(h, out @ amplitude, angles)
    return history


@dataclass(frozen=True)
class TimeResponse(Product):
    """The last period of a ring integrated in time, q(t) = Re Σ_h q^(h) e^{ihωt}.

    Attributes
    ----------
    frequency : float
        Hz.
    contact : (H + 1, N, c, 3) complex
        Relative displacements (v, u1, u2) of the contacts of every sector, m; N = 1 where all
        sectors move alike.
    force : (H + 1, N, c, 3) complex
        Contact forces (n, t1, t2), N.
    output : (H + 1, N, o, 3) complex
        Displacement of the output nodes, m.
    x : dict of int to (n_h,) complex; float for h = 0
        Coordinates of the first sector in the basis of the harmonic's diameter: the part that
        travels with the excitation.
    state : (N, c) int
        STUCK, SLIP, OPEN or SLIP_OPEN.
    dissipation : (N, c) float
        Friction work in the period, J.
    defect : (P,) float
        By period, how far contacts and sliders are at its end from where they were at its
        beginning, relative to the largest vibration of a contact: 0 for a steady vibration.
    departure : (P,) float
        By period, the largest difference of a contact's or an output's harmonics 0 ... H from
        those of the motion that it was started from, each relative to the largest of its kind at
        h >= 1; nan where there is none.
    steps : int
        Steps a period.
    unsolved : int
        Steps in all whose contacts were not solved to round-off.
    seconds : float
        Computing time of all periods.
    """

    frequency: float = field(metadata={"unit": "Hz"})
    contact: Complex = field(metadata={"unit": "m"})
    force: Complex = field(metadata={"unit": "N"})
    output: Complex = field(metadata={"unit": "m"})
    x: dict[int, Array]
    state: Integers
    dissipation: Floats = field(metadata={"unit": "J"})
    defect: Floats
    departure: Floats
    steps: int
    unsolved: int
    seconds: float = field(metadata={"unit": "s"})


@one_thread
def time_response(
    system: System,
    frequency: float,
    periods: int = 100,
    steps: int = 512,
    harmonics: int = 9,
    start: tuple[Response, int] | None = None,
    tolerance: float = 0.0,
    modes: int | None = None,
    friction: str = "orthogonal",
    progress: Callable[[int, int, float], None] | None = None,
) -> TimeResponse:
    """Integrate the motion of every sector in time.

    Parameters
    ----------
    system : System
        With the nodal diameters 0 ... ⌊N/2⌋; 0 alone where EO is a multiple of N.
    frequency : float
        Of the excitation, Hz.
    periods : int
        Periods followed, at most.
    steps : int
        A period; the error falls with their square.
    harmonics : int
        H of the result; the integration knows no harmonics.
    start : (Response, int), optional
        Start from a point of a response at this frequency, every sector at its own instant.
        If not given: from the steady linear vibration with all contacts stuck as assembled.
    tolerance : float
        End early when the defect of a period is below it.
    modes : int, optional
        Modes of each nodal diameter that have inertia, lowest first. The others follow the
        contacts' deviations statically, which costs accuracy of the order of the square of the
        frequency over theirs, and the excitation exactly. All if not given.
    friction : {"orthogonal", "isotropic"}
        As of `Options`.
    progress : callable, optional
        Called after each period with (periods done, periods at most, defect).

    Returns
    -------
    TimeResponse
        `defect` says whether the last period is a steady vibration.

    Notes
    -----
    Contacts are those of `frequency_response`, coupled. A motion that it finds may be unstable,
    such as a wave that the sectors cease to repeat: the ring then leaves it, and `departure` grows
    by the same factor every period.

    Raises
    ------
    InputError
        If a nodal diameter is missing, the stuck modes do not diagonalise a given C, an option is
        out of range, friction is unknown, or isotropic where a contact is stiffer in one direction,
        or the start is not of this system, friction and frequency.
    """
    for name, value, least in (
        ("periods", periods, 1),
        ("steps", steps, 4 * harmonics + 4),
        ("harmonics", harmonics, 0),
        ("modes", 1 if modes is None else modes, 1),
    ):
        if value < least:
            raise InputError(f"{name}: given {value}: allowed: {least} or more")
    if not frequency > 0 or not np.isfinite(frequency):
        raise InputError(f"frequency: given {frequency} Hz: must be > 0 and finite")
    check_band(system, [frequency])
    check_friction(system.contacts, friction)
    whole = ring(system)
    if start is not None:
        check_start(whole, frequency, friction, *start)
    stepped = integrator(whole, TURN * frequency, steps, modes, friction == "isotropic")
    began = time.perf_counter()
    motion = stepped.stuck() if start is None else stepped.balanced(*start)
    defects, departures, unsolved = [], [], 0
    for done in range(1, periods + 1):
        found = stepped.period(motion)
        defects.append(found.defect)
        away = np.nan
        if start is not None:
            away = departure(stepped, found, output_history(stepped, found), *start)
        departures.append(away)
        unsolved += found.unsolved
        if progress is not None:
            progress(done, periods, defects[-1])
        if defects[-1] < tolerance:
            break
    seconds = time.perf_counter() - began
    force = (found.u - found.w) * whole.stiffness
    contacts, outputs = system.contacts.count, len(system.output_names)
    shape = (harmonics + 1, whole.sectors, contacts, 3)
    return TimeResponse(
        frequency=frequency,
        contact=_coefficients(found.u, harmonics).reshape(shape),
        force=_coefficients(force, harmonics).reshape(shape),
        output=_coefficients(output_history(stepped, found), harmonics).reshape(
            harmonics + 1, whole.sectors, outputs, 3
        ),
        x=_coordinates(stepped, found, harmonics),
        state=_states(found),
        dissipation=_dissipation(found, force),
        defect=np.array(defects),
        departure=np.array(departures),
        steps=steps,
        unsolved=unsolved,
        seconds=seconds,
    )


def _coordinates(stepped: Integrator, period: Period, harmonics: int) -> dict[int, Array]:
    """Travelling part of every harmonic in all coordinates of its diameter."""
    whole, n = stepped.ring, stepped.arrays.rows.shape[2]
    linear = whole.linear(stepped.omega)
    y = np.fft.fft(np.roll(period.y, 1, axis=0), axis=0) / stepped.steps
    pulling = stepped.pulling(period.u, period.w, stepped.arrays.linear)
    deviations = np.fft.fft(np.roll(pulling, 1, axis=1), axis=1) / stepped.steps
    x: dict[int, Array] = {}
    for h in range(harmonics + 1):
        k, mirrored = whole.wave(h)
        modes = whole.modes[k]
        far = modes.rows[:, n:].conj().T @ (whole.stiffness * deviations[k, -h if mirrored else h])
        far = far / modes.static[n:]
        amplitude = np.concatenate([y[-h if mirrored else h, k, : len(modes.compliance)], far])
        if h:
            amplitude = 2 * amplitude
        amplitude = amplitude.conj() if mirrored else amplitude
        shapes = modes.shapes.conj() if mirrored else modes.shapes
        moved = shapes @ (amplitude + linear.get(h, 0.0))
        x[h] = moved.real.copy() if h == 0 else moved
    return x


def _states(period: Period) -> Integers:
    """(N, c) what each contact does within the period."""
    steps, sectors, _ = period.u.shape
    v = period.u.reshape(steps, sectors, -1, 3)[..., 0]
    w = period.w.reshape(steps, sectors, -1, 3)
    opens, closes = np.any(v < 0, axis=0), np.any(v > 0, axis=0)
    slides = np.any(np.diff(w[..., 1:], axis=0, prepend=w[-1:, ..., 1:]) != 0, axis=(0, 3))
    return np.asarray(np.select([opens & closes, opens, slides], [SLIP_OPEN, OPEN, SLIP], STUCK))


def _dissipation(period: Period, force: Floats) -> Floats:
    """(N, c) friction work ∫ t dw in the period, J."""
    steps, sectors, _ = period.u.shape
    t = force.reshape(steps, sectors, -1, 3)[..., 1:]
    w = period.w.reshape(steps, sectors, -1, 3)[..., 1:]
    mean = (t + np.roll(t, 1, axis=0)) / 2
    return np.asarray((mean * np.diff(w, axis=0, prepend=w[-1:])).sum(axis=(0, 3)))
