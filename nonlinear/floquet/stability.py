"""Whether a ring stays with a periodic wave: Floquet exponents by nodal diameter.

About the wave of a response, motions

    x = x_p + Re[e^{λt} Σ_k p_k e^{ikωt}],   |k| <= P,

of which sector j + 1 follows sector j by the phase kφ + 2πn/N, are those of diameter n. Harmonic k
has the nodal diameter (n + k EO) mod N. So (n, λ) and (n + EO, λ + iω) are the same motion, and so
is, all being real, (N - n, λ*): those with 0 <= n <= N/2 and |Im λ| <= ω/2 are all.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from vanelock.common.arrays import Complex, Floats, Integers, as_whole
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.stuck_modes import StuckModes, check_uncoupled, stuck_modes
from vanelock.nonlinear.contact.law import check_friction, contact_law
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.floquet.exponents import Series, zeros
from vanelock.nonlinear.floquet.perturbation import HALF, LEFT, PerturbedStructure, law_transfer
from vanelock.nonlinear.floquet.plane_transfer import plane_transfer
from vanelock.nonlinear.forced_response.response import Response, check_contacts, chosen_points
from vanelock.nonlinear.fourier import TURN, one_thread, resized, to_real
from vanelock.nonlinear.newton.newton import scales, solve
from vanelock.rom.system.coordinates import check, check_ring
from vanelock.rom.system.system import System

_ALIKE = 1e-3  # of the excitation's frequency, by which two that are listed differ at least
_SAME = (
    5e-3  # by which the values of s of one motion differ between two diameters that both have it
)


@dataclass(frozen=True)
class _FloquetMotion:
    """One motion beside a wave.

    `diameter`: n, 0 to N/2; `s`: λ/ω, |Im s| at most 1/2; `series`: of the diameter that it was
    found at; `zero`: s and amplitudes there; `shift`: harmonics from that s to this one, before
    conjugation; `mirrored`: whether it is the conjugate of that found.
    """

    diameter: int
    s: complex
    series: Series
    zero: tuple[complex, Complex]
    shift: int
    mirrored: bool

    @property
    def exact(self) -> complex:
        """That by Newton's method on the characteristic matrix in full."""
        s = self.series.polished(self.zero[0]) - 1j * self.shift
        return s.conjugate() if self.mirrored else s

    def frequencies(self, count: int) -> Floats:
        """(count,) frequencies that the outputs see, Hz, the largest amplitude first.

        Where a system has no outputs, its contacts stand in. NaN beyond the harmonics there are.
        """
        (s, a), exact = self.zero, self.series.exact
        structure, components = exact.structure, exact.law.components
        w = exact.answer(s)[2] @ a
        size = np.zeros(len(structure.each))
        for place, modes in enumerate(structure.each):
            z = structure.omega * (s + 1j * (place - structure.harmonics))
            pulled = modes.pull[:, components] * structure.stiffness[components] @ w[:, place]
            amplitude = pulled / (modes.static + z * (z * modes.compliance + modes.damping))
            here = structure.place == place
            amplitude[structure.number[here]] = a[: len(here)][here]
            size[place] = np.abs(structure.output_rows(place) @ amplitude).max(initial=0.0)
        shown: list[float] = []
        for place in np.argsort(-size):
            times = abs(place - structure.harmonics + s.imag)
            if all(abs(times - other) > _ALIKE for other in shown):
                shown.append(times)
        shown += [np.nan] * count
        return np.array(shown[:count]) * structure.omega / (2 * np.pi)


