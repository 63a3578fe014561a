"""Forced response: what the solver returns.

What solved points leave of the balance of all coordinates, seen from a few directions.

Solved is the balance condensed to the contacts, by modes. With the matrices as given, and
one-sided coefficients,

    r_h = D_h x^(h) + B_hᴴ λ^(h) - f^(h)

shows as well what modes and receptances have lost to round-off. Each r_h is weighed with four
motions z, sums of all modes with random signs: zᴴ r_h vanishes for all of them only if r_h does.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeAlias

import numpy as np

from vanelock.common.arrays import Array, Booleans, Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.balance import Structure
from vanelock.nonlinear.contact.law import ELEMENT, OPEN, SLIP, SLIP_OPEN, STUCK
from vanelock.nonlinear.fourier import TURN, grid, to_complex, to_real
from vanelock.nonlinear.newton.newton import Solution
from vanelock.rom.system.system import Contacts

STATES = (
    f"{STUCK} stuck, {SLIP} slips, {OPEN} open, {SLIP_OPEN} slips and opens, {ELEMENT} an element"
)
"""What the numbers in a response's `state` stand for."""
_ROUNDING = 1e-12  # of a contact's displacements: motion of a slider that is none
_BALANCED = 1e-6  # relative residual of the whole balance up to which a point counts as solved


@dataclass(frozen=True)
class ErrorEstimates(Product):
    """Estimated errors of the amplitude A of one output at p frequencies, see `error_estimates`.

    Attributes
    ----------
    sources : tuple of str
        What causes them, s names.
    change : (p, s) float
        By how much A is too small because of each source, to first order, m; NaN where unknown.
    amplitude : (p,) float
        A, half the peak-to-peak, m.
    slope : (p,) float
        dA/df along the solutions, m/Hz; NaN where the curve turns back.
    harmonics : (p,) int
        H of each point.
    monitored : (2,) int
        Place of the output node, and direction.
    tried : int
        Harmonics whose nodal diameters were asked for: those kept, and those for error estimates.
    """

    sources: tuple[str, ...]
    change: Floats = field(metadata={"unit": "m"})
    amplitude: Floats = field(metadata={"unit": "m"})
    slope: Floats = field(metadata={"unit": "m/Hz"})
    harmonics: Integers
    monitored: Integers
    tried: int

    @property
    def error(self) -> Floats:
        """(p, s) relative error of A by each source."""
        size = np.where(self.amplitude > 0, self.amplitude, np.finfo(float).tiny)
        return np.asarray(np.abs(self.change) / size[:, None])

    @property
    def total(self) -> Floats:
        """(p,) sum of the relative errors that are known."""
        return np.asarray(np.nansum(self.error, axis=1))

    def at(self, points: Sequence[int]) -> "ErrorEstimates":
        """Those of some points."""
        by_point = ("change", "amplitude", "slope", "harmonics")
        return replace(self, **{name: getattr(self, name)[points] for name in by_point})


CONSTANT = (
    "stiffness",
    "mu",
    "harmonic_diameters",
    "coupling",
    "friction",
    "samples",
    "estimates",
    "direction",
)
"""What a response does not have point by point."""


