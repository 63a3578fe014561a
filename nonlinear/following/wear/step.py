"""One step of wear over cycles, by Heun's rule.

With r(v0) the depth worn in a cycle, the interference after h cycles is

    v* = v0 - h r(v0),      v0(h) = v0 - h/2 (r(v0) + r(v*)),

whose error over a given number of cycles falls with the square of h. Between both ends the
interference is the parabola of these slopes. A step changes the interference of no contact by more
than a share of it, or of its largest normal displacement where that is larger; and it is halved
where rates change by more than five times that share, at most a quarter, as near a fold, where
friction begins to slip or where a peak is lost.

The rate r is Archard's law, what a contact loses in a period of its vibration,

    dv0/dN = -(k / A) ∮ n |dw|,

v0 the interference, n the normal force, w the path of the friction slider, A the contact's area, k
the wear coefficient of both surfaces together (J. F. Archard, J. Appl. Phys. 24 (1953) 981-988).
The friction work of the contact law is μ ∮ n |dw|: of the path in the tangential plane where
friction is isotropic; where it is orthogonal, of both directions one by one, |dw| = |dw₁| + |dw₂|,
which is up to √2 of the path in the plane.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Floats, as_array
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.stuck_modes import StuckModes, stuck_modes
from vanelock.nonlinear.contact.law import Deviation
from vanelock.nonlinear.following.wear.vibration import Vibration
from vanelock.nonlinear.forced_response.frequency_response import static_response
from vanelock.nonlinear.forced_response.options import Options
from vanelock.rom.system.system import Contacts, System


@dataclass(frozen=True)
class Archard:
    """The law of wear of c contacts with friction coefficients `mu`, (c,).

    `depth` (c,), 1/N, is k / A, by normal load and slip distance; 0 for what does not wear.
    """

    depth: Floats
    mu: Floats

    def rate(self, deviation: Deviation) -> Floats:
        """(c,) depth worn in a period, both surfaces together, m."""
        worn = self.depth > 0
        slid = np.zeros(len(worn))
        np.divide(deviation.dissipation, self.mu, out=slid, where=worn)
        return np.where(worn, self.depth * np.maximum(slid, 0.0), 0.0)


def checked_archard(contacts: Contacts, coefficient: ArrayLike, area: ArrayLike) -> Archard:
    """The law of wear of these contacts."""
    k = _of_contacts(coefficient, "coefficient", "m²/N", contacts.count)
    A = _of_contacts(area, "area", "m²", contacts.count)
    if (k < 0).any():
        raise InputError(f"coefficient: given {k.min():g} m²/N: must be >= 0")
    if not (A > 0).all():
        raise InputError(f"area: given {A.min():g} m²: must be > 0")
    k = np.where(contacts.springs, k, 0.0)
    if (smooth := (k > 0) & (contacts.mu == 0)).any():
        i = int(np.argmax(smooth))
        raise InputError(
            f"coefficient: given {k[i]:g} m²/N of contact {i}, whose mu is 0: "
            "wear follows from friction work; needs mu > 0 or a coefficient of 0"
        )
    return Archard(k / A, contacts.mu)


def _of_contacts(values: ArrayLike, name: str, unit: str, count: int) -> Floats:
    """A finite number of each contact."""
    found = as_array(values, name)
    if found.shape not in ((), (count,)):
        raise InputError(
            f"{name}: given shape {found.shape}: needs a number in {unit}, or one of each of the "
            f"{count} contacts"
        )
    if not np.isfinite(found).all():
        raise InputError(f"{name}: given {found[~np.isfinite(found)][0]}: must be finite")
    return np.broadcast_to(found, count).astype(float)


@dataclass(frozen=True)
class Rest:
    """Joints at rest: by joint (j,) the sum of the normal forces of its contacts in a sector, N.

    `approach` (j,), m, is the largest normal displacement among them; none is closed below zero.
    """

    load: Floats
    approach: Floats
    converged: bool


@dataclass(frozen=True)
class Preload:
    """Finds joints at rest, all that consist of contacts, by the interference of all contacts.

    Of `modes` those of nodal diameter 0, which wear does not change.
    """

    system: System
    options: Options
    joints: tuple[str, ...]
    modes: dict[int, StuckModes]

    def at(self, v0: Floats) -> Rest:
        """The joints at an interference, (c,) m."""
        contacts = replace(self.system.contacts, v0=v0)
        found = static_response(replace(self.system, contacts=contacts), self.options, self.modes)
        v = found.contact[0, 0, :, 0].real
        n = contacts.kn * np.maximum(v, 0.0)
        members = [contacts.of(joint) & contacts.springs for joint in self.joints]
        load = np.array([n[each].sum() for each in members])
        approach = np.array([v[each].max() for each in members])
        return Rest(load, approach, bool(found.converged[0]))


def preload(system: System, options: Options) -> Preload:
    """What finds the joints of a system at rest."""
    contacts = system.contacts
    named = zip(contacts.joints, contacts.springs, strict=True)
    joints = tuple(dict.fromkeys(joint for joint, spring in named if spring))
    return Preload(system, options, joints, {0: stuck_modes(system, 0)})


_CHANGE = 0.25
"""Of the largest rate: how far rates may change in a step, and beyond which they jump."""
_FINER = 5.0
"""How far rates may change at most, over the share of the interference that a step may.

Near a fold rates change fast while the interference hardly does: unless what is allowed of theirs
shrinks as well, a smaller share makes no smaller steps there.
"""
_SHORTEST = 1 / 64  # of the step that the interference allows


@dataclass(frozen=True)
class WearStep:
    """A step of h `cycles` to the vibration `end`; `solved` vibrations were looked for.

    `begin` (c,), m, is the interference before it, `rates` (2, c), m, the depth worn in a cycle
    before it and at its first guess; `jumped`: the vibration changed at once, rates by more than a
    quarter in the shortest step, or to another peak.
    """

    cycles: float
    begin: Floats
    rates: Floats
    end: Vibration
    jumped: bool
    solved: int

    def interference(self, share: float) -> Floats:
        """(c,) interference after a share of the step, m."""
        before, after = self.rates
        worn = share * before + 0.5 * share**2 * (after - before)
        return np.asarray(self.begin - self.cycles * worn)


def allowed(vibration: Vibration, rate: Floats, share: float) -> float:
    """Cycles in which no contact's interference changes by more than a share."""
    worn = rate > 0
    if not worn.any():
        return np.inf
    return float(share * (vibration.size[worn] / rate[worn]).min())


def stepped(
    begin: Vibration,
    law: Archard,
    cycles: float,
    share: float,
    following: Callable[[Vibration, Floats], Vibration | None],
) -> WearStep | None:
    """One step of so many cycles or fewer; None where no vibration is found after the shortest."""
    rate, solved, h = law.rate(begin.solution.deviation), 0, cycles
    enough = min(_CHANGE, _FINER * share)
    while True:
        last = h <= _SHORTEST * cycles
        guess = following(begin, begin.v0 - h * rate)
        solved += 1
        if guess is not None:
            other = law.rate(guess.solution.deviation)
            largest = max(rate.max(initial=0.0), other.max(initial=0.0))
            change = np.abs(other - rate).max(initial=0.0)
            if last or change <= enough * largest:
                end = following(guess, begin.v0 - 0.5 * h * (rate + other))
                solved += 1
                if end is not None:
                    jumped = change > _CHANGE * largest or guess.swept or end.swept
                    return WearStep(h, begin.v0, np.array([rate, other]), end, jumped, solved)
        if last:
            return None
        h *= 0.5
