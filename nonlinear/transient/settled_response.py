"""What a ring does instead of a periodic wave: integrated in time until its statistics settle.

The ring sets out from a wave that a harmonic balance found, slightly disturbed, and every sector is
followed period after period. What settles need not be periodic, so it is judged by statistics: half
the peak-to-peak of every output in every sector and period. Of P periods the last third is
compared with the third before it, at P that grows by half from one comparison to the next, until

* every period repeats the one before, and does so better in the last third: STEADY; or
* mean, largest and smallest amplitudes of both thirds agree, and so does the size of what changes
  from one period to the next, which is well above what the disturbance made it: MODULATED.

Either only after 2 ln(1/d)/ln|μ| periods, d the disturbance and μ the largest multiplier of the
wave: a motion that has grown from d may seem settled while another is on its way.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from vanelock.common.arrays import Floats, as_whole
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.contact.law import check_friction
from vanelock.nonlinear.floquet.stability import stability
from vanelock.nonlinear.forced_response.options import check_band
from vanelock.nonlinear.forced_response.response import Response, check_contacts
from vanelock.nonlinear.fourier import TURN, one_thread
from vanelock.nonlinear.transient.full_ring import ring
from vanelock.nonlinear.transient.integration import Integrator, check_start, integrator
from vanelock.nonlinear.transient.time_marching import RingMotion
from vanelock.nonlinear.transient.time_response import departure, output_history
from vanelock.rom.system.system import System

STEADY, MODULATED, UNSETTLED = 0, 1, 2
_VERDICTS = f"{STEADY} steady, {MODULATED} modulated, {UNSETTLED} not settled"

_ALIKE = 1e-4  # defect below which a period repeats the one before
_REPEATED = 1e-7
"""Defect at which it need not get any smaller: what steps are solved to leaves some 1e-8."""
_FADED = 0.01
"""Of the largest defect of all periods, what a steady motion's is at most: a motion that grows
slowly is hidden at first under those that die out."""
_GROWS = 1.15  # ratio of the mean defects of two windows from which a motion is still changing
_LEFT = 3.0
"""Defect of a modulated motion over that of the first period, at least: what is smaller may be the
disturbance yet, growing or dying out."""
_FIRST = 48  # periods before statistics are compared first
_MORE = 1.5  # from one comparison to the next
_SAME = 0.05
"""Departure up to which a steady motion is the balance's wave: truncation and time step differ."""


@dataclass(frozen=True)
class SettledResponse(Product):
    """A ring followed for P periods from a wave: N sectors, o output nodes.

    Amplitudes are half the peak-to-peak within a period, m. The statistics are those of the last
    `window` periods, over them and all sectors.

    Attributes
    ----------
    frequency : float
        Of the excitation, Hz.
    verdict : int
        STEADY, MODULATED or UNSETTLED.
    amplitude : (P, N, o, 3) float
        By period and sector.
    balance : (o, 3) float
        Of the wave that it set out from, all sectors alike.
    mean, largest, smallest : (o, 3) float
        Statistics.
    window : int
        Periods that they are of.
    defect : (P,) float
        By period, how far contacts and sliders are at its end from where they were at its
        beginning, relative to the largest vibration of a contact.
    departure : (P,) float
        By period, how far it is from the wave, as of `TimeResponse`.
    disturbance : float
        Of the modes' velocities at the beginning, relative to those that the wave gives them.
    steps : int
        A period.
    unsolved : int
        Steps in all whose contacts were not solved to round-off.
    """

    frequency: float = field(metadata={"unit": "Hz"})
    verdict: int = field(metadata={"codes": _VERDICTS})
    amplitude: Floats = field(metadata={"unit": "m"})
    balance: Floats = field(metadata={"unit": "m"})
    mean: Floats = field(metadata={"unit": "m"})
    largest: Floats = field(metadata={"unit": "m"})
    smallest: Floats = field(metadata={"unit": "m"})
    window: int
    defect: Floats
    departure: Floats
    disturbance: float
    steps: int
    unsolved: int

    @property
    def periods(self) -> int:
        """P."""
        return len(self.defect)

    @property
    def returned(self) -> bool:
        """Whether it is steady and the balance's wave, to its truncation."""
        return self.verdict == STEADY and bool(self.departure[-1] < _SAME)