@dataclass(frozen=True)
class Response(Product):
    """Periodic response at p frequencies, q(t) = Re Σ_h q^(h) e^{ihωt}.

    Attributes
    ----------
    frequency : (p,) float
        Hz.
    x : dict of int to (p, n_h) complex; float for h = 0
        All coordinates of the system, by harmonic, in the basis of the harmonic's diameter.
    contact : (p, H + 1, c, 3) complex
        Relative displacements (v, u1, u2), interference included in the mean of v, m.
    force : (p, H + 1, c, 3) complex
        Contact forces (n, t1, t2), N.
    state : (p, c) int
        STUCK, SLIP, OPEN or SLIP_OPEN; ELEMENT for what follows a law of its own.
    dissipation : (p, c) float
        Friction work of each contact, work of each element, in a period, J.
    output : (p, H + 1, o, 3) complex
        Displacement of the output nodes, m.
    amplitude : (p, o, 3) float
        Half the peak-to-peak of each output over a period, m.
    converged : (p,) bool
        Whether the condensed residual is below the tolerance and the whole one at most 1e-6; if
        not, nothing here is to be trusted.
    residual : (p,) float
        Relative residual of the balance: of that condensed to the contacts or, if larger, of the
        whole, in all coordinates.
    iterations : (p,) int
        Newton steps spent, without those of paths that led nowhere; `seconds` has them all.
    active : (p,) int
        Contacts that deviate from sticking where they were assembled.
    stiffness : (c, 3) float
        (kn, kt1, kt2), N/m.
    mu : (c,) float
        Friction coefficients.
    harmonic_diameters : (H + 1,) int
        Nodal diameter of each harmonic.
    seconds : (p,) float
        Processor time spent on each point; 0 where it was not taken.
    truncation : (p,) float
        By how much the motion of the contacts is off, relative to the largest and to first order,
        because some modes count by their static part alone (`static_beyond`); 0 without those.
    coupling, friction : str
        As of `Options`. Unless it is "coupled", harmonic 0 of `x`, `contact`, `force`
        and `output` is the static problem's.
    samples : int
        Of the period, on which the contact law was evaluated; 0: its events were located.
    estimates : ErrorEstimates or None
        Of one output's amplitude, where they were asked for.
    direction : str or None
        "up" or "down", the way the frequencies were passed; "both" where the largest of the
        solutions of both ways was taken; None where they were not passed.
    jump : (j, 2) int or None
        Points before and after each jump, in that direction: neighbours that no curve of solutions
        joins. None where jumps were not looked for.
    """

    frequency: Floats = field(metadata={"unit": "Hz"})
    x: dict[int, Array] = field(metadata={"unit": "m; modal coordinates kg^0.5 m"})
    contact: Complex = field(metadata={"unit": "m"})
    force: Complex = field(metadata={"unit": "N"})
    state: Integers = field(metadata={"codes": STATES})
    dissipation: Floats = field(metadata={"unit": "J"})
    output: Complex = field(metadata={"unit": "m"})
    amplitude: Floats = field(metadata={"unit": "m"})
    converged: Booleans
    residual: Floats
    iterations: Integers
    active: Integers
    stiffness: Floats = field(metadata={"unit": "N/m"})
    mu: Floats
    harmonic_diameters: Integers
    seconds: Floats = field(metadata={"unit": "s"})
    truncation: Floats
    coupling: str = "coupled"
    friction: str = "orthogonal"
    samples: int = 0
    estimates: ErrorEstimates | None = None
    direction: str | None = None
    jump: Integers | None = None

    @property
    def error(self) -> Floats:
        """(p,) estimated relative error of the monitored output; NaN where none was estimated."""
        if self.estimates is None:
            return np.full(self.points, np.nan)
        return np.where(self.converged, self.estimates.total, np.inf)

    @property
    def undetermined(self) -> Booleans:
        """(p, c, 2) whether the static friction of a tangential direction is left open.

        It is where a contact with friction never opens and never slides in that direction: what it
        carries at rest is then whatever its assembly left, here none or the least. Directions
        slide together where friction is isotropic.
        """
        slides = np.repeat(np.isin(self.state, (SLIP, SLIP_OPEN, OPEN))[:, :, None], 2, axis=2)
        if self.friction == "orthogonal":
            w = (self.contact - self.force / self.stiffness)[:, 1:, :, 1:]
            largest = np.abs(self.contact).max(axis=(1, 3))[:, :, None]
            still = np.abs(w).max(axis=1, initial=0.0) <= _ROUNDING * largest
            slides &= ~(still & (self.state == SLIP)[:, :, None])
        return np.asarray(~slides & (self.mu > 0)[:, None])

    @property
    def harmonics(self) -> int:
        """H."""
        return int(self.contact.shape[1]) - 1

    def at(self, points: Sequence[int]) -> "Response":
        """Some of the points, without the jumps between them."""
        changed: dict[str, Any] = {"jump": None}
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, dict):
                changed[each.name] = {key: item[points] for key, item in value.items()}
            elif isinstance(value, ErrorEstimates):
                changed[each.name] = value.at(points)
            elif each.name not in (*CONSTANT, *changed):
                changed[each.name] = value[points]
        return replace(self, **changed)

    @property
    def points(self) -> int:
        """Number of frequencies p."""
        return len(self.frequency)


