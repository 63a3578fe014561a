"""What a period of the ring's motion needs, prepared once, and the motion as it stands.

Linear modes are stepped under a load that is known at the ends of steps. A mode obeys Λ y'' + D y'
+ A y = r(t). With its state s = (y, τ y', ., .), τ the step, and the load's change Δr in the step,

    s_next = E s + hold r + rise Δr.

A mode that turns by at most a radian in a step is integrated exactly under a load that is linear
within steps. Chords of a smooth load lie off it by τ² r''/12 in the mean, and chords across a
kink of a load by a twelfth of its change of slope times τ, in the mean of the places where it may
lie. So the chords are drawn through r - δ²r/12 instead, δ² the second difference of the last three
values; the state keeps what that takes. Stiffer modes follow Wood, Bossak and Zienkiewicz (1980)
with α = -1, s = (y, τ y', τ² y'', 0): of second order, stable, and what they do not resolve dies
out, so that they become quasi-static. In both, 0 <= rise < 1 for y: the deviation of a contact from
sticking and the motion it causes in the step are bound by a monotone relation.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from vanelock.common.arrays import Complex, Floats
from vanelock.common.errors import InputError
from vanelock.nonlinear.contact.isotropic_law import slider_places
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import TURN, to_real
from vanelock.nonlinear.transient.full_ring import FullRing
from vanelock.nonlinear.transient.time_marching import RingMotion, Stepping, follow, march

_RESOLVED = 1.0  # largest turn of a mode in a step, rad, up to which it is integrated exactly
_SMALL = 1e-9
"""Change of a deviation at which a step counts as solved, relative to the linear vibration."""


def _steps_of(
    compliance: Floats, damping: Floats, step: float, static: Floats | None = None
) -> tuple[Floats, Floats, Floats]:
    """E (4, 4, n), hold and rise (4, n) of modes with Λ, s²/rad², and D, s/rad; `step` in s.

    A is 1 if `static` is not given. Given, the load is that of springs as well, which their own
    motion sets: through r itself chords are drawn then, since what the past corrects might grow.
    """
    n = len(compliance)
    corrected, static = static is None, np.ones(n) if static is None else static
    steps = np.zeros((4, 4, n)), np.zeros((4, n)), np.zeros((4, n))
    slow = compliance * _RESOLVED**2 >= static * step**2
    for which in (slow, ~slow):
        if np.any(which):
            mode = compliance[which] / step**2, static[which], damping[which] / step
            parts = _exact(*mode, corrected) if which is slow else _implicit(*mode)
            for array, part in zip(steps, parts, strict=True):
                array[..., which] = part
    return steps


def _exact(
    compliance: Floats, static: Floats, damping: Floats, corrected: bool
) -> tuple[Floats, Floats, Floats]:
    """By the exponential of the mode and its load; the state is (y, τ y', e, Δr).

    e is what the load r is corrected by, -δ²r/12.
    """
    n = len(compliance)
    rate = np.zeros((n, 4, 4))
    rate[:, 0, 1] = rate[:, 2, 3] = 1.0
    rate[:, 1, 0], rate[:, 1, 2] = -static / compliance, 1 / compliance
    rate[:, 1, 1] = -damping / compliance
    moved = la.expm(rate)
    constant, ramp = moved[:, :2, 2].T, moved[:, :2, 3].T
    transition, hold, rise = np.zeros((4, 4, n)), np.zeros((4, n)), np.zeros((4, n))
    transition[:2, :2] = np.moveaxis(moved[:, :2, :2], 0, -1)
    if not corrected:
        hold[:2], rise[:2] = constant, ramp
        return transition, hold, rise
    transition[:2, 2] = constant - ramp
    transition[:2, 3] = ramp / 12
    transition[2, 3] = 1 / 12
    hold[:2], rise[:2] = constant, ramp * 11 / 12
    rise[2], rise[3] = -1 / 12, 1.0
    return transition, hold, rise


def _implicit(compliance: Floats, static: Floats, damping: Floats) -> tuple[Floats, Floats, Floats]:
    """Newmark's formulas with β = 1, γ = 3/2, Λ (2 y''_next - y'') + D y'_next + A y_next = r."""
    n = len(compliance)
    # Displacement and velocity before the new acceleration is added.
    y = np.array([np.ones(n), np.ones(n), np.full(n, -0.5)])
    v = np.array([np.zeros(n), np.ones(n), np.full(n, -0.5)])
    inertia = 2 * compliance + 1.5 * damping + static
    a = (np.array([np.zeros(n), np.zeros(n), compliance]) - damping * v - static * y) / inertia
    transition, load = np.zeros((4, 4, n)), np.zeros((4, n))
    transition[:3, :3] = [y + a, v + 1.5 * a, a]
    load[:3] = np.array([np.ones(n), np.full(n, 1.5), np.ones(n)]) / inertia
    return transition, load, load.copy()


@dataclass(frozen=True)
class Period:
    """Histories of one period, s steps, the last of which ends where the next period begins.

    `u` and `w` (s, N, 3c), m, are the contacts' relative displacements and deviations from
    sticking, `y` (s, k, n) what the deviations add to the modal amplitudes with inertia, `unsolved`
    steps that were not solved; `defect` is the largest change of u and w over the period, over the
    largest amplitude.
    """

    u: Floats
    w: Floats
    y: Complex
    unsolved: int
    defect: float


@dataclass(frozen=True)
class Integrator:
    """A ring at one frequency, rad/s, and what its steps take."""

    ring: FullRing
    omega: float
    arrays: Stepping

    @property
    def steps(self) -> int:
        """Steps a period."""
        return len(self.arrays.linear)

    def stuck(self) -> RingMotion:
        """Steady linear vibration with all contacts stuck as they were assembled."""
        diameters, d, n = self.arrays.rows.shape
        return RingMotion(
            state=np.zeros((diameters, 4, n), complex),
            load=np.zeros((diameters, n), complex),
            static=np.zeros((diameters, d), complex),
            resting=np.zeros((diameters, d), complex),
            u=self.arrays.linear[-1].copy(),
            w=np.zeros((self.ring.sectors, d)),
            awake=np.zeros(len(self.arrays.alpha), bool),
        )

    def balanced(self, response: Response, point: int) -> RingMotion:
        """The motion that a harmonic balance found, every sector at its own instant."""
        motion, step = self.stuck(), TURN / self.omega / self.steps
        n = motion.state.shape[2]
        steady = self.ring.linear(self.omega)
        for h in range(response.harmonics + 1):
            amplitude = self.ring.modal(h, response.x[h][point]) - steady.get(h, 0.0)
            k, mirrored = self.ring.wave(h)
            amplitude[: self.ring.modes[k].rigid] = 0.0  # contacts do not move what nothing holds
            rate = 1j * h * self.omega * step
            for e in range(3):
                moved = amplitude[:n] * rate**e
                if self.ring.weight[k] == 1:
                    motion.state[k, e, : len(moved)] += moved.real
                else:
                    motion.state[k, e, : len(moved)] += (moved.conj() if mirrored else moved) / 2
        angles = TURN * np.arange(-2 * self.steps, 1) / self.steps
        q = response.contact[point].reshape(response.harmonics + 1, -1)
        u = sum(self.ring.travelling(h, q[h], angles) for h in range(response.harmonics + 1))
        path = np.ascontiguousarray(u)
        begun = path[:-2]
        if self.arrays.isotropic:  # what a closed contact was long ago it may remember for long
            begun = path[-3:-2]
            motion.w[:] = self._places(q, begun[0], float(angles[-3]))
        past: list[Complex] = []
        for piece in (begun, path[-3:-1], path[-2:]):  # places at the last three instants
            follow(piece, self.arrays.alpha, self.arrays.isotropic, motion.w)
            past.append(self.pulling(piece[-1], motion.w, self.arrays.linear[len(past) - 3]))
        motion.u[:] = path[-1]
        motion.resting[:] = self.ring.by_diameter(path[-1] - self.arrays.linear[-1])
        motion.load[:] = self._loads(past[2])
        motion.static[:] = np.einsum("kad,ka->kd", self.arrays.rigid, past[2])
        change, before = self._loads(past[2] - past[1]), self._loads(past[1] - past[0])
        corrected = self.arrays.rise[:, 3] > 0
        motion.state[:, 2] = np.where(corrected, (before - change) / 12, motion.state[:, 2])
        motion.state[:, 3] = np.where(corrected, change, 0.0)
        return motion

    def _places(self, q: Complex, u: Floats, angle: float) -> Floats:
        """(N, 3c) deviations at an angle, u (N, 3c) there, on the periodic path of a wave (H, 3c).

        With isotropic friction.
        """
        w = np.minimum(u, 0.0)
        for j in range(self.ring.sectors):
            turned = to_real(q * self.ring.lag(np.arange(len(q)))[:, [j]])
            for c, alpha in enumerate(self.arrays.alpha[:, 0]):
                at = np.array([angle])
                own = slice(3 * c, 3 * c + 3)
                w[j, own][1:] = slider_places(turned[own], float(alpha), at)[0]
        return w

    def pulling(self, u: Floats, w: Floats, linear: Floats) -> Complex:
        """(k, ..., 3c) what pulls at the modes by diameter: w, w less their motion where open."""
        own, pulls = self.ring.modes[0].opened, w.copy()
        pulls[..., own] -= (u - linear)[..., own]
        return self.ring.by_diameter(pulls)

    def _loads(self, deviations: Complex) -> Complex:
        """Modal loads (k, n) of deviations (k, 3c)."""
        loads: Complex = np.einsum(
            "kdn,kd->kn", self.arrays.rows.conj(), deviations * self.ring.stiffness
        )
        return loads

    def period(self, motion: RingMotion) -> Period:
        """Move on by a period."""
        sectors, d = motion.w.shape
        u, w = np.empty((self.steps, sectors, d)), np.empty((self.steps, sectors, d))
        y = np.empty((self.steps, *motion.load.shape), complex)
        began, before = motion.u.copy(), motion.w.copy()
        unsolved = march(self.arrays, motion, u, w, y)
        moved = np.any(w != before, axis=(0, 1)).reshape(-1, 3).any(axis=1)
        motion.awake[:] = moved
        largest = max(np.ptp(u, axis=0).max(initial=0.0) / 2, np.finfo(float).tiny)
        changes = motion.u - began, motion.w - before
        apart = max(np.abs(each).max(initial=0) for each in changes)
        return Period(u, w, y, unsolved, apart / largest)


def integrator(
    ring: FullRing, omega: float, steps: int, modes: int | None = None, isotropic: bool = False
) -> Integrator:
    """Prepare the motion of a ring at ω, rad/s."""
    contacts, step = ring.system.contacts, TURN / omega / steps
    counts = [min(len(m.compliance), modes or len(m.compliance)) for m in ring.modes]
    n, d = max(counts), 3 * contacts.count
    diameters = len(ring.modes)
    rows = np.zeros((diameters, d, n), complex)
    transition, hold = np.zeros((diameters, 4, 4, n)), np.zeros((diameters, 4, n))
    rise = np.zeros_like(hold)
    rigid = np.zeros((diameters, d, d), complex)
    response = np.zeros_like(rigid)
    for k, (kept, found) in enumerate(zip(counts, ring.modes, strict=True)):
        static = None if found.springs is None else found.static[:kept]
        steps_of = _steps_of(found.compliance[:kept], found.damping[:kept], step, static)
        transition[k, :, :, :kept], hold[k, :, :kept], rise[k, :, :kept] = steps_of
        near, far = found.rows[:, :kept], found.rows[:, kept:]
        rows[k, :, :kept] = near
        rigid[k] = (((far / found.static[kept:]) @ far.conj().T) * ring.stiffness).T
        response[k] = rigid[k] + (((near * rise[k, 0, :kept]) @ near.conj().T) * ring.stiffness).T
        own = found.opened
        if len(own):  # their springs answer within the step
            yields = np.eye(len(own)) + response[k][np.ix_(own, own)]
            response[k] -= response[k][:, own] @ np.linalg.solve(yields, response[k][own])
    weighted = response * ring.weight[:, None, None] / ring.sectors
    coupling = np.einsum("kj,kab->jab", ring.shift, weighted).real.copy()
    angles = TURN * np.arange(1, steps + 1) / steps
    linear = np.tile(contacts.offset.reshape(-1), (steps, ring.sectors, 1))
    for h, amplitude in ring.linear(omega).items():
        linear += ring.travelling(h, ring.rows(h) @ amplitude, angles)
    vibration = np.abs(linear - linear.mean(axis=0)).max(initial=0.0)
    arrays = Stepping(
        linear=linear,
        rows=rows,
        transition=transition,
        hold=hold,
        rise=rise,
        rigid=rigid,
        response=response,
        coupling=coupling,
        shift=ring.shift,
        weight=ring.weight,
        stiffness=ring.stiffness,
        alpha=contacts.alpha,
        isotropic=isotropic,
        opened=ring.modes[0].opened,
        small=_SMALL * float(vibration or np.abs(linear).max(initial=1.0)),
    )
    return Integrator(ring, omega, arrays)


def check_start(
    ring: FullRing, frequency: float, friction: str, response: Response, point: int
) -> None:
    """Refuse a start that is another system's, another law's or another frequency's."""
    if not 0 <= point < response.points:
        raise InputError(f"start: given point {point}: the response has {response.points}")
    if (response.friction, response.coupling) != (friction, "coupled"):
        raise InputError(
            f"start: given a response with {response.friction} friction, {response.coupling}: "
            f"needs one with {friction} friction, coupled"
        )
    given = float(response.frequency[point])
    if abs(given - frequency) > 1e-9 * frequency:
        raise InputError(f"start: given a point at {given} Hz: needs one at {frequency} Hz")
    expected = [ring.system.nodal_diameter(h) for h in range(response.harmonics + 1)]
    if list(response.harmonic_diameters) != expected:
        raise InputError(
            f"start: given harmonics at nodal diameters {list(response.harmonic_diameters)}: a "
            f"wave has them at {expected}"
        )
    if response.contact.shape[2] != ring.system.contacts.count:
        raise InputError(
            f"start: given {response.contact.shape[2]} contacts: the system has "
            f"{ring.system.contacts.count}"
        )
