"""The linear limits of a case: its modes with contacts free and stuck, and the mode of interest.

"Free" opens every joint but those that `Contacts.always_closed` names; "stuck" closes all. The mode
of interest is counted with the contacts stuck, where nothing is loose, motions that nothing holds
even then aside, and followed to the free structure by the modal assurance criterion. Both share
their coordinates, so their shapes compare directly.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from vanelock import rom
from vanelock.common.arrays import Booleans, Floats
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.input.band import asked_by, refuse_beyond
from vanelock.input.schema.scene import Scene
from vanelock.input.schema.study import Study
from vanelock.rom.errors import ReducedPart
from vanelock.rom.system.system import Matrix

Limit: TypeAlias = Literal["free", "stuck"]
LIMITS: tuple[Limit, ...] = ("free", "stuck")
"""Of the contacts that open, in linear limits."""
SHOWN = 6
"""Frequencies in the table."""
RIGID = 1e-5
"""Of the largest frequency known, below which one is nothing but rounding."""
LOWEST = 1e-6
"""Hz; no structure vibrates below."""
LIKE = 0.3
"""Least modal assurance criterion of a free mode that counts as the one of interest."""
FAR = 0.3
"""Of the stuck mode's frequency, below which the free one is another motion, a loose part's."""
ALIKE = 1e-6
"""Relative distance of assurance criteria of double modes, of which the first one counts."""
EVEN = 101
"""Frequencies of a linear response that are evenly spaced, beside those around modes."""
MARGIN = 0.03
"""Least margin of the default range, relative."""


@dataclass(frozen=True)
class Limits(Product):
    """Linear modes at the nodal diameter of the excitation.

    Attributes
    ----------
    nodal_diameter, sectors : int
        ND of the first harmonic, and N.
    opens : bool
        Whether there are contacts that open; without them both limits are the same.
    free, stuck : (m,) float
        Natural frequencies with those contacts open and closed, Hz.
    free_mode, stuck_mode : int
        Place of the mode of interest among them, from 0.
    mac : float
        Modal assurance criterion between the two.
    free_error, stuck_error : (m,) float
        Estimated relative error of each frequency from reducing the parts; NaN where the route of
        the reduction has no estimate.
    band : float or None
        Frequency up to which the reduced parts answer, Hz; None where that is not known.
    free_damping, stuck_damping : float
        Damping ratio of the mode of interest, VᴴCV / 2ω VᴴMV; NaN for a mode at 0 Hz.
    free_lowered, stuck_lowered : float
        Relative amount by which the correction of the meshes lowered the frequency of the mode of
        interest; NaN without one.
    """

    nodal_diameter: int
    sectors: int
    opens: bool
    free: Floats = field(metadata={"unit": "Hz"})
    stuck: Floats = field(metadata={"unit": "Hz"})
    free_mode: int
    stuck_mode: int
    mac: float
    free_error: Floats
    stuck_error: Floats
    band: float | None = field(default=None, metadata={"unit": "Hz"})
    free_damping: float = float("nan")
    stuck_damping: float = float("nan")
    free_lowered: float = float("nan")
    stuck_lowered: float = float("nan")

    @property
    def conditions(self) -> tuple[Limit, ...]:
        """Contacts free and, where they open, stuck."""
        return LIMITS if self.opens else LIMITS[:1]

    def of_interest(self, which: Limit) -> tuple[int, float]:
        """Place of the mode of interest, from 0, and its frequency, Hz."""
        if which == "free":
            return self.free_mode, self.free_frequency
        return self.stuck_mode, self.stuck_frequency

    @property
    def free_frequency(self) -> float:
        """Frequency of the mode of interest with contacts free, Hz."""
        return float(self.free[self.free_mode])

    @property
    def stuck_frequency(self) -> float:
        """Frequency of the mode of interest with contacts stuck, Hz."""
        return float(self.stuck[self.stuck_mode])

    @property
    def rise(self) -> float:
        """Relative rise of the frequency from free to stuck; NaN for a mode at 0 Hz."""
        free = self.free_frequency
        return self.stuck_frequency / free - 1 if free > 0 else float("nan")

    def position(self, frequency: float) -> float:
        """Where a frequency lies between free (0) and stuck (1); NaN where the two agree."""
        span = self.stuck_frequency - self.free_frequency
        return (frequency - self.free_frequency) / span if span else float("nan")


def limits(
    system: rom.System,
    mode: int,
    parts: Mapping[str, ReducedPart] | None = None,
    meshed: rom.System | None = None,
) -> Limits:
    """Modes of both limits, and the mode of interest in both."""
    parts = parts or {}
    k = system.nodal_diameter(1)
    size = len(system.at(k).K)
    if mode > size:
        raise InputError(f"response.mode = {mode}: the reduced model has {size} modes")
    rigid = rom.unheld_motions(system, k).shape[1]
    place = rigid + mode - 1
    if rigid and place >= size:
        raise InputError(
            f"response.mode = {mode}: the reduced model has {size} modes, of which {rigid} are "
            "rigid-body motions, 0 Hz"
        )
    count = min(size, max(SHOWN, mode + 6) + rigid)
    closed = ~system.contacts.opens
    free, free_shapes = rom.linear_modes(system, k, count, closed=closed)
    stuck, stuck_shapes = rom.linear_modes(system, k, count)
    if place >= len(stuck):
        raise InputError(f"response.mode = {mode}: only {len(stuck) - rigid} modes have a mass")
    likeness = rom.mac(stuck_shapes[:, [place]], free_shapes, system.at(k).M)[0]
    partner = int(np.argmax(likeness >= (1 - ALIKE) * likeness.max()))
    lowered = float("nan"), float("nan")
    if meshed is not None:
        raised = [rom.linear_modes(meshed, k, count, which)[0] for which in (closed, None)]
        own = (free[partner], raised[0][partner]), (stuck[place], raised[1][place])
        lowered = tuple(1 - after / before for after, before in own)
    reduced = meshed or system
    return Limits(
        nodal_diameter=k,
        sectors=system.sectors,
        opens=not closed.all(),
        free=free,
        stuck=stuck,
        free_mode=partner,
        stuck_mode=place,
        mac=float(likeness[partner]),
        free_error=_errors(reduced, parts, len(free), closed),
        stuck_error=_errors(reduced, parts, len(stuck), None),
        band=system.band,
        free_damping=_ratio(system, closed, free_shapes[:, partner], free[partner]),
        stuck_damping=_ratio(system, None, stuck_shapes[:, place], stuck[place]),
        free_lowered=lowered[0],
        stuck_lowered=lowered[1],
    )


def _ratio(system: rom.System, closed: Booleans | None, shape: Matrix, hertz: float) -> float:
    """Damping ratio of a mode of unit mass, contacts as for `linear_modes`."""
    if not hertz:
        return float("nan")
    k, springs = system.nodal_diameter(1), system.contacts.springs
    acting = springs if closed is None else closed & springs
    if system.at(k).C is None and np.array_equal(acting, springs & ~system.opens_in_damping):
        return float(system.damping_ratio)  # a mode that the ratio is of
    C = rom.linear_damping(system, k)
    return float(np.vdot(shape, C @ shape).real / (4 * np.pi * hertz))


def _errors(
    system: rom.System,
    parts: Mapping[str, ReducedPart],
    count: int,
    closed: Booleans | None,
) -> Floats:
    k = system.nodal_diameter(1)
    blocks = {name: part.at(k) for name, part in parts.items()}
    estimated = {name: parts[name] for name, each in blocks.items() if each.neglected is not None}
    if not blocks or any(
        each.neglected is None and each.complete != np.inf for each in blocks.values()
    ):
        return np.full(count, np.nan)
    return np.asarray(rom.frequency_errors(system, estimated, k, count, closed).total)


def frequencies(problem: Study | Scene, limits: Limits) -> Floats | tuple[float, float]:
    """Excitation frequencies of a case, Hz; a tuple is a range.

    Where the file names neither frequencies nor a range: from a little below the mode of interest
    with contacts free to a little above it with contacts stuck.
    """
    mode, stuck = f"response.mode = {problem.response.mode}", limits.stuck_frequency
    if stuck <= RIGID * limits.stuck.max():
        raise InputError(
            f"{mode}: a rigid-body motion, 0 Hz, even with all contacts stuck: choose another "
            "mode, or clamp what moves"
        )
    if stuck < LOWEST:
        raise InputError(
            f"{mode}: lies at {stuck:.2g} Hz: are stiffness and mass swapped, or in other units?"
        )
    response, asked = problem.response, asked_by(problem)
    # a linear response spans its peak
    own = fine(max(_ends(limits)), problem.damping.ratio or 0.0).max()
    for what, highest in {**asked, mode: own if asked else _around(limits)[1]}.items():
        refuse_beyond(what, highest, limits.band, problem)
    if response.frequencies is not None:
        return np.array(response.frequencies)
    low, high = _around(limits) if response.range is None else response.range
    return (low, high) if response.points is None else np.linspace(low, high, response.points)


def _ends(limits: Limits) -> list[float]:
    """The mode of interest stuck and, where there is such a mode, free, Hz, ascending."""
    free, stuck = limits.free_frequency, limits.stuck_frequency
    return sorted([free, stuck]) if limits.mac > LIKE and free > FAR * stuck else [stuck]


def _around(limits: Limits) -> tuple[float, float]:
    """Range around the mode of interest, free to stuck, Hz."""
    ends = _ends(limits)
    low, high = ends[0] if len(ends) > 1 else 0.8 * ends[0], ends[-1]
    margin = max(0.25 * (high - low), MARGIN * low)
    return low - margin, high + margin


def dense(
    asked: Floats | tuple[float, float],
    limits: Limits,
    stuck: bool,
    damping: float,
) -> Floats:
    """Frequencies at which a linear response is a true curve, Hz, ascending.

    They span what is wanted and the mode of interest in both limits, evenly there and in equal
    ratios beyond, and are fine around every known mode within, so that no straight line stands in
    for a peak.
    """
    modes = limits.stuck if stuck else limits.free
    near = np.concatenate([fine(f, damping) for f in _ends(limits)])
    if isinstance(asked, tuple):
        listed = np.linspace(*asked, EVEN)
        near = np.concatenate([near, listed])
    else:
        listed = np.asarray(asked, float)
    low, high = min(near.min(), listed.min()), max(near.max(), listed.max())
    even = np.linspace(near.min(), near.max(), EVEN)
    parts = [listed, even, np.geomspace(low, high, EVEN).clip(low, high)]
    parts.append(fine(limits.stuck_frequency if stuck else limits.free_frequency, damping))
    # Beyond the fine frequencies the flank of a peak falls as the inverse of the distance.
    flank = np.geomspace(max(6 * damping, 1e-3), 0.9, 40)
    for f in modes:
        parts += [fine(f, damping, 41), f * (1 - flank), f * (1 + flank)]
    found = np.unique(np.concatenate(parts))
    return np.asarray(found[(found >= low) & (found <= high)])


def fine(frequency: float, damping: float, points: int = 61) -> Floats:
    """Frequencies that resolve a lightly damped linear peak, Hz.

    They reach six half-bandwidths ζf to either side and are densest, 0.06 ζf, in the middle, where
    the peak is; it is then missed by no more than 0.05 % of its height.
    """
    across = np.sinh(3 * np.linspace(-1, 1, points)) / np.sinh(3)
    return np.asarray(frequency * (1 + 6 * damping * across).clip(min=0.01))