def extremes(q: Complex) -> Floats:
    """Angles of the largest and smallest values of q(t), (2, k), from (H + 1, k) coefficients."""
    harmonics = len(q) - 1
    count, h = 32 * max(harmonics, 1), np.arange(harmonics + 1)
    history = to_real(q) @ grid(harmonics, count).T
    angles = TURN * np.array([history.argmax(axis=1), history.argmin(axis=1)]) / count
    for angle, sign in zip(angles, (1.0, -1.0), strict=True):
        sampled = angle.copy()
        for _ in range(5):  # from the nearest sample Newton's iteration needs no more
            wave = q * np.exp(1j * np.outer(h, angle))
            slope = (1j * h[:, None] * wave).sum(axis=0).real
            curvature = -(h[:, None] ** 2 * wave).sum(axis=0).real
            step = np.divide(slope, curvature, out=np.zeros_like(slope), where=curvature != 0)
            angle -= step.clip(-TURN / count, TURN / count)
        lost = sign * _values_at(q, angle) < sign * _values_at(q, sampled)
        angle[lost] = sampled[lost]
    return np.asarray(angles)


def _values_at(q: Complex, angle: Floats) -> Floats:
    """(k,) values of q(t), given (H + 1, k) coefficients, each at an angle of its own."""
    return np.asarray((q * np.exp(1j * np.outer(np.arange(len(q)), angle))).sum(axis=0).real)


def half_peak_to_peak(q: Complex) -> Floats:
    """Half the peak-to-peak over a period of q(t), given one-sided coefficients (H + 1, ...)."""
    harmonics = len(q) - 1
    if harmonics < 2:
        return np.asarray(np.abs(q[1:]).sum(axis=0))
    flat = to_complex(to_real(q).reshape(-1, 2 * harmonics + 1))
    top, bottom = (_values_at(flat, angle) for angle in extremes(flat))
    return np.asarray((top - bottom).reshape(q.shape[1:]) / 2)


def chosen_points(response: Response, points: Sequence[int] | None) -> list[int]:
    """Points of a response that are asked for; None for all."""
    chosen = list(range(response.points) if points is None else points)
    for point in chosen:
        if not 0 <= point < response.points:
            raise InputError(f"points: given {point}: there are {response.points}, counted from 0")
    if not chosen:
        raise InputError("points: given none: needs one at least")
    return chosen


def check_contacts(response: Response, contacts: Contacts) -> None:
    """Refuse a response of another number of contacts."""
    if len(response.mu) != contacts.count:
        raise InputError(
            f"response: has {len(response.mu)} contacts: the system has {contacts.count}"
        )


def amplitude_and_slope(q: Complex, rates: Complex) -> tuple[float, float]:
    """Half the peak-to-peak of coefficients (H + 1,), and its derivative if they change at `rates`.

    That of an extreme is the value of the rates at its angle, where the slope in time vanishes.
    """
    wave = np.exp(1j * np.outer(np.arange(len(q)), extremes(q[:, None])[:, 0]))
    amplitude, slope = ((np.stack([q, rates]) @ wave).real @ [0.5, -0.5]).tolist()
    return amplitude, slope


Amplitudes: TypeAlias = Callable[[float, Floats], list[Array]]