def _motions(
    system: System,
    modes: Mapping[int, StuckModes],
    u: Floats,
    omega: float,
    harmonics: int,
    friction: str,
) -> tuple[list[_FloquetMotion], bool]:
    """The motions beside a wave that are in the window, the most unstable first; if all."""
    transfer = plane_transfer if friction == "isotropic" else law_transfer
    law = transfer(u, system.contacts.alpha, harmonics).onto_open(modes[0].opened)
    found: list[_FloquetMotion] = []
    complete = True
    for n in range(system.sectors // 2 + 1):
        of_diameter = partial(PerturbedStructure, system, modes, n, omega, harmonics)
        series, pairs, known = zeros(of_diameter, law)
        complete &= known
        found += _within(series, pairs, system)
    found.sort(key=lambda motion: -motion.s.real)
    motions: list[_FloquetMotion] = []
    for motion in found:
        if not any(_are_same(motion, other, system) for other in motions):
            motions.append(motion)
    return motions, complete


def _within(
    series: Series, pairs: list[tuple[complex, Complex]], system: System
) -> Iterator[_FloquetMotion]:
    """Motions of the zeros of a diameter, each at 0 <= n <= N/2 and |Im s| <= 1/2."""
    N, n = system.sectors, series.exact.structure.diameter
    for s, a in pairs:
        if (2 * n) % N == 0 and s.imag < -1e-7:
            continue  # its conjugate is there, too
        shift = round(s.imag)
        diameter, moved = (n - shift * system.engine_order) % N, s - 1j * shift
        mirrored = 2 * diameter > N
        if mirrored:
            diameter, moved = N - diameter, moved.conjugate()
        yield _FloquetMotion(diameter, moved, series, (s, a), shift, mirrored)


def _are_same(one: _FloquetMotion, other: _FloquetMotion, system: System) -> bool:
    """Whether two motions are one that two diameters have, or one twice, where these meet."""
    N, edge = system.sectors, 1 - HALF
    if min(abs(one.s.imag), abs(other.s.imag)) < edge:
        return False
    for turn in (-1, 1):
        n, s = one.diameter + turn * system.engine_order, one.s + 1j * turn
        for diameter, value in ((one.diameter, one.s), (n, s)):
            for k, at in ((diameter, value), (-diameter, value.conjugate())):
                if (k - other.diameter) % N == 0 and abs(at - other.s) < _SAME:
                    return True
    return False


STABLE, UNSTABLE, UNDECIDED = 0, 1, 2
_VERDICTS = f"{STABLE} stable, {UNSTABLE} unstable, {UNDECIDED} undecided"

_MORE = 2
"""Harmonics of a perturbation beyond those of its wave, and of the second wave beyond the first."""
_FOREIGN = 1e-6
"""Of the balance, relative to the largest displacement, beyond which a wave is another system's."""
NEUTRAL = 1e-9
"""Of |Re λ|/ω, what rounding may come to."""
_FREQUENCIES = 3


@dataclass(frozen=True)
class Stability(Product):
    """Floquet exponents of p periodic responses, the m most unstable motions of each.

    Attributes
    ----------
    frequency : (p,) float
        Of the responses, Hz.
    exponent : (p, m) complex
        λ, 1/s, |Im λ| at most half the circular frequency of the response; NaN where the ring has
        fewer motions that shrink to no less than 0.53 a period.
    diameter : (p, m) int
        Nodal diameter n of each, 0 to N/2; -1 where there is none.
    growing : (p,) int
        Motions with Re λ > 0; conjugate ones, (n, λ) and (N - n, λ*), count once.
    verdict : (p,) int
        STABLE, UNSTABLE or UNDECIDED.
    growth : (p, 2) float
        Largest Re λ, 1/s, by the first and by the second truncation, NaN where that has no
        solution; what else is here is of the last one that has.
    seen : (p, m, 3) float
        Frequencies at which the motion shows at the outputs, |k + Im λ/ω| f, the largest of them
        first, Hz.
    harmonics : (2,) int
        H of both truncations; the perturbations have two more.
    """

    frequency: Floats = field(metadata={"unit": "Hz"})
    exponent: Complex = field(metadata={"unit": "1/s"})
    diameter: Integers
    growing: Integers
    verdict: Integers = field(metadata={"codes": _VERDICTS})
    growth: Floats = field(metadata={"unit": "1/s"})
    seen: Floats = field(metadata={"unit": "Hz"})
    harmonics: Integers

    @property
    def multiplier(self) -> Complex:
        """(p, m) e^{λT}: what a period makes of each motion."""
        return np.asarray(np.exp(self.exponent / self.frequency[:, None]))


@one_thread
def stability(
    system: System,
    response: Response,
    points: Sequence[int] | None = None,
    harmonics: int | None = None,
    count: int = 4,
    modes: Mapping[int, StuckModes] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Stability:
    """Whether the ring stays with the waves of a response, all nodal diameters considered.

    Parameters
    ----------
    system : System
        The one that was solved, with the nodal diameters 0 ... N/2.
    response : Response
        Coupled, with located events; its own coefficients of friction count.
    points : sequence of int, optional
        Which; all by default.
    harmonics : int, optional
        H of the second truncation, to which each point is solved again from where it is; by
        default two more than the response has. With the response's own H, the perturbation alone
        gets more harmonics.
    count : int
        m, motions that are listed for each point.
    modes : dict of int to StuckModes, optional
        As of `frequency_response`.
    progress : callable, optional
        Called after each point with (points done, points in all).

    Returns
    -------
    Stability
        `verdict` is STABLE or UNSTABLE where both truncations say so; UNDECIDED where they differ,
        where either is not solved, and where not all exponents were found.

    Raises
    ------
    InputError
        If the response is not of this kind or not of this system, a point does not exist, a nodal
        diameter is missing, or a given C couples the stuck modes.
    """
    finer = response.harmonics + _MORE if harmonics is None else as_whole(harmonics, "harmonics")
    _check(system, response, finer, count)
    chosen = chosen_points(response, points)
    system = replace(system, contacts=replace(system.contacts, mu=response.mu))
    every = _modes(system, modes or {})
    rows = []
    for done, point in enumerate(chosen, 1):
        rows.append(_point_stability(system, every, response, point, finer, count))
        if progress is not None:
            progress(done, len(chosen))
    exponent, diameter, growing, verdict, growth, seen = map(np.array, zip(*rows, strict=True))
    return Stability(
        frequency=response.frequency[chosen],
        exponent=exponent,
        diameter=diameter,
        growing=growing,
        verdict=verdict,
        growth=growth,
        seen=seen,
        harmonics=np.array([response.harmonics, finer]),
    )


def _check(system: System, response: Response, finer: int, count: int) -> None:
    """Refuse what stability cannot be found for."""
    system.contacts.refuse_elements("stability")
    if (response.coupling, response.samples) != ("coupled", 0):
        law = f"{response.samples} samples" if response.samples else "located events"
        raise InputError(
            f"response: {response.coupling}, {law}: stability is of coupled balances with located "
            "events"
        )
    if not response.harmonics or np.any(response.frequency <= 0):
        raise InputError("response: at rest: stability is of vibrations")
    check(system)
    check_friction(system.contacts, response.friction)
    wave = [system.nodal_diameter(h) for h in range(response.harmonics + 1)]
    if response.harmonic_diameters.tolist() != wave:
        raise InputError(
            f"response: harmonics at nodal diameters {response.harmonic_diameters.tolist()}: "
            f"a wave has them at {wave}"
        )
    check_contacts(response, system.contacts)
    if finer < response.harmonics:
        raise InputError(f"harmonics: given {finer}: the response has {response.harmonics} already")
    if as_whole(count, "count") < 1:
        raise InputError(f"count: given {count}: allowed: 1 or more")
    check_ring(system, system.sectors // 2, "stability")


def _modes(system: System, stuck: Mapping[int, StuckModes]) -> dict[int, StuckModes]:
    """Stuck modes of the nodal diameters 0 ... N - 1."""
    every: dict[int, StuckModes] = {}
    for k in range(system.sectors // 2 + 1):
        every[k] = (stuck[k] if k in stuck else stuck_modes(system, k)).held
        check_uncoupled(system, every[k], k, "stability")
        every.setdefault((system.sectors - k) % system.sectors, every[k].conjugate())
    return every


def _point_stability(
    system: System,
    modes: dict[int, StuckModes],
    response: Response,
    point: int,
    finer: int,
    count: int,
) -> tuple[object, ...]:
    """Exponents, diameters, number growing, verdict, growth by both truncations, frequencies."""
    omega = TURN * float(response.frequency[point])
    exponent, seen = np.full(count, np.nan, complex), np.full((count, _FREQUENCIES), np.nan)
    diameter, growth = np.full(count, -1), np.full(2, np.nan)
    if not response.converged[point]:
        return exponent, diameter, 0, UNDECIDED, growth, seen
    u = to_real(response.contact[point])
    friction, again = response.friction, _solved_again(system, modes, response, point, finer)
    found = [_motions(system, modes, u, omega, response.harmonics + _MORE, friction)]
    if again is not None:
        more = _MORE if finer > response.harmonics else 2 * _MORE
        found.append(_motions(system, modes, again, omega, finer + more, friction))
    motions = found[-1][0]
    for i, motion in enumerate(motions[:count]):
        exponent[i], diameter[i] = omega * motion.exact, motion.diameter
        seen[i] = motion.frequencies(_FREQUENCIES)
    growing = sum(motion.s.real > NEUTRAL for motion in motions)
    for i, (each, _) in enumerate(found):  # at least that of the window's edge
        growth[i] = each[0].exact.real if each else LEFT
    verdict = UNDECIDED
    if all(complete for _, complete in found):
        verdict = UNSTABLE if np.all(growth > NEUTRAL) else verdict
        verdict = STABLE if np.all(growth < -NEUTRAL) else verdict
    return exponent, diameter, growing, verdict, omega * growth, seen


def _solved_again(
    system: System, modes: dict[int, StuckModes], response: Response, point: int, harmonics: int
) -> Floats | None:
    """The wave with more harmonics, (c, 3, 2H + 1) m; None where no solution was found."""
    omega, u = TURN * float(response.frequency[point]), to_real(response.contact[point])
    given, friction = response.harmonics, response.friction
    balance = structure(system, given, stuck=modes).balance(omega)
    w = contact_law(system.contacts, given, friction=friction)(u).w
    off = np.abs(u - balance.displacement(w)) / scales(balance.linear)
    if off.max(initial=0.0) > max(_FOREIGN, 10 * response.truncation[point]):
        raise InputError(
            f"response: no solution of this system at {omega / TURN:.6g} Hz: off by "
            f"{off.max():.1e} of its vibration"
        )
    if harmonics == given:
        return u
    again = fixed(
        structure(system, harmonics, stuck=modes).balance(omega),
        contact_law(system.contacts, harmonics, friction=friction),
    )
    found = solve(again, resized(w, harmonics), 0.0)
    return found.u if found.converged else None
