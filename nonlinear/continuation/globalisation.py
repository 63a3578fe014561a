"""Ways to a solution where no neighbouring one is known.

One is from contacts that are soft, so that nothing happens suddenly, to contacts as they are.
Springs s kₙ and s kₜ, 0 < s <= 1, leave the ratio that friction is bounded by, μ kₙ/kₜ, as it is:
the force s K_c (u - W(u)) of soft contacts is that of true ones with the deviation

    W_s(u) = (1 - s) u + s W(u).

At s = 0 there are no contacts at all. With s small the free structure presses against something
soft, and has one response near its own.

Another is from contacts held by force, so that all stick, to contacts as they are. Lifting off is
judged by v + p·a, friction by v + p·b, with a and b so large that at p = 1 every contact sticks
under the linear response; at p = 0 the contact is itself. Each contact has its own a and b, of the
size that it needs: with one preload for all, as high as the contact of least friction asks for, all
that happens on the way would happen in the last millionth of it.
"""

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from itertools import islice
from math import log

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.contact.law import Deviation, Law
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.families import Laws, Loads, fixed
from vanelock.nonlinear.fourier import resized
from vanelock.nonlinear.newton.newton import TOLERANCE, Family, Solution, solve
from vanelock.nonlinear.newton.preconditioner import response_to

_SURPLUS = 1.1
_LEAST = 1e-3  # of the largest displacement, for contacts that hardly move
EFFORT = 3000
"""Newton steps by default that a solution may take where no neighbouring one is known."""
_EFFORTS = (300, 3000)  # of them on a path: every one for a while before any for long
_SOFTEST = (1e-2, 1e-4)  # shares of the contacts' stiffness to begin with
_SHORTEST = 1e-6
"""Shortest step on a path, relative to all of it: where sticking ends, vibrating parts may be small
beside the mean, and a path may turn back at once."""


@dataclass(frozen=True, kw_only=True)
class _SoftLaw(Law):
    """The law of contacts with the share s of their stiffness."""

    share: float

    def __call__(self, u: Floats, omega: float = 0.0) -> Deviation:
        """Evaluate at the relative displacements (c, 3, 2H + 1), m, of (v, u1, u2)."""
        found = super().__call__(u, omega)
        width = 3 * u.shape[2]
        jacobian = self.share * found.jacobian.reshape(len(u), width, width)
        jacobian += (1 - self.share) * np.eye(width)
        w = (1 - self.share) * u + self.share * found.w
        return Deviation(w, jacobian.reshape(found.jacobian.shape), found.state, found.dissipation)


@dataclass(frozen=True)
class _Hardening(Laws):
    """Problems at one load whose contacts have the share s = softest^(1 - p) of their stiffness."""

    softest: float

    def law(self, parameter: float) -> _SoftLaw:
        """The law at a value of the parameter."""
        share = float(self.softest ** (1 - min(parameter, 2.0)))
        return _SoftLaw(**vars(self.friction), share=share)

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Integers) -> Floats:
        """dW/dp at fixed w, on the given components of w: (W_s - u)/s · ds/dp."""
        beyond = (deviation.w - self.balance.displacement(w)).reshape(-1)[rows]
        return np.asarray(-log(self.softest) * beyond)


@dataclass(frozen=True, kw_only=True)
class _HeldLaw(Law):
    """The law of contacts that are pressed and held back from outside.

    Both (c,), m, are added to v, where contacts lift off and where friction is bounded.
    """

    pressed: Floats
    held: Floats

    def __call__(self, u: Floats, omega: float = 0.0) -> Deviation:
        """Evaluate at the relative displacements (c, 3, 2H + 1), m, of (v, u1, u2)."""
        shifted = u.copy()
        shifted[:, 0, 0] = u[:, 0, 0] + self.held
        found = super().__call__(shifted, omega)
        shifted[:, 0, 0] = u[:, 0, 0] + self.pressed
        smooth = replace(self, alpha=np.zeros_like(self.alpha))
        normal = super(_HeldLaw, smooth).__call__(shifted, omega)
        found.w[:, 0] = normal.w[:, 0]
        found.jacobian[:, 0] = normal.jacobian[:, 0]
        return found


