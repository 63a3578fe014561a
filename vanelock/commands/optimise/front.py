"""The front of largest peak against wear: values that lower neither without raising the other.

Worn at a peak is, by Archard's law,

    W = ω/2π Σ_c k_c E_c / μ_c,

E the friction work of a contact in a period, k its joint's wear coefficient. For ratios r = 1,
√2, 2, ... the larger of A/A₁ and r W/W₁ is made the smallest (Chebyshev's scalarisation;
K. Miettinen, Nonlinear multiobjective optimization, 1999, section 3.4); r = 1 is where the largest
peak A₁ is smallest, and W₁ the wear there. Each search begins at the lower one of the values before
and of the best among places all over the bounds, tried with one harmonic.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vanelock.commands.fit.parameters import FitParameter
from vanelock.commands.optimise.minimax import Functions
from vanelock.commands.optimise.peaks import Peaks
from vanelock.commands.optimise.search import (
    TRIALS,
    FrontPoint,
    Optimum,
    Progress,
    bounds_of,
    searched,
    spread,
)
from vanelock.common.arrays import Floats
from vanelock.nonlinear.following.peak import CurvePoint
from vanelock.nonlinear.fourier import TURN
from vanelock.pipeline.progress import Listener, silent
from vanelock.rom.system.system import Contacts

RATIO = np.sqrt(2.0)
"""Of one point's r to that of the one before."""
CLOSER = 1e-2
"""Relative difference of wear below which two points are one."""
STEP = 1e-3
"""Of x, over which wear is differenced."""


@dataclass
class PeaksAndWear:
    """Peaks beside the wear at them, as multiples of what these are at the first point.

    Attributes
    ----------
    peaks : Peaks
    coefficient : mapping of str to float
        Wear coefficient by joint, m²/N.
    peak, wear : float
        Those of the first point, m and m³/s.
    ratio : float
        r.
    """

    peaks: Peaks
    coefficient: Mapping[str, float]
    peak: float
    wear: float
    ratio: float

    @property
    def parameters(self) -> Sequence[FitParameter]:
        """What varies."""
        return self.peaks.parameters

    def __call__(self, x: Floats) -> Functions | None:
        """Peaks that are followed to x, and wear, with their gradients."""
        return self._beside(self.peaks, x)

    def afresh(self, x: Floats) -> Functions | None:
        """The same of the peaks that the whole range has."""
        return self._beside(self.peaks.afresh, x)

    def _beside(self, of: Callable[[Floats], Functions | None], x: Floats) -> Functions | None:
        peaks = of(x)
        if peaks is None:
            return None
        value = worn(self.peaks, x, self.peaks.known, self.coefficient)
        gradient = np.zeros((len(value), len(x)))
        for i in range(len(x)):
            there = x.copy()
            there[i] += STEP
            moved = self.peaks.moved(there)
            if not moved:
                return None
            gradient[:, i] = (worn(self.peaks, there, moved, self.coefficient) - value) / STEP
        share = self.ratio / self.wear
        return Functions(
            np.append(peaks.value / self.peak, share * value),
            np.vstack([peaks.gradient / self.peak, share * gradient]),
        )


def worn(
    peaks: Peaks, x: Floats, known: Sequence[CurvePoint], coefficient: Mapping[str, float]
) -> Floats:
    """(j,) volume worn in a second at each of the known peaks at x, m³/s."""
    contacts = peaks.model.system(peaks.values(x)).contacts
    lost = _volume_by_work(contacts, coefficient)
    work = np.array([each.solution.deviation.dissipation for each in known])
    rate = np.array([each.solution.omega for each in known]) / TURN
    return np.asarray(rate * (np.maximum(work, 0.0) @ lost))


def _volume_by_work(contacts: Contacts, coefficient: Mapping[str, float]) -> Floats:
    """(c,) volume that a contact loses for the friction work done on it, k/μ, m³/J."""
    k = np.array([coefficient.get(joint, 0.0) for joint in contacts.joints])
    found = np.zeros(contacts.count)
    np.divide(k, contacts.mu, out=found, where=contacts.springs & (contacts.mu > 0))
    return found


def front(
    peaks: Peaks,
    begun: Optimum,
    coefficient: Mapping[str, float],
    count: int,
    starts: int = 0,
    listener: Listener = silent,
) -> list[FrontPoint]:
    """The front from where the largest peak is smallest towards less wear."""

    def point(x: Floats, settled: bool) -> FrontPoint:
        largest = max(each.amplitude for each in peaks.known)
        wear = float(worn(peaks, x, peaks.known, coefficient).max())
        value = np.array(list(peaks.values(x).values()))
        return FrontPoint(value, largest, wear, settled)

    x = np.array([p.inner(v) for p, v in zip(peaks.parameters, begun.value, strict=True)])
    found = [point(x, begun.settled)]
    first = found[0]
    if not first.wear > 0:
        return found
    tried = _tried(peaks, starts, coefficient, Progress(listener, starts))
    progress = Progress(listener, (count - 1) * TRIALS, "peak or wear", "of the first point", 1.0)
    for i in range(1, count):
        ratio, progress.least = RATIO**i, np.inf
        both = PeaksAndWear(peaks, coefficient, first.peak, first.wear, ratio)
        last = peaks.known
        here = progress(both, x)
        sizes = [max(peak / first.peak, ratio * wear / first.wear) for _, peak, wear in tried]
        if sizes and (here is None or min(sizes) < here.largest):
            other = tried[int(np.argmin(sizes))][0]
            peaks.known = []
            there = progress(both, other)
            if here is not None and (there is None or there.largest > here.largest):
                peaks.known, peaks.place = last, x
            else:
                x = other
        place = searched(both, x, progress)
        if place is None:
            break
        x = place.x
        found.append(point(x, place.settled))
    return undominated(found)


def undominated(points: Sequence[FrontPoint]) -> list[FrontPoint]:
    """Those that wear less than all that have a smaller peak, by falling wear."""
    kept: list[FrontPoint] = []
    for each in sorted(points, key=lambda point: (point.peak, point.wear)):
        if not kept or each.wear < (1 - CLOSER) * kept[-1].wear:
            kept.append(each)
    return kept


def _tried(
    peaks: Peaks, starts: int, coefficient: Mapping[str, float], progress: Progress
) -> list[tuple[Floats, float, float]]:
    """Places with their largest peak, m, and most wear, m³/s, by one harmonic."""
    single, found = peaks.with_one_harmonic(), []
    for x in spread(*bounds_of(peaks.parameters), starts) if starts else ():
        single.known = []
        if progress(single, x) is not None:
            largest = max(each.amplitude for each in single.known)
            wear = float(worn(single, x, single.known, coefficient).max())
            found.append((x, largest, wear))
    return found
