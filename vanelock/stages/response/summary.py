"""What a run found, in numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from vanelock.common.arrays import Booleans, Floats
from vanelock.input.cases.sweep import Case
from vanelock.nonlinear import OPEN, SLIP_OPEN, Response
from vanelock.rom import Contacts
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.responses import Monitor

LEAST_WORK = 1e-6
"""Friction work of a contact that slips, relative to the largest: one that opens without sliding
is not counted as slipping."""
AGREE = 1e-6
"""Relative difference of two peaks below which they agree."""


@dataclass(frozen=True)
class Peak:
    """Largest converged point of a response: its index, frequency [Hz] and amplitude [m]."""

    point: int
    frequency: float
    amplitude: float
    at_edge: bool


@dataclass(frozen=True)
class Jump:
    """Neighbouring points that no curve of solutions joins, in the order of the sweep."""

    frequency: tuple[float, float]
    """Before and after, Hz."""
    amplitude: tuple[float, float]
    """Of the monitored displacement there, m."""


@dataclass(frozen=True)
class Sweep:
    """A sweep of a case, "up", "down" or "both"."""

    direction: str
    peak: Peak | None
    """Its largest converged point."""
    jumps: tuple[Jump, ...]


@dataclass(frozen=True)
class Settled:
    """What the ring does instead of an unstable wave, integrated in time: the monitored amplitude.

    Attributes
    ----------
    verdict : "steady", "modulated" or "not settled"
    mean, largest, smallest : float
        Over all sectors and the last periods, m.
    periods : int
        Followed in all.
    returned : bool
        Whether it is steady and the wave of the balance again.
    unsolved : int
        Time steps whose contacts were not solved to round-off.
    """

    verdict: str
    mean: float
    largest: float
    smallest: float
    periods: int
    returned: bool
    unsolved: int

    @property
    def words(self) -> str:
        """The verdict, and whether a steady motion is the wave."""
        if self.verdict != "steady":
            return self.verdict
        return "steady, the same wave" if self.returned else "steady, another motion"


@dataclass(frozen=True)
class WaveVerdict:
    """Whether the ring stays with the periodic wave at a peak."""

    verdict: str
    """Either "stable", "unstable" or "undecided"."""
    growth: float
    """What a period makes of the motion that grows fastest, or dies out slowest; NaN where all die
    out to 0.53 or less."""
    diameter: int
    """Its nodal diameter; -1 where none is known."""
    growing: int
    """Motions that grow."""
    frequencies: tuple[float, ...]
    """Where that motion shows at the outputs, Hz, largest first."""
    reason: str = ""
    """Why it is undecided."""
    settled: Settled | None = None
    """What the ring does instead, where it is unstable and was followed."""

    @property
    def followed(self) -> str:
        """What the ring does instead, the end of a sentence; "" where it was not followed."""
        if (found := self.settled) is None:
            return ""
        low, high, mean = (1e6 * each for each in (found.smallest, found.largest, found.mean))
        text = f"; integrated in time it vibrates between {low:.4g} and {high:.4g} um, "
        text += f"mean {mean:.4g} um, {found.words}"
        if found.verdict == "not settled":
            text += f" after {found.periods} periods: larger amplitudes may follow"
        return text + (f"; {found.unsolved} steps NOT SOLVED" if found.unsolved else "")


@dataclass(frozen=True)
class Summary:
    """A case in numbers.

    Attributes
    ----------
    case : str
        Its name.
    values : dict of str to number or str
        The swept keys.
    harmonics : int
        H.
    mu : float or None
        Friction coefficient of the contacts that the limit "free" opens, where it is one.
    peak : Peak or None
        None where no point converged.
    of_free, of_stuck : float
        Peak over the linear peak with contacts free and stuck.
    position : float
        Frequency of the peak between that of the mode of interest free (0) and stuck (1); NaN where
        the response has no frequency from one to the other.
    slipping, opening : float
        Share of the contacts that the limit "free" opens that slip, by their friction work, and
        that open in every period at the peak; a contact may do both.
    closed_slipping : float
        Share of the others that slip.
    friction_share : float
        Share of the friction work at the peak that is those contacts'.
    work : dict of str to float
        Friction work of each joint in a period at the peak, J.
    loose : bool
        Whether a part is held by no contact that is closed at rest.
    converged, points : int
        Points that converged, and all.
    worst : float
        Largest residual of the others, 0 if there are none.
    seconds : float
        What computing took.
    warnings : tuple of str
        What else to know before using them, see `vanelock.quantities.warnings`.
    sweeps : tuple of Sweep
        That of the peak, and the other one where both directions were swept.
    lowest, highest : Peak or None
        Between which static friction that is not determined may move the peak, where asked for.
    wave : WaveVerdict or None
        Whether the ring stays with the peak's wave, where asked for.
    """

    case: str
    values: dict[str, float | str]
    harmonics: int
    mu: float | None
    peak: Peak | None
    of_free: float
    of_stuck: float
    position: float
    slipping: float
    opening: float
    closed_slipping: float
    friction_share: float
    work: dict[str, float]
    loose: bool
    converged: int
    points: int
    worst: float
    seconds: float
    warnings: tuple[str, ...] = ()
    sweeps: tuple[Sweep, ...] = ()
    lowest: Peak | None = None
    highest: Peak | None = None
    wave: WaveVerdict | None = None


def peak_of(response: Response, amplitude: Floats) -> Peak | None:
    """Largest converged point, None where there is none."""
    known = np.where(response.converged, amplitude, -np.inf)
    top = int(known.argmax())
    if not np.isfinite(known[top]):
        return None
    edge = response.points > 1 and top in (0, response.points - 1)
    return Peak(top, float(response.frequency[top]), float(amplitude[top]), edge)


def by_height(responses: Sequence[Response], monitor: Monitor) -> list[Response]:
    """Responses of a case, that of the largest peak first; the given order where they agree."""
    peaks = [peak_of(response, monitor.amplitude(response)) for response in responses]
    heights = [0.0 if peak is None else peak.amplitude for peak in peaks]
    first = next(i for i, height in enumerate(heights) if height * (1 + AGREE) >= max(heights))
    return [responses[first], *responses[:first], *responses[first + 1 :]]


def sweep_of(response: Response, amplitude: Floats) -> Sweep:
    """A response as a sweep, its monitored amplitude (p,) in m."""
    pairs = np.empty((0, 2), np.int64) if response.jump is None else response.jump
    frequency = response.frequency
    jumps = tuple(
        Jump((float(frequency[a]), float(frequency[b])), (float(amplitude[a]), float(amplitude[b])))
        for a, b in pairs
    )
    return Sweep(response.direction or "up", peak_of(response, amplitude), jumps)


def _share(chosen: Booleans) -> float:
    """Share of contacts that are chosen; NaN where there are no contacts."""
    return float(chosen.mean()) if len(chosen) else float("nan")


def summarise(
    case: Case,
    contacts: Contacts,
    response: Response,
    peak: Peak | None,
    limits: Limits,
    linear: Mapping[str, Peak | None],
    seconds: float,
    loose: bool = False,
) -> Summary:
    """A case in numbers."""
    opens, joints = contacts.opens & contacts.springs, np.array(contacts.joints)
    if not opens.any():  # nothing to stick: the stuck limit is the free one again
        linear = {"free": linear["free"], "stuck": None}
    slipping = opening = closed_slipping = friction = position = float("nan")
    ratio = dict.fromkeys(linear, float("nan"))
    each: dict[str, float] = {}
    if peak is not None:
        state = response.state[peak.point]
        work = response.dissipation[peak.point]
        slips = work > LEAST_WORK * work.max(initial=np.finfo(float).tiny)
        slipping, closed_slipping = _share(slips[opens]), _share(slips[~opens])
        opening = _share(np.isin(state[opens], (OPEN, SLIP_OPEN)))
        if (total := float(work.sum())) > 0:
            friction = float(work[opens].sum()) / total
        each = {name: float(work[joints == name].sum()) for name in dict.fromkeys(contacts.joints)}
        ends = sorted((limits.free_frequency, limits.stuck_frequency))
        if ends[0] <= response.frequency.max() and ends[1] >= response.frequency.min():
            position = limits.position(peak.frequency)
        for which, other in linear.items():
            if other is not None and other.amplitude > 0:
                ratio[which] = peak.amplitude / other.amplitude
    lost = response.residual[~response.converged]
    mu = set(contacts.mu[opens].tolist())
    return Summary(
        case=case.name,
        values=case.values,
        harmonics=response.harmonics,
        mu=mu.pop() if len(mu) == 1 else None,
        peak=peak,
        of_free=ratio["free"],
        of_stuck=ratio["stuck"],
        position=position,
        slipping=slipping,
        opening=opening,
        closed_slipping=closed_slipping,
        friction_share=friction,
        work=each,
        loose=loose,
        converged=int(response.converged.sum()),
        points=response.points,
        worst=float(lost.max()) if len(lost) else 0.0,
        seconds=seconds,
    )


def figures(summary: Summary) -> dict[str, float]:
    """The numbers of a case by their names in the results file, SI."""
    values = {k: v for k, v in asdict(summary).items() if isinstance(v, int | float)}
    for name, at in (("peak", "peak"), ("lowest", "lowest_peak"), ("highest", "highest_peak")):
        if (peak := getattr(summary, name)) is not None:
            values |= {f"{at}_frequency": peak.frequency, f"{at}_amplitude": peak.amplitude}
    if summary.wave is not None:
        values["growth_in_a_period"] = summary.wave.growth
    return values