@one_thread
def settled_response(
    system: System,
    response: Response,
    point: int,
    steps: int = 128,
    periods: int = 1000,
    least: int = 0,
    tolerance: float = 0.02,
    disturbance: float = 1e-4,
    seed: int = 0,
    modes: int | None = None,
    growth: float | None = None,
    progress: Callable[[int, int, float], None] | None = None,
) -> SettledResponse:
    """Follow a ring from a wave of harmonic balance until what it does has settled.

    Parameters
    ----------
    system : System
        The one that was solved, with the nodal diameters 0 ... N/2.
    response : Response
        Coupled; its own friction and coefficients of friction count.
    point : int
        Of the response, converged.
    steps : int
        A period; the error falls with their square.
    periods : int
        Periods followed, at most.
    least : int
        Periods followed at least; never fewer than 2 ln(1/disturbance)/ln|μ|, |μ| the largest
        multiplier of the wave, where that is above 1.
    tolerance : float
        To which mean, largest and smallest amplitudes of two windows agree, relative to the largest
        amplitude of that output node.
    disturbance : float
        Standard deviation of what is added to every mode's velocity at all nodal diameters,
        relative to the velocity that the wave gives the mode. 0: growth begins at what truncation
        and time step leave, no less than 1e-7.
    seed : int
        Of the disturbance.
    modes : int, optional
        As of `time_response`.
    growth : float, optional
        Of the wave, f ln|μ|, 1/s; by default the least positive one that `stability` finds by its
        two truncations.
    progress : callable, optional
        Called after each period with (periods done, periods at most, defect).

    Returns
    -------
    SettledResponse
        UNSETTLED where the periods did not suffice; its statistics are then of the last ones.

    Notes
    -----
    What settles may depend on where the ring sets out: other motions may exist beside it. Contacts
    that rest begin unstressed, as in the balance; once moved they stay where they have been put.

    Raises
    ------
    InputError
        If the point does not exist, did not converge or is not of this system, a nodal diameter is
        missing, the stuck modes do not diagonalise a given C, an option is out of range, or no
        growth is given and `stability` is not of such a response.
    """
    for name, value, lowest in (
        ("point", point, 0),
        ("steps", steps, 4 * response.harmonics + 4),
        ("periods", periods, _FIRST),
        ("least", least, 0),
        ("seed", seed, 0),
        ("modes", 1 if modes is None else modes, 1),
    ):
        if as_whole(value, name) < lowest:
            raise InputError(f"{name}: given {value}: allowed: {lowest} or more")
    for name, part in (("tolerance", tolerance), ("disturbance", disturbance)):
        if not 0 <= part < 1:
            raise InputError(f"{name}: given {part}: allowed: from 0 to below 1")
    _check(system, response, point)
    system = replace(system, contacts=replace(system.contacts, mu=response.mu))
    frequency = float(response.frequency[point])
    whole = ring(system, every=True)
    check_start(whole, frequency, response.friction, response, point)
    if growth is None:
        growths = stability(system, response, [point]).growth
        growth = min((float(each) for each in growths[0] if each > 0), default=0.0)
    if growth > 0:
        decades = np.log(1 / max(disturbance, _REPEATED))
        least = max(least, int(min(np.ceil(2 * decades * frequency / growth), periods + 1)))
    stepped = integrator(whole, TURN * frequency, steps, modes, response.friction == "isotropic")
    motion = stepped.balanced(response, point)
    _disturb(stepped, motion, response, point, disturbance, seed)
    outputs = whole.sectors, len(system.output_names), 3
    amplitudes, defects, departures = list[Floats](), list[float](), list[float]()
    judged, unsolved, verdict = _FIRST, 0, UNSETTLED
    for done in range(1, periods + 1):
        found = stepped.period(motion)
        output = output_history(stepped, found)
        defects.append(found.defect)
        departures.append(departure(stepped, found, output, response, point))
        amplitudes.append(_half_range(output).reshape(outputs))
        unsolved += found.unsolved
        if progress is not None:
            progress(done, periods, found.defect)
        if done < judged:
            continue
        judged = min(int(_MORE * judged), periods)
        amplitude, defect = np.array(amplitudes), np.array(defects)
        if not np.isfinite(amplitude).all():
            break
        if done >= least and (verdict := _verdict(amplitude, defect, tolerance)) != UNSETTLED:
            break
    window = max(done // 3, 1)
    mean, largest, smallest = _statistics(amplitude[-window:])
    return SettledResponse(
        frequency=frequency,
        verdict=verdict,
        amplitude=amplitude,
        balance=response.amplitude[point],
        mean=mean,
        largest=largest,
        smallest=smallest,
        window=window,
        defect=defect,
        departure=np.array(departures),
        disturbance=disturbance,
        steps=steps,
        unsolved=unsolved,
    )


def _check(system: System, response: Response, point: int) -> None:
    """Refuse what cannot be followed."""
    if point >= response.points:
        raise InputError(f"point: given {point}: there are {response.points}, counted from 0")
    if not response.converged[point]:
        raise InputError(f"point: given {point}: it did not converge, and is no wave to start from")
    if not response.harmonics or response.frequency[point] <= 0:
        raise InputError("response: at rest: what is followed is a vibration")
    check_band(system, [float(response.frequency[point])])
    check_friction(system.contacts, response.friction)
    check_contacts(response, system.contacts)


def _disturb(
    stepped: Integrator, motion: RingMotion, response: Response, point: int, size: float, seed: int
) -> None:
    """Add to every mode's velocity a share of what the wave gives that mode, drawn by chance."""
    whole, rates = stepped.ring, motion.state[:, 1]
    speed = np.zeros(rates.shape[1])
    for h in range(1, response.harmonics + 1):
        a = np.abs(whole.modal(h, response.x[h][point]))[: len(speed)]
        k, _ = whole.wave(h)
        speed[whole.modes[k].rigid : len(a)] += h * a[whole.modes[k].rigid :]
    rng = np.random.default_rng(seed)
    real, imaginary = rng.standard_normal((2, *rates.shape))
    travels = whole.weight[:, None] == 2
    push = np.where(travels, (real + 1j * imaginary) / 2, real)
    for k, found in enumerate(whole.modes):
        push[k, : found.rigid] = 0.0  # what nothing holds would not come back
        push[k, len(found.compliance) :] = 0.0
    rates += size * TURN / stepped.steps * speed * push


def _half_range(history: Floats) -> Floats:
    """(...) half the peak-to-peak of samples (s, ...), by parabolas through their extremes.

    The first sample is the one after the period began.
    """
    tops = []
    for sign in (1.0, -1.0):
        signed = sign * history
        top = signed.argmax(axis=0)
        at = np.clip(top, 1, len(history) - 2)[None]
        before, here, after = (np.take_along_axis(signed, at + i, axis=0)[0] for i in (-1, 0, 1))
        bend = np.minimum(before - 2 * here + after, 0.0)
        slope = (after - before) / 2
        share = np.divide(-slope, bend, out=np.zeros_like(bend), where=bend < 0)
        share = np.clip(share, np.where(top, -1, -2), 1)  # a period begins before its first sample
        vertex = here + slope * share + bend * share**2 / 2
        tops.append(np.maximum(vertex, signed.max(axis=0)))
    return np.asarray((tops[0] + tops[1]) / 2)


def _statistics(amplitude: Floats) -> tuple[Floats, Floats, Floats]:
    """Mean, largest and smallest (o, 3) of amplitudes (P, N, o, 3)."""
    return amplitude.mean((0, 1)), amplitude.max((0, 1)), amplitude.min((0, 1))


def _verdict(amplitude: Floats, defect: Floats, tolerance: float) -> int:
    """Whether the last third is what the third before it was."""
    window = len(defect) // 3
    late, early = slice(-window, None), slice(-2 * window, -window)
    grown = defect[late].mean() > defect[early].mean()
    bound = max(min(_ALIKE, _FADED * defect.max()), _REPEATED)
    if defect[late].max() < bound and (not grown or defect[late].max() < _REPEATED):
        return STEADY
    if defect[late].mean() < _LEFT * defect[0]:
        return UNSETTLED
    if not 1 / _GROWS < defect[late].mean() / defect[early].mean() < _GROWS:
        return UNSETTLED
    both = _statistics(amplitude[late]), _statistics(amplitude[early])
    scale = both[0][1].max(axis=-1, keepdims=True)
    apart = max(
        (np.abs(a - b) / np.where(scale > 0, scale, 1.0)).max(initial=0.0)
        for a, b in zip(*both, strict=True)
    )
    return MODULATED if apart <= tolerance else UNSETTLED
