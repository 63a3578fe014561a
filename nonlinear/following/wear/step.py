"""One step of wear over cycles, by Heun's rule.

With r(v0) the depth worn in a cycle, the interference after h cycles is

    v* = v0 - h r(v0),      v0(h) = v0 - h/2 (r(v0) + r(v*)),

whose error over a given number of cycles falls with the square of h. Between both ends the
interference is the parabola of these slopes. A step changes the interference of no contact by more
than a share of it, or of its largest normal displacement where that is larger; and it is halved
where rates change by more than five times that share, at most a quarter, as near a fold, where
friction begins to slip or where a peak is lost.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.following.wear.archard import Archard
from vanelock.nonlinear.following.wear.vibration import Vibration

Floats = NDArray[np.float64]

CHANGE = 0.25
"""Of the largest rate: how far rates may change in a step, and beyond which they jump."""
FINER = 5.0
"""How far rates may change at most, over the share of the interference that a step may.

Near a fold rates change fast while the interference hardly does: unless what is allowed of theirs
shrinks as well, a smaller share makes no smaller steps there.
"""
SHORTEST = 1 / 64
"""Of the step that the interference allows."""


@dataclass(frozen=True)
class WearStep:
    """A step.

    Attributes
    ----------
    cycles : float
        h.
    begin : (c,) float
        Interference before it, m.
    rates : (2, c) float
        Depth worn in a cycle before it and at its first guess, m.
    end : Vibration
        After it.
    jumped : bool
        Whether the vibration changed at once: rates by more than a quarter in the shortest step, or
        to another peak.
    solved : int
        Vibrations that were looked for.
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
    enough = min(CHANGE, FINER * share)
    while True:
        last = h <= SHORTEST * cycles
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
                    jumped = change > CHANGE * largest or guess.swept or end.swept
                    return WearStep(h, begin.v0, np.array([rate, other]), end, jumped, solved)
        if last:
            return None
        h *= 0.5