@dataclass(frozen=True)
class _Release(Laws):
    """Problems at one load, contacts held as by `_HeldLaw` at p = 1 and themselves at p = 0."""

    pressed: Floats
    held: Floats

    def law(self, parameter: float) -> _HeldLaw:
        """The law at a value of the parameter."""
        pressed, held = parameter * self.pressed, parameter * self.held
        return _HeldLaw(**vars(self.friction), pressed=pressed, held=held)

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Integers) -> Floats:
        """dW/dp at fixed w, on the given components of w."""
        moved = np.zeros_like(w)
        moved[:, 0, 0] = self.pressed
        lifting = response_to(deviation, rows, moved)
        moved[:, 0, 0] = self.held
        sliding = response_to(deviation, rows, moved)
        return np.where(rows // w.shape[2] % 3 == 0, lifting, sliding)


def _released(balance: Balance, law: Law) -> _Release:
    """The family from contacts that all stick, held as much as each needs, to `law`."""
    size = np.abs(balance.linear).sum(axis=2)
    if law.isotropic:  # friction has to hold both directions at once
        size[:, 1:] = np.hypot(size[:, 1], size[:, 2])[:, None]
    least = _LEAST * size.max(initial=0.0)
    pressed = _SURPLUS * size[:, 0] + least
    alpha = np.where(law.alpha > 0, law.alpha, np.inf)
    held = pressed + _SURPLUS * ((size[:, 1:] + least) / alpha).max(axis=1)
    pressed[list(law.elements)] = held[list(law.elements)] = 0.0
    return _Release(balance, law, pressed, held)


@dataclass
class Effort:
    """Newton steps that are left for a solution, and who hears of each attempt."""

    left: int = EFFORT
    attempted: Callable[[], None] = lambda: None

    def spent(self, solution: Solution) -> Solution:
        """The solution, its steps taken off."""
        self.left -= solution.iterations
        return solution


def from_nothing(
    balance: Balance,
    law: Callable[[int], Law],
    tolerance: float = TOLERANCE,
    effort: Effort | None = None,
) -> Solution:
    """Solve a balance without a start, by what works, the cheapest first."""
    spent = 0
    best: Solution | None = None
    for attempt in _attempts(balance, law, tolerance, effort or Effort()):
        spent += attempt.iterations
        if best is None or attempt.converged or not best.residual <= attempt.residual:
            best = attempt
        if attempt.converged:
            break
    assert best is not None
    return replace(best, iterations=spent, parameter=balance.omega)


def at_once(balance: Balance, law: Callable[[int], Law], tolerance: float = TOLERANCE) -> Solution:
    """Solve a balance without a start by Newton's iteration, or by raising H, but no more."""
    for attempt in islice(_attempts(balance, law, tolerance, Effort()), 2):
        if attempt.converged:
            break
    return attempt


def _attempts(
    balance: Balance, law: Callable[[int], Law], tolerance: float, effort: Effort
) -> Iterator[Solution]:
    harmonics = (balance.linear.shape[2] - 1) // 2
    top = law(harmonics)
    still = np.zeros_like(balance.linear)
    yield effort.spent(solve(fixed(balance, top), still, 0.0, tolerance=tolerance))
    raised = yield from _raise_harmonics(balance, law, tolerance, effort)
    release = _Way(_released(balance, top), still, 1.0, 0.0)
    hardenings = (_Hardening(balance, top, softest) for softest in _SOFTEST)
    harden = [_Way(each, still, 0.0, 1.0, limit=40, shortest=1e-5) for each in hardenings]
    ways = [harden, _raise_force(balance, top, raised), [release]]
    for most in _EFFORTS:
        for starts in ways:
            if effort.left <= 0:
                return
            effort.attempted()
            for way in starts:
                begun = effort.spent(
                    solve(way.family, way.start, way.begin, tolerance=tolerance, limit=way.limit)
                )
                if begun.converged:
                    arc = follow(
                        way.family,
                        begun,
                        way.target,
                        tolerance,
                        limit=600,
                        effort=min(most, effort.left),
                        shortest=way.shortest,
                    )
                    effort.left -= arc.iterations
                    if arc.solution is not None:
                        yield arc.solution
                    break


def _raise_harmonics(
    balance: Balance, law: Callable[[int], Law], tolerance: float, effort: Effort
) -> Generator[Solution, None, Floats | None]:
    """Solve with 0, 1, ... H harmonics, each from the last; returns the static deviation."""
    harmonics = (balance.linear.shape[2] - 1) // 2
    w: Floats = np.zeros((*balance.linear.shape[:2], 1))
    static: Floats | None = None
    for h in range(harmonics + 1):
        cut = balance.with_harmonics(h)
        begin = resized(w, h)
        found = effort.spent(solve(fixed(cut, law(h)), begin, 0.0, tolerance=tolerance, limit=25))
        if h == harmonics:
            yield found
        if found.converged or h > 0:
            w = found.w
        if h == 0 and found.converged:
            static = found.w
    return static


@dataclass(frozen=True)
class _Way:
    """A family that leads to the problem at `target`, and where it begins, with a guess of w there.

    `limit` is of Newton steps at the beginning, `shortest` of steps on the way.
    """

    family: Family
    start: Floats
    begin: float
    target: float
    limit: int = 15
    shortest: float = _SHORTEST


def _raise_force(balance: Balance, law: Law, static: Floats | None) -> list[_Way]:
    """From the static state, raise all that vibrates from nothing to its full amplitude."""
    if static is None or balance.linear.shape[2] == 1:
        return []
    direction = balance.linear.copy()
    direction[:, :, 0] = 0.0
    still = replace(balance, linear=balance.linear - direction)
    start = np.zeros_like(balance.linear)
    start[:, :, 0] = static[:, :, 0]
    return [_Way(Loads(still, direction, law), start, 0.0, 1.0)]
