"""All ways in which a ring leaves a wave or returns to it: exponents of every nodal diameter."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.floquet.characteristic import Series
from vanelock.nonlinear.floquet.exponents import Zeros, zeros
from vanelock.nonlinear.floquet.law_transfer import law_transfer
from vanelock.nonlinear.floquet.perturbed_structure import PerturbedStructure, Rectangle
from vanelock.nonlinear.floquet.plane_transfer import plane_transfer
from vanelock.rom.system.system import System

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

WINDOW = Rectangle(left=-0.1, right=1.0, half=0.52)
"""Of s = λ/ω: motions that shrink to no less than 0.53 a period and grow to no more than 500.

A little higher than the half harmonics at which diameters meet.
"""
ALIKE = 1e-3  # of the excitation's frequency, by which two that are listed differ at least
SAME = 5e-3  # by which the values of s of one motion differ between two diameters that both have it


@dataclass(frozen=True)
class FloquetMotion:
    """One motion beside a wave.

    Attributes
    ----------
    diameter : int
        n, 0 to N/2.
    s : complex
        λ/ω, |Im s| at most 1/2.
    series : Series
        Of the diameter that it was found at.
    zero : (complex, (m,) complex)
        s and amplitudes there.
    shift : int
        Harmonics from that s to this one, before conjugation.
    mirrored : bool
        Whether it is the conjugate of that found.
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
        w = exact.deviations(s) @ a
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
            if all(abs(times - other) > ALIKE for other in shown):
                shown.append(times)
        shown += [np.nan] * count
        return np.array(shown[:count]) * structure.omega / (2 * np.pi)


@dataclass(frozen=True)
class FloquetMotions:
    """The motions beside one wave.

    Attributes
    ----------
    each : list of FloquetMotion
        The most unstable first.
    complete : bool
        Whether they are as many as were counted.
    """

    each: list[FloquetMotion]
    complete: bool

    @property
    def growth(self) -> float:
        """Largest Re λ/ω; that of the window's edge where none lies in it."""
        return self.each[0].exact.real if self.each else WINDOW.left


def motions(
    system: System,
    modes: Mapping[int, StuckModes],
    u: Floats,
    omega: float,
    harmonics: int,
    friction: str = "orthogonal",
) -> FloquetMotions:
    """The motions beside a wave that are in the window."""
    transfer = plane_transfer if friction == "isotropic" else law_transfer
    law = transfer(u, system.contacts.alpha, harmonics).onto_open(modes[0].opened)
    found: list[FloquetMotion] = []
    complete = True
    for n in range(system.sectors // 2 + 1):
        of_diameter = partial(PerturbedStructure, system, modes, n, omega, harmonics, WINDOW)
        here = zeros(of_diameter, law, WINDOW)
        complete &= here.complete
        found += _within(here, system)
    found.sort(key=lambda motion: -motion.s.real)
    each: list[FloquetMotion] = []
    for motion in found:
        if not any(_are_same(motion, other, system) for other in each):
            each.append(motion)
    return FloquetMotions(each, complete)


def _within(found: Zeros, system: System) -> Iterator[FloquetMotion]:
    """Motions of the zeros of a diameter, each at 0 <= n <= N/2 and |Im s| <= 1/2."""
    N, n = system.sectors, found.series.exact.structure.diameter
    for s, a in found.each:
        if (2 * n) % N == 0 and s.imag < -1e-7:
            continue  # its conjugate is there, too
        shift = round(s.imag)
        diameter, moved = (n - shift * system.engine_order) % N, s - 1j * shift
        mirrored = 2 * diameter > N
        if mirrored:
            diameter, moved = N - diameter, moved.conjugate()
        yield FloquetMotion(diameter, moved, found.series, (s, a), shift, mirrored)


def _are_same(one: FloquetMotion, other: FloquetMotion, system: System) -> bool:
    """Whether two motions are one that two diameters have, or one twice, where these meet."""
    N, edge = system.sectors, 1 - WINDOW.half
    if min(abs(one.s.imag), abs(other.s.imag)) < edge:
        return False
    for turn in (-1, 1):
        n, s = one.diameter + turn * system.engine_order, one.s + 1j * turn
        for diameter, value in ((one.diameter, one.s), (n, s)):
            for k, at in ((diameter, value), (-diameter, value.conjugate())):
                if (k - other.diameter) % N == 0 and abs(at - other.s) < SAME:
                    return True
    return False