def assemble_response(
    structure: Structure,
    solutions: Sequence[Solution],
    amplitudes: Amplitudes | None = None,
    driven: bool = True,
) -> Response:
    """Collect solved points into a response, all coordinates recovered.

    `amplitudes` gives those of the modes by frequency and w, where it is known better than by
    `Structure.amplitudes`. What is `driven` by the excitation alone is balanced as a whole.
    """
    H, system = structure.harmonics, structure.system
    count, outputs = system.contacts.count, len(system.output_names)
    m = 2 * H + 1
    modal_of = structure.amplitudes if amplitudes is None else amplitudes
    by_point = [modal_of(s.omega, s.w) for s in solutions]
    x, modal = {}, []
    for h in range(H + 1):
        shapes = structure.at(h).shapes
        modal.append(np.array([point[h] for point in by_point]).reshape(-1, len(shapes.T)))
        moved = modal[h] @ shapes.T
        x[h] = moved.real.copy() if h == 0 else moved.astype(complex)
    stacked = np.array([s.u for s in solutions]).reshape(len(solutions), count, 3, m)
    deviating = np.array([s.w for s in solutions]).reshape(stacked.shape)
    pulled = (stacked - deviating) * system.contacts.stiffness[:, :, None]
    force = to_complex(pulled).swapaxes(0, 1)
    omegas = np.array([s.omega for s in solutions])
    left = _whole_residual(structure, omegas, modal, force) if driven else np.zeros(len(omegas))
    output = np.array([structure.output(point) for point in by_point], complex)
    output = output.reshape(len(solutions), H + 1, outputs, 3)
    return Response(
        frequency=omegas / TURN,
        x=x,
        contact=to_complex(stacked).swapaxes(0, 1),
        force=force,
        state=np.array([s.deviation.state for s in solutions]).reshape(len(solutions), count),
        dissipation=np.array([s.deviation.dissipation for s in solutions]).reshape(
            len(solutions), count
        ),
        output=output,
        amplitude=half_peak_to_peak(output.swapaxes(0, 1)),
        converged=np.array([s.converged for s in solutions], bool) & (left <= _BALANCED),
        residual=np.maximum([s.residual for s in solutions], left),
        iterations=np.array([s.iterations for s in solutions], np.int64),
        active=np.array([s.deviation.w.any(axis=(1, 2)).sum() for s in solutions], np.int64),
        stiffness=system.contacts.stiffness,
        mu=system.contacts.mu,
        harmonic_diameters=np.array(structure.nodal_diameters),
        seconds=np.array([s.seconds for s in solutions], float),
        truncation=np.array([s.truncation for s in solutions], float),
    )


_DIRECTIONS = 4
_FINEST = 1e-4
"""The static balance, or the vibrating one, is compared with the other times this if smaller."""


def _whole_residual(
    structure: Structure, omegas: Floats, modal: Sequence[Array], force: Complex
) -> Floats:
    """Largest zᴴ r_h of each point over the largest of its terms, (p,); at rest and vibrating."""
    left, size = np.zeros((2, structure.harmonics + 1, len(omegas)))
    signs = np.random.default_rng(0)
    for h, amplitudes in enumerate(modal):
        modes, matrices = structure.at(h), structure.system.at(structure.nodal_diameters[h])
        some = signs.choice([-1.0, 1.0], (amplitudes.shape[1], _DIRECTIONS))
        z, x = modes.shapes @ some, amplitudes @ modes.shapes.T
        s = h * omegas[:, None]
        rows = structure.system.contact_rows(structure.nodal_diameters[h]).reshape(-1, len(z))
        pull = (rows @ z).conj()
        terms = [x @ (matrices.K @ z).conj(), force[:, h].reshape(len(omegas), -1) @ pull]
        if h and np.isfinite(structure.cutoff):  # modes beyond it have no inertia
            terms.append(-(s**2) * ((modes.compliance * amplitudes) @ some))
        elif h:
            terms.append(-(s**2) * (x @ (matrices.M @ z).conj()))
        if h:
            damped = modes.coupled_damping
            rate = amplitudes * modes.damping if damped is None else amplitudes @ damped.T
            terms.append(1j * s * (rate @ some))
        if h in structure.unit_forces:
            growth = np.array([structure.growth(h, omega) for omega in omegas])
            terms.append(-growth[:, None] * (structure.unit_forces[h] @ some))
        left[h] = np.abs(sum(terms)).max(axis=1, initial=0.0)
        size[h] = np.abs(terms).max(axis=(0, 2), initial=0.0)
        if h == 0:  # interference loads, even where the structure evades it
            offset = structure.stiffness * structure.system.contacts.offset.reshape(-1)
            size[0] = np.maximum(size[0], np.abs(offset @ pull).max(initial=0.0))
    moving = size[1:].max(axis=0, initial=0.0)
    scale = np.stack([np.maximum(size[0], _FINEST * moving), np.maximum(moving, _FINEST * size[0])])
    scale[scale == 0] = 1.0
    return np.asarray(np.maximum(left[0] / scale[0], left[1:].max(axis=0, initial=0.0) / scale[1]))
